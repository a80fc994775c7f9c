//! What somebody does to a plant while it runs: pulls at the robot, moves a wall.
#![allow(non_snake_case)]

use nalgebra::{Point3, Vector3};
use wbqp_sim::{Plant, PlantCommand, PlantConfig, plant::Disturbance};

use crate::common::{against, block, carriage, wall};

fn run(plant: &mut Plant, duration: f64) {
    let command = PlantCommand::rest(plant.robot());
    plant.advance(&command, duration).unwrap();
}

/// A pull at a point is a force and its moment about the frame's origin, to the last bit where the arm is none.
#[test]
fn a_pull_is_the_disturbance_of_the_same_wrench() {
    let robot = block();
    let force = Vector3::new(1.0, -2.0, 25.0);
    let disturbed = Disturbance {
        name: "hand".into(),
        frame: "tip".into(),
        force: force.into(),
        moment: [0.0; 3],
        from: 0.0,
        until: f64::INFINITY,
    };
    let config = PlantConfig {
        disturbances: vec![disturbed],
        ..PlantConfig::default()
    };
    let mut disturbed = Plant::new(&robot, &config, robot.home.clone()).unwrap();
    let mut pulled = Plant::new(&robot, &PlantConfig::default(), robot.home.clone()).unwrap();
    let tip = robot.model.frame("tip").unwrap();
    pulled.pull(tip, Point3::origin(), force);
    run(&mut disturbed, 0.5);
    run(&mut pulled, 0.5);
    assert!((pulled.state().p_WR - disturbed.state().p_WR).norm() < 1e-12);
    // F t²/2m, less the fall.
    let z = 0.5 * (25.0 / 2.0 - 9.81) * 0.25;
    assert!((pulled.state().p_WR.z - z).abs() < 1e-9);
}

#[test]
fn a_pull_beside_the_centre_turns_the_body_and_letting_go_ends_it() {
    let robot = block();
    let tip = robot.model.frame("tip").unwrap();
    let mut plant = Plant::new(&robot, &PlantConfig::default(), robot.home.clone()).unwrap();
    plant.pull(tip, Point3::new(0.5, 0.0, 0.0), Vector3::new(0.0, 0.1, 0.0));
    run(&mut plant, 0.01);
    // 0.05 N·m about 0.04 kg·m².
    let turned = plant.state().v[5];
    assert!((turned - 0.05 / 0.04 * 0.01).abs() < 1e-9, "{turned}");
    plant.pull(tip, Point3::origin(), Vector3::zeros());
    let sideways = plant.state().v[1];
    run(&mut plant, 0.1);
    assert_eq!(plant.state().v[1].to_bits(), sideways.to_bits());
}

#[test]
fn what_is_not_finite_pulls_and_moves_nothing() {
    let robot = carriage();
    let tip = robot.model.frame("tip").unwrap();
    let mut plant = Plant::new(&robot, &against(wall()), robot.home.clone()).unwrap();
    plant.pull(tip, Point3::origin(), Vector3::new(f64::NAN, 0.0, 0.0));
    assert!(!plant.move_wall("wall", Vector3::new(f64::INFINITY, 0.0, 0.0)));
    assert!(!plant.move_wall("ground", Vector3::zeros()));
    run(&mut plant, 0.1);
    assert_eq!(plant.state().q, robot.home.q);
}

#[test]
fn a_wall_that_is_moved_takes_what_leans_on_it_along() {
    let robot = carriage();
    let tip = robot.model.frame("tip").unwrap();
    let mut plant = Plant::new(&robot, &against(wall()), robot.home.clone()).unwrap();
    plant.pull(tip, Point3::origin(), Vector3::new(5.0, 0.0, 0.0));
    run(&mut plant, 2.0);
    for step in 1..=100 {
        assert!(plant.move_wall("wall", Vector3::new(-1e-4 * f64::from(step), 0.0, 0.0)));
        run(&mut plant, 0.01);
    }
    run(&mut plant, 2.0);
    // A centimetre, and the penetration of 5 N.
    let truth = plant.contact(0).unwrap();
    assert!((truth.p_WC.x - (-0.01 + 5.0 / 2e4)).abs() < 1e-9);
    assert!((truth.normal_force - 5.0).abs() < 1e-9);
    assert_eq!(plant.config().walls[0].point, [-0.01, 0.0, 0.0]);
}
