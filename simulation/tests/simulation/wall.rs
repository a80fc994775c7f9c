//! Contact: rest, stick, slip, opening and closing.
#![allow(non_snake_case)]

use nalgebra::Vector3;
use wbqp_sim::{
    Plant, PlantCommand, PlantConfig,
    plant::{ContactTruth, Disturbance, WallConfig},
};

use crate::common::{against, block, carriage, hexarotor, wall};

fn push(force: [f64; 3], from: f64, until: f64) -> Disturbance {
    Disturbance {
        name: wbqp_sim::plant::DISTURBANCE.into(),
        frame: "tip".into(),
        force,
        moment: [0.0; 3],
        from,
        until,
    }
}

/// The carriage against the wall, pushed by forces that start together.
fn pushed(wall: WallConfig, pushes: Vec<Disturbance>) -> Plant {
    let robot = carriage();
    let config = PlantConfig {
        disturbances: pushes,
        ..against(wall)
    };
    Plant::new(&robot, &config, robot.home.clone()).unwrap()
}

fn run(plant: &mut Plant, duration: f64) {
    let command = PlantCommand::rest(plant.robot());
    plant.advance(&command, duration).unwrap();
}

fn truth(plant: &Plant) -> ContactTruth {
    *plant.contact(0).unwrap()
}

fn always(force: [f64; 3]) -> Disturbance {
    push(force, 0.0, f64::INFINITY)
}

#[test]
fn at_rest_the_penetration_is_force_over_stiffness() {
    let mut plant = pushed(wall(), vec![always([5.0, 0.0, 0.0])]);
    run(&mut plant, 2.0);
    let contact = truth(&plant);
    assert!(contact.in_contact && !contact.slipping);
    assert!((contact.penetration - 5.0 / 2e4).abs() < 1e-12);
    assert!((contact.normal_force - 5.0).abs() < 1e-9);
    assert!((contact.force_W - Vector3::new(-5.0, 0.0, 0.0)).norm() < 1e-9);
    assert!((contact.p_WC.x - 2.5e-4).abs() < 1e-12);
}

#[test]
fn an_open_contact_has_no_force_and_a_negative_penetration() {
    let robot = carriage();
    let mut state = robot.home.clone();
    state.q[0] = -0.01;
    let plant = Plant::new(&robot, &against(wall()), state).unwrap();
    let contact = truth(&plant);
    assert!(!contact.in_contact);
    assert!((contact.penetration + 0.01).abs() < 1e-15);
    assert_eq!(contact.force_W, Vector3::zeros());
}

#[test]
fn below_the_cone_the_point_sticks_and_does_not_creep() {
    let mut plant = pushed(
        wall(),
        vec![always([5.0, 0.0, 0.0]), always([0.0, 1.2, 2.1])],
    );
    run(&mut plant, 1.0);
    // |f_t| = 2.42 N of 2.5 N.
    assert!(!truth(&plant).slipping);
    let early = plant.state().q.clone();
    run(&mut plant, 20.0);
    let contact = truth(&plant);
    assert!((&plant.state().q - &early).amax() < 1e-13);
    assert!((contact.force_W - Vector3::new(-5.0, -1.2, -2.1)).norm() < 1e-9);
    assert_eq!(contact.slip_velocity_W, Vector3::zeros());
}

#[test]
fn a_sticking_point_yields_by_force_over_tangential_stiffness() {
    let pushes = vec![
        always([5.0, 0.0, 0.0]),
        push([0.0, 1.0, 1.5], 0.5, f64::INFINITY),
    ];
    let mut plant = pushed(wall(), pushes);
    run(&mut plant, 1.5);
    assert!((plant.state().q[1] - 1.0 / 2e4).abs() < 1e-12);
    assert!((plant.state().q[2] - 1.5 / 2e4).abs() < 1e-12);
}

#[test]
fn shaking_below_the_cone_does_not_ratchet() {
    let mut plant = pushed(wall(), vec![always([5.0, 0.0, 0.0])]);
    run(&mut plant, 0.5);
    let mut offset = 0.0;
    for k in 0..2000 {
        let from = plant.time();
        let force = if k % 2 == 0 { 1.0 } else { -1.0 };
        plant
            .disturb(&push([0.0, force, 0.6], from, from + 0.01))
            .unwrap();
        run(&mut plant, 0.01);
        if k == 200 {
            offset = plant.state().q[2];
        }
    }
    assert!((plant.state().q[2] - offset).abs() < 1e-6);
    assert!(plant.state().q[2] < 2.0 * 0.6 / 2e4);
}

