//! Motors, servos, end stops, delay.
#![allow(non_snake_case)]

use wbqp::{
    actuator::{ActuatorKind, Drive},
    controller::Command,
};
use wbqp_sim::{
    CommandDelay, Plant, PlantCommand, PlantConfig,
    plant::{Disturbance, Mismatch, ServoConfig},
};

use crate::common::{FALL, RISE, STALL, hexarotor, rocket, two_links};

fn commanded(robot: &wbqp::robot::RobotModel, values: &[f64]) -> PlantCommand {
    let mut command = PlantCommand::rest(robot);
    command.values_mut().copy_from_slice(values);
    command
}

#[test]
fn a_servo_takes_its_velocity_and_a_motor_its_effort() {
    // The actuators are not in the order of the joints: efforts follow the one, velocities the other.
    let mut robot = two_links(Drive::Torque, 0.0, 0.0);
    robot.actuators.reverse();
    let ActuatorKind::Joint(elbow) = &mut robot.actuators[0].kind else {
        panic!("is a joint's motor")
    };
    elbow.drive = Drive::Velocity;
    let computed = Command {
        effort: vec![1.0, 2.0],
        rotor_speed: vec![0.0; 2],
        joint_acceleration: vec![5.0, 6.0],
        joint_velocity: vec![0.3, 0.4],
    };
    let mut command = PlantCommand::of(&robot, &computed);
    assert_eq!(command.values(), [0.4, 2.0]);

    // What another robot's command lacks stays.
    let short = Command {
        effort: vec![7.0],
        joint_velocity: vec![0.5],
        ..computed
    };
    command.take(&robot, &short);
    assert_eq!(command.values(), [0.4, 2.0]);
}

#[test]
fn motors_reach_63_percent_after_their_time_constant_up_and_down() {
    let robot = rocket();
    let mut plant = Plant::new(&robot, &PlantConfig::default(), robot.home.clone()).unwrap();
    assert_eq!(plant.thrusts(), [0.25]);
    let part = 1.0 - (-1.0_f64).exp();
    plant.advance(&commanded(&robot, &[8.25]), RISE).unwrap();
    assert!((plant.thrusts()[0] - (0.25 + 8.0 * part)).abs() < 1e-6);
    plant.settle_rotors(&commanded(&robot, &[8.25])).unwrap();
    assert_eq!(plant.thrusts(), [8.25]);
    plant.advance(&commanded(&robot, &[0.25]), FALL).unwrap();
    assert!((plant.thrusts()[0] - (8.25 - 8.0 * part)).abs() < 1e-6);
}

#[test]
fn thrust_is_cut_off_at_the_limits_and_scaled_by_the_mismatch() {
    let robot = rocket();
    let config = PlantConfig {
        mismatch: Mismatch {
            thrust_scale: 0.85,
            ..Mismatch::default()
        },
        ..PlantConfig::default()
    };
    let mut plant = Plant::new(&robot, &config, robot.home.clone()).unwrap();
    plant.advance(&commanded(&robot, &[50.0]), 0.5).unwrap();
    assert!((plant.thrusts()[0] - 8.5).abs() < 1e-9);
    plant.advance(&commanded(&robot, &[-50.0]), 0.8).unwrap();
    assert!((plant.thrusts()[0] - 0.85 * 0.25).abs() < 1e-9);
}

#[test]
fn a_rotor_pushes_along_its_axis_and_turns_against_its_drag() {
    let robot = rocket();
    let mut plant = Plant::new(&robot, &PlantConfig::default(), robot.home.clone()).unwrap();
    plant.settle_rotors(&commanded(&robot, &[9.0])).unwrap();
    let vdot = plant.acceleration();
    assert!((vdot[2] - (9.0 - 9.81)).abs() < 1e-12);
    assert!((vdot[5] - 0.0192 * 9.0 / 0.01).abs() < 1e-12);
    assert!(vdot[0].abs() + vdot[1].abs() + vdot[3].abs() + vdot[4].abs() < 1e-12);
}

