//! The integrator: energy, order, rotation, sub-steps, divergence.
#![allow(non_snake_case)]

use nalgebra::{DVector, UnitQuaternion, Vector3};
use wbqp::{actuator::Drive, robot::RobotModel, state::State};
use wbqp_sim::{Plant, PlantCommand, PlantConfig, PlantError, plant::Disturbance};

use crate::common::{
    against, block, carriage, hexarotor, hexarotor_within, hover, rocket, two_links, wall,
};

fn with_step(step: f64) -> PlantConfig {
    PlantConfig {
        step,
        ..PlantConfig::default()
    }
}

/// A hexarotor without motors, tumbling: its joints swing freely.
fn tumbling() -> (RobotModel, State) {
    let mut robot = hexarotor_within(f64::INFINITY);
    robot.actuators.clear();
    let mut state = robot.home.clone();
    state.R_WR = UnitQuaternion::from_euler_angles(0.3, -0.2, 0.9);
    state.v = DVector::from_vec(vec![0.4, -0.3, 2.0, 3.0, -2.0, 4.0, 1.0, -0.5, 0.7]);
    (robot, state)
}

#[test]
fn energy_of_a_tumbling_robot_drifts_with_the_fourth_power_of_the_step() {
    let (robot, mut state) = tumbling();
    // Fast, so that the drift stands out from the rounding of 100 J.
    state.v *= 5.0;
    let drift = |step: f64| {
        let mut plant = Plant::new(&robot, &with_step(step), state.clone()).unwrap();
        let before = plant.energy().total();
        plant.advance(&PlantCommand::rest(&robot), 0.25).unwrap();
        (plant.energy().total() - before).abs()
    };
    let (coarse, fine) = (drift(4e-4), drift(2e-4));
    assert!(coarse < 1e-3, "drift {coarse} J");
    // Energy of a Runge–Kutta method of order 4 drifts at order 4 or 5.
    assert!(coarse / fine > 12.0, "ratio {}", coarse / fine);
}

#[test]
fn halving_the_step_makes_the_error_sixteen_times_smaller() {
    let (robot, state) = tumbling();
    let end = |step: f64| {
        let mut plant = Plant::new(&robot, &with_step(step), state.clone()).unwrap();
        plant.advance(&PlantCommand::rest(&robot), 0.2).unwrap();
        plant.state().clone()
    };
    let distance = |a: &State, b: &State| {
        (&a.q - &b.q).norm()
            + (&a.v - &b.v).norm()
            + (a.p_WR - b.p_WR).norm()
            + a.R_WR.angle_to(&b.R_WR)
    };
    let (coarse, middle, fine) = (end(4e-4), end(2e-4), end(1e-4));
    let ratio = distance(&coarse, &middle) / distance(&middle, &fine);
    assert!((12.0..24.0).contains(&ratio), "ratio {ratio}");
}

#[test]
fn a_servoed_robot_with_changing_thrust_converges_at_fourth_order() {
    let robot = hexarotor();
    let mut command = PlantCommand::rest(&robot);
    command
        .values_mut()
        .copy_from_slice(&[6.0, 7.0, 5.0, 5.2, 6.5, 6.1, 0.4, -0.6, 0.8]);
    let end = |step: f64| {
        let mut plant = Plant::new(&robot, &with_step(step), robot.home.clone()).unwrap();
        plant.advance(&command, 0.1).unwrap();
        plant.state().v.clone()
    };
    let (coarse, middle, fine) = (end(4e-4), end(2e-4), end(1e-4));
    let ratio = (&coarse - &middle).norm() / (&middle - &fine).norm();
    assert!((12.0..24.0).contains(&ratio), "ratio {ratio}");
}

#[test]
fn contact_and_stick_converge_at_fourth_order() {
    let robot = carriage();
    let mut start = robot.home.clone();
    start.q[0] = 5e-4;
    start.v[1] = 1e-3;
    let end = |step: f64| {
        let config = PlantConfig {
            step,
            disturbances: vec![push([10.0, 0.5, 0.0])],
            ..against(wall())
        };
        let mut plant = Plant::new(&robot, &config, start.clone()).unwrap();
        plant.advance(&PlantCommand::rest(&robot), 0.01).unwrap();
        assert!(plant.contact(0).unwrap().in_contact && !plant.contact(0).unwrap().slipping);
        plant.state().q.clone()
    };
    let (coarse, middle, fine) = (end(4e-4), end(2e-4), end(1e-4));
    let ratio = (&coarse - &middle).norm() / (&middle - &fine).norm();
    assert!((10.0..26.0).contains(&ratio), "ratio {ratio}");
}