#[test]
fn above_the_cone_the_point_slips_against_a_force_of_exactly_mu_times_normal() {
    let mut plant = pushed(
        wall(),
        vec![always([5.0, 0.0, 0.0]), always([0.0, 3.0, 0.0])],
    );
    run(&mut plant, 0.5);
    let contact = truth(&plant);
    assert!(contact.slipping);
    let tangential = Vector3::new(0.0, contact.force_W.y, contact.force_W.z);
    assert!((tangential.norm() - 0.5 * contact.normal_force).abs() < 1e-12);
    assert!((tangential - Vector3::new(0.0, -2.5, 0.0)).norm() < 1e-9);
    // 0.5 N are left to accelerate 0.2 kg.
    assert!((plant.acceleration()[1] - 2.5).abs() < 1e-2);
    assert!((contact.slip_velocity_W - contact.v_WC).norm() < 0.02 * contact.v_WC.norm());
}

#[test]
fn a_slip_stops_when_the_push_ends_and_the_point_sticks_where_it_stopped() {
    let pushes = vec![always([5.0, 0.0, 0.0]), push([0.0, 4.0, 0.0], 0.2, 0.3)];
    let mut plant = pushed(wall(), pushes);
    run(&mut plant, 0.3);
    let speed = plant.state().v[1];
    let at = plant.state().q[1];
    run(&mut plant, 2.0);
    // v²/2 = (μ f_n / m) d.
    let distance = speed * speed / 2.0 / (2.5 / 0.2);
    assert!(
        (plant.state().q[1] - at - distance).abs() < 3e-4,
        "{distance}"
    );
    assert!(!truth(&plant).slipping);
    assert!(plant.state().v.amax() < 1e-9);
    // What is left in the spring has swung out: no tangential force holds it.
    assert!(truth(&plant).force_W.y.abs() < 1e-6);
}

#[test]
fn friction_follows_the_direction_of_a_turning_slide() {
    let mut plant = pushed(wall(), vec![always([5.0, 0.0, 0.0])]);
    run(&mut plant, 0.2);
    for k in 0..400 {
        let angle = 0.02 * f64::from(k);
        let from = plant.time();
        let force = [0.0, 4.0 * angle.cos(), 4.0 * angle.sin()];
        plant.disturb(&push(force, from, from + 0.002)).unwrap();
        run(&mut plant, 0.002);
        let contact = truth(&plant);
        if k > 100 && contact.v_WC.yz().norm() > 0.3 {
            let (force, speed) = (contact.force_W.yz(), contact.v_WC.yz());
            assert!(contact.slipping);
            assert!((force.norm() - 0.5 * contact.normal_force).abs() < 1e-9);
            let cosine = force.dot(&speed) / force.norm() / speed.norm();
            assert!(cosine < -0.99, "step {k}: {cosine}");
        }
    }
}

#[test]
fn viscous_friction_adds_to_coulomb_friction() {
    let viscous = WallConfig {
        viscous: 10.0,
        ..wall()
    };
    let mut plant = pushed(
        viscous,
        vec![always([5.0, 0.0, 0.0]), always([0.0, 3.5, 0.0])],
    );
    run(&mut plant, 1.0);
    // Steady slide: 3.5 = 2.5 + b v.
    assert!((plant.state().v[1] - 0.1).abs() < 1e-6);
}

#[test]
fn no_friction_means_no_tangential_force() {
    let ice = WallConfig {
        friction: 0.0,
        ..wall()
    };
    let mut plant = pushed(ice, vec![always([5.0, 0.0, 0.0]), always([0.0, 1.0, 0.0])]);
    run(&mut plant, 0.2);
    // The rails have a little mass too.
    assert!((plant.state().v[1] - 1.0).abs() < 1e-5);
    assert_eq!(truth(&plant).force_W.y, 0.0);
}

#[test]
fn the_wall_never_pulls_and_the_anchor_never_exceeds_the_cone() {
    let robot = carriage();
    let mut state = robot.home.clone();
    state.q[0] = -0.002;
    state.v[0] = 0.2;
    state.v[1] = 0.15;
    let config = PlantConfig {
        disturbances: vec![always([1.0, 0.0, 0.0])],
        ..against(wall())
    };
    let mut plant = Plant::new(&robot, &config, state).unwrap();
    let (mut touched, mut opened) = (0, 0);
    let command = PlantCommand::rest(&robot);
    for _ in 0..500 {
        plant
            .advance_with(&command, 0.004, |plant| {
                let contact = truth(plant);
                assert!(contact.normal_force >= 0.0 && contact.force_W.x <= 0.0);
                assert!(
                    contact.force_W.yz().norm() <= 0.5 * contact.normal_force + 1e-12,
                    "{contact:?}"
                );
                if contact.in_contact {
                    touched += 1;
                } else if touched > 0 {
                    opened += 1;
                }
            })
            .unwrap();
    }
    // It bounces, then rests.
    assert!(touched > 0 && opened > 0);
    assert!((truth(&plant).normal_force - 1.0).abs() < 1e-6);
    assert!(plant.state().v.amax() < 1e-6);
}