#[test]
fn weak_rotors_produce_less_than_was_commanded() {
    let robot = hexarotor();
    let thrusts = |mismatch: Mismatch| {
        let config = PlantConfig {
            mismatch,
            ..PlantConfig::default()
        };
        let mut plant = Plant::new(&robot, &config, robot.home.clone()).unwrap();
        let mut command = PlantCommand::rest(&robot);
        command.values_mut()[..2].copy_from_slice(&[4.0, 9.0]);
        plant.settle_rotors(&command).unwrap();
        [plant.thrusts()[0], plant.thrusts()[1]]
    };
    let with = |thrust_scale, thrust_max| Mismatch {
        thrust_scale,
        thrust_max,
        ..Mismatch::default()
    };
    assert_eq!(thrusts(with(1.0, f64::INFINITY)), [4.0, 9.0]);
    assert_eq!(thrusts(with(1.0, 7.0)), [4.0, 7.0]);
    assert_eq!(thrusts(with(0.5, 7.0)), [2.0, 4.5]);
    let dead = Mismatch {
        rotor_scales: vec![0.0, 0.5, 1.0, 1.0, 1.0, 1.0],
        ..Mismatch::default()
    };
    assert_eq!(thrusts(dead), [0.0, 4.5]);
}

#[test]
fn mismatch_changes_the_plants_model_only() {
    let robot = hexarotor();
    let config = PlantConfig {
        mismatch: Mismatch {
            mass_scale: 1.05,
            com_shift: [0.01, 0.0, 0.0],
            inertia_scale: 1.2,
            ..Mismatch::default()
        },
        ..PlantConfig::default()
    };
    let plant = Plant::new(&robot, &config, robot.home.clone()).unwrap();
    let (own, theirs) = (&robot.model.bodies(), plant.model().bodies());
    assert!((plant.model().mass() / robot.model.mass() - 1.05).abs() < 1e-12);
    let shift = theirs[0].inertia.com() - own[0].inertia.com();
    assert!((shift.x - 0.01).abs() < 1e-12 && shift.yz().norm() < 1e-12);
    let arm_shift = theirs[2].inertia.com() - own[2].inertia.com();
    assert!(arm_shift.norm() < 1e-12);
    let ratio = theirs[2].inertia.I_BBcm()[(0, 0)] / own[2].inertia.I_BBcm()[(0, 0)];
    assert!((ratio - 1.05 * 1.2).abs() < 1e-9);
    assert!(!std::ptr::eq(plant.model(), robot.model.as_ref()));
}

#[test]
fn a_servo_follows_a_velocity_ramp_with_the_lag_of_its_time_constant() {
    let robot = hexarotor();
    let mut plant = Plant::new(&robot, &PlantConfig::default(), robot.home.clone()).unwrap();
    let (rate, period) = (2.0, 0.001);
    let mut command = PlantCommand::rest(&robot);
    for k in 0..300 {
        command.values_mut()[7] = rate * f64::from(k) * period;
        plant.advance(&command, period).unwrap();
    }
    // The reference is held for a period, on average half a period late.
    let reference = rate * 300.0 * period;
    let expected = reference - rate * (0.03 + 0.5 * period);
    let joint = plant.state().v[7];
    assert!((joint - expected).abs() < 1.2e-3, "{joint} {expected}");
}

#[test]
fn servo_acceleration_and_speed_are_limited() {
    let robot = hexarotor();
    let config = PlantConfig {
        servo: ServoConfig {
            time_constant: 0.03,
            acceleration_limit: 20.0,
        },
        ..PlantConfig::default()
    };
    let mut plant = Plant::new(&robot, &config, robot.home.clone()).unwrap();
    let mut command = PlantCommand::rest(&robot);
    command.values_mut()[8] = -3.0;
    plant.advance(&command, 0.05).unwrap();
    assert!((plant.state().v[8] + 1.0).abs() < 1e-9);
    assert!((plant.acceleration()[8] + 20.0).abs() < 1e-9);

    // The joint cannot be faster than 5 rad/s, whatever is asked for.
    let mut plant = Plant::new(&robot, &PlantConfig::default(), robot.home.clone()).unwrap();
    command.values_mut()[8] = -50.0;
    plant.advance(&command, 0.3).unwrap();
    assert!(plant.state().v[8] > -5.0 && plant.state().v[8] < -4.9);
}