fn push(force: [f64; 3]) -> Disturbance {
    Disturbance {
        name: wbqp_sim::plant::DISTURBANCE.into(),
        frame: "tip".into(),
        force,
        moment: [0.0; 3],
        from: 0.0,
        until: f64::INFINITY,
    }
}

#[test]
fn a_spinning_block_turns_by_the_angle_and_keeps_a_unit_quaternion() {
    let robot = block();
    let mut state = robot.home.clone();
    // About a principal axis, so the angular velocity stays.
    state.v[5] = 7.0;
    let mut plant = Plant::new(&robot, &PlantConfig::default(), state).unwrap();
    for _ in 0..50 {
        plant.advance(&PlantCommand::rest(&robot), 0.004).unwrap();
    }
    let expected = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 1.4);
    assert!(plant.state().R_WR.angle_to(&expected) < 1e-9);
    assert!((plant.state().R_WR.norm() - 1.0).abs() < 1e-14);
    assert!((plant.time() - 0.2).abs() < 1e-12);
}

#[test]
fn hover_thrusts_hold_the_hexarotor_still() {
    let robot = hexarotor();
    let u = hover(&robot, &robot.home);
    let mut command = PlantCommand::rest(&robot);
    command.values_mut()[..6].copy_from_slice(&u[..6]);
    let mut plant = Plant::new(&robot, &PlantConfig::default(), robot.home.clone()).unwrap();
    plant.settle_rotors(&command).unwrap();
    for _ in 0..250 {
        plant.advance(&command, 0.004).unwrap();
    }
    assert!(plant.state().p_WR.norm() < 1e-9, "{}", plant.state().p_WR);
    assert!(plant.state().v.norm() < 1e-9);
    // The servos hold the arm with the torques of the static equilibrium.
    for (effort, expected) in plant.joint_efforts().iter().zip(&u[6..]) {
        assert!((effort - expected).abs() < 1e-8, "{effort} {expected}");
    }
    assert!(plant.acceleration().norm() < 1e-8);
}

#[test]
fn a_duration_is_cut_into_equal_steps_no_longer_than_the_configured_one() {
    let robot = block();
    let command = PlantCommand::rest(&robot);
    for (duration, steps) in [(0.004, 16), (0.001, 4), (0.0041, 17), (1e-5, 1), (0.0, 0)] {
        let mut plant = Plant::new(&robot, &PlantConfig::default(), robot.home.clone()).unwrap();
        let mut times = Vec::new();
        plant
            .advance_with(&command, duration, |plant| times.push(plant.time()))
            .unwrap();
        assert_eq!(times.len(), steps, "duration {duration}");
        assert!(times.windows(2).all(|t| t[1] > t[0]));
        assert_eq!(plant.time(), duration);
        assert_eq!(times.last().copied().unwrap_or(0.0), duration);
    }
}

#[test]
fn bad_commands_and_durations_are_refused() {
    let robot = rocket();
    let mut plant = Plant::new(&robot, &PlantConfig::default(), robot.home.clone()).unwrap();
    let other = PlantCommand::rest(&hexarotor());
    let error = plant.advance(&other, 0.004).unwrap_err();
    assert_eq!(
        error.to_string(),
        "command has 9 values, the robot has 1 actuators"
    );
    assert_eq!(plant.settle_rotors(&other).unwrap_err(), error);
    let command = PlantCommand::rest(&robot);
    for duration in [f64::NAN, -1.0, f64::INFINITY] {
        let error = plant.advance(&command, duration).unwrap_err();
        assert!(matches!(error, PlantError::Duration(_)), "{error}");
        assert!(
            error
                .to_string()
                .contains("must be finite and not negative")
        );
    }
}