#[test]
fn touching_again_elsewhere_starts_without_tangential_force() {
    let pushes = vec![
        push([5.0, 0.0, 0.0], 0.0, 0.2),
        push([0.0, 2.0, 0.0], 0.0, 0.2),
        push([-0.2, 0.2, 0.0], 0.2, 0.4),
        push([0.5, 0.0, 0.0], 0.4, f64::INFINITY),
    ];
    let mut plant = pushed(wall(), pushes);
    let command = PlantCommand::rest(&carriage());
    let mut away = false;
    let mut first = None;
    plant
        .advance_with(&command, 2.0, |plant| {
            let contact = truth(plant);
            away |= contact.penetration < -0.005;
            if away && contact.in_contact && first.is_none() {
                first = Some((contact, plant.state().v[1]));
            }
        })
        .unwrap();
    let (contact, speed) = first.unwrap();
    // Only the damper can act at the first moment, and no more than the cone allows.
    let most = (60.0 * speed.abs() + 2e4 * speed.abs() * 2.5e-4).min(0.5 * contact.normal_force);
    assert!(
        contact.force_W.y.abs() <= most + 1e-12,
        "{contact:?} {speed}"
    );
}

#[test]
fn a_block_rests_on_the_ground_with_offset_points_and_several_walls() {
    let robot = block();
    let mut ground = WallConfig::new("ground", Vector3::new(0.0, 0.0, -0.05), Vector3::z());
    ground.damping = 200.0;
    let mut config = against(ground);
    config.walls.push(wall());
    config.contact_points = [[0.1, 0.1], [0.1, -0.1], [-0.1, 0.1], [-0.1, -0.1]]
        .map(|[x, y]| wbqp_sim::plant::ContactPointConfig {
            frame: "block".into(),
            offset: [x, y, -0.05],
        })
        .to_vec();
    let mut state = robot.home.clone();
    state.p_WR.x = -0.5;
    let mut plant = Plant::new(&robot, &config, state).unwrap();
    run(&mut plant, 2.0);
    assert_eq!(plant.contact_count(), 8);
    let mut sum = 0.0;
    for (point, wall, contact) in plant.contacts() {
        assert_eq!(contact.in_contact, wall.name == "ground", "{point:?}");
        sum += contact.normal_force;
        if contact.in_contact {
            assert!((contact.normal_force - 2.0 * 9.81 / 4.0).abs() < 1e-6);
        }
    }
    assert!((sum - 2.0 * 9.81).abs() < 1e-6);
    assert!(plant.state().v.amax() < 1e-6);
    assert!(plant.contact(8).is_none());
}

#[test]
fn the_wrench_at_a_frame_is_in_its_axes_about_its_origin() {
    let robot = hexarotor();
    let mut config = against(wall());
    config.contact_points[0].offset = [0.0, 0.0, 0.02];
    let tip = robot.model.frame("tip").unwrap();
    let plant = Plant::new(&robot, &PlantConfig::default(), robot.home.clone()).unwrap();
    let at = plant.frame_motion(tip);
    let x = at.p_WF + at.R_WF * Vector3::new(0.0, 0.0, 0.02);
    config.walls[0].point = [x.x - 1e-4, 0.0, 0.0];
    let plant = Plant::new(&robot, &config, robot.home.clone()).unwrap();
    let contact = truth(&plant);
    assert!((contact.normal_force - 2.0).abs() < 1e-9);
    let wrench = plant.wrench_at(tip);
    let force = at.R_WF.inverse() * Vector3::new(-2.0, 0.0, 0.0);
    let moment = Vector3::new(0.0, 0.0, 0.02).cross(&force);
    assert!((wrench.fixed_rows::<3>(0) - force).norm() < 1e-9);
    assert!((wrench.fixed_rows::<3>(3) - moment).norm() < 1e-9);
    // No wall touches the base.
    assert_eq!(plant.wrench_at(robot.model.base_frame()).norm(), 0.0);
}