#[test]
fn a_servo_stops_at_its_limit_without_overshoot() {
    let robot = hexarotor();
    let mut plant = Plant::new(&robot, &PlantConfig::default(), robot.home.clone()).unwrap();
    let mut command = PlantCommand::rest(&robot);
    command.values_mut()[8] = 2.0;
    let mut highest = 0.0_f64;
    for _ in 0..500 {
        plant
            .advance_with(&command, 0.004, |p| highest = highest.max(p.state().q[2]))
            .unwrap();
    }
    assert!(highest <= 1.8 + 1e-9, "{highest}");
    assert!(plant.state().q[2] > 1.799, "{}", plant.state().q[2]);
    assert!(plant.state().v[8].abs() < 1e-3);
}

#[test]
fn a_torque_driven_joint_is_caught_by_its_end_stop() {
    let robot = two_links(Drive::Torque, 0.0, 0.0);
    let mut plant = Plant::new(&robot, &PlantConfig::default(), robot.home.clone()).unwrap();
    let command = commanded(&robot, &[0.0, 2.0]);
    let mut highest = 0.0_f64;
    for _ in 0..250 {
        plant
            .advance_with(&command, 0.004, |p| highest = highest.max(p.state().q[1]))
            .unwrap();
    }
    assert!(highest > 1.0 && highest < 1.05, "{highest}");
    assert!(!plant.is_diverged());
}

/// A two-link arm whose first joint carries `load` N·m of a disturbance about y.
fn loaded(load: f64) -> Plant {
    let robot = two_links(Drive::Velocity, 0.0, 0.0);
    let config = PlantConfig {
        disturbances: vec![Disturbance {
            name: wbqp_sim::plant::DISTURBANCE.into(),
            frame: "shoulder_link".into(),
            force: [0.0; 3],
            moment: [0.0, load, 0.0],
            from: 0.0,
            until: f64::INFINITY,
        }],
        ..PlantConfig::default()
    };
    Plant::new(&robot, &config, robot.home.clone()).unwrap()
}

#[test]
fn a_servo_holds_until_its_stall_effort_and_then_gives_way_with_it() {
    // Gravity at the shoulder: 0.5 kg at 0.15 m and 0.5 kg at 0.45 m, about +y.
    let weight = 0.5 * 9.81 * (0.15 + 0.45);
    let mut plant = loaded(STALL - weight - 0.1);
    let rest = PlantCommand::rest(plant.robot());
    plant.advance(&rest, 0.1).unwrap();
    assert!(plant.state().v.amax() < 1e-12);
    assert!((plant.joint_efforts()[0] + STALL - 0.1).abs() < 1e-9);
    assert_eq!(plant.stalled(), [false, false]);

    let mut plant = loaded(STALL - weight + 0.5);
    assert_eq!(plant.stalled(), [true, false]);
    assert_eq!(plant.joint_efforts()[0], -STALL);
    assert_eq!(plant.acceleration()[1], 0.0);
    assert!(plant.acceleration()[0] > 0.1);
    plant.advance(&rest, 0.02).unwrap();
    assert!(plant.state().v[0] > 0.01);
}

#[test]
fn a_command_is_applied_after_its_delay() {
    let robot = rocket();
    let initial = commanded(&robot, &[1.0]);
    for periods in [0, 1, 3] {
        let mut delay = CommandDelay::new(periods, initial.clone());
        for k in 0..8 {
            let computed = commanded(&robot, &[2.0 + k as f64]);
            let applied = delay.exchange(&computed).values()[0];
            let expected = if k < periods {
                1.0
            } else {
                2.0 + (k - periods) as f64
            };
            assert_eq!(applied, expected, "delay {periods}, sample {k}");
        }
    }
}