#[test]
fn divergence_is_reported_and_stays() {
    let robot = rocket();
    let mut plant = Plant::new(&robot, &PlantConfig::default(), robot.home.clone()).unwrap();
    assert!(!plant.is_diverged());
    let mut command = PlantCommand::rest(&robot);
    command.values_mut()[0] = f64::NAN;
    plant.advance(&command, 0.004).unwrap();
    assert!(plant.is_diverged());
    plant.advance(&PlantCommand::rest(&robot), 0.004).unwrap();
    assert!(plant.is_diverged());
    assert!((plant.time() - 0.008).abs() < 1e-15);

    // Free fall: 100 m after 4.5 s.
    let mut plant = Plant::new(&robot, &PlantConfig::default(), robot.home.clone()).unwrap();
    plant.advance(&PlantCommand::rest(&robot), 4.0).unwrap();
    assert!(!plant.is_diverged());
    plant.advance(&PlantCommand::rest(&robot), 1.0).unwrap();
    assert!(plant.is_diverged());
}

#[test]
fn disturbance_acts_in_its_window_at_its_frame() {
    let robot = block();
    let config = PlantConfig {
        disturbances: vec![Disturbance {
            name: wbqp_sim::plant::DISTURBANCE.into(),
            frame: "tip".into(),
            force: [-3.5, 0.0, 0.0],
            moment: [0.0, 0.0, 0.08],
            from: 0.1,
            until: 0.3,
        }],
        ..PlantConfig::default()
    };
    let mut plant = Plant::new(&robot, &config, robot.home.clone()).unwrap();
    let command = PlantCommand::rest(&robot);
    for _ in 0..25 {
        plant.advance(&command, 0.004).unwrap();
    }
    assert_eq!(plant.state().v[0], 0.0);
    for _ in 0..75 {
        plant.advance(&command, 0.004).unwrap();
    }
    // Impulse: F T / m and M T / I; the window is 0.2 s to the step.
    assert!((plant.state().v[0] + 3.5 * 0.2 / 2.0).abs() < 1e-9);
    assert!((plant.state().v[5] - 0.08 * 0.2 / 0.04).abs() < 1e-9);

    let late = Disturbance {
        name: wbqp_sim::plant::DISTURBANCE.into(),
        force: [0.0, 2.0, 0.0],
        moment: [0.0; 3],
        from: 0.0,
        until: f64::INFINITY,
        frame: "block".into(),
    };
    plant.disturb(&late).unwrap();
    plant.advance(&command, 0.1).unwrap();
    assert!((plant.state().v[1] - 0.1).abs() < 1e-9);
    let unknown = Disturbance {
        frame: "nose".into(),
        ..late
    };
    assert_eq!(
        plant.disturb(&unknown).unwrap_err().to_string(),
        "disturbance[0].frame: robot `block` has no frame `nose` (known: block, tip)"
    );
}

#[test]
fn the_impulse_of_a_disturbance_is_that_of_its_window() {
    let robot = block();
    // In one step, over an edge of steps, from edge to edge, longer than a period, and over an edge of periods.
    for (from, until) in [
        (0.1001, 0.1002),
        (0.10024, 0.10026),
        (0.1, 0.10025),
        (0.1, 0.101),
        (0.0991, 0.1133),
        (0.103_999, 0.104_001),
        (0.1, 0.100_001),
        (0.1006, f64::INFINITY),
    ] {
        let config = PlantConfig {
            disturbances: vec![Disturbance {
                from,
                until,
                ..push([0.0, 200.0, 0.0])
            }],
            ..PlantConfig::default()
        };
        let mut plant = Plant::new(&robot, &config, robot.home.clone()).unwrap();
        for _ in 0..50 {
            plant.advance(&PlantCommand::rest(&robot), 0.004).unwrap();
        }
        let impulse = 200.0 * (until.min(0.2) - from);
        let found = 2.0 * plant.state().v[1];
        assert!(
            (found - impulse).abs() < 1e-9,
            "{from} {until}: {found} {impulse}"
        );
    }
}

#[test]
fn friction_of_torque_driven_joints_takes_energy() {
    let frictionless = two_links(Drive::Torque, 0.0, 0.0);
    let rough = two_links(Drive::Torque, 0.05, 0.02);
    let swing = |robot: &RobotModel| {
        let mut state = robot.home.clone();
        state.v[0] = 1.0;
        let mut plant = Plant::new(robot, &PlantConfig::default(), state).unwrap();
        let before = plant.energy().total();
        // Short of the elbow's end stop.
        plant.advance(&PlantCommand::rest(robot), 0.1).unwrap();
        plant.energy().total() - before
    };
    assert!(swing(&frictionless).abs() < 1e-8);
    assert!(swing(&rough) < -1e-3);
}
