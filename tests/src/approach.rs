//! Experiment B close to its wall, without noise and disturbance: a contact to switch and to push on.

use wbqp::{
    config::{ControllerConfig, Overrides},
    controller::Controller,
    nalgebra::Vector3,
    state::State,
};
use wbqp_sim::{
    PlantConfig, SensorsConfig,
    plant::{ContactPointConfig, WallConfig},
    sensors::ForceTorqueConfig,
};
use wbqp_tasks::MinJerk;

use crate::{closed_loop::ClosedLoop, files::scenarios};

/// Base position 2 cm before the tip touches, m.
pub const BEFORE: [f64; 3] = [-0.14, 0.0, 1.258];
/// Base position 5 cm beyond, m.
pub const BEYOND: [f64; 3] = [-0.0688, 0.0, 1.258];

/// The controller of experiment B as it ships, with overrides.
///
/// # Panics
/// If the overrides do not fit the controller.
pub fn experiment(overrides: &Overrides) -> ControllerConfig {
    let file = scenarios().join("push_with_disturbance.controller.toml");
    ControllerConfig::from_file_with(file, overrides).expect("ships")
}

/// The wall that is pushed on.
pub fn wall() -> WallConfig {
    WallConfig::new("wall", Vector3::zeros(), -Vector3::x())
}

/// The controller on a plant without noise and disturbance: the tip touches, and its force is measured.
///
/// # Panics
/// If the robot has no frame `tool`, or the plant refuses the state.
pub fn simulated(controller: Controller, walls: Vec<WallConfig>, initial: State) -> ClosedLoop {
    let tip = ContactPointConfig {
        frame: "tool".into(),
        offset: [0.0; 3],
    };
    let plant = PlantConfig {
        walls,
        contact_points: vec![tip],
        ..PlantConfig::default()
    };
    let sensors = SensorsConfig {
        force_torque: vec![ForceTorqueConfig::new("tool")],
        ..SensorsConfig::default()
    };
    ClosedLoop::new(controller, &plant, &sensors, initial).expect("can be simulated")
}

/// About to go from [`BEFORE`] to [`BEYOND`] within 2 s; the tip touches after about 0.8 s.
///
/// # Panics
/// If the overrides do not fit the controller.
pub fn approaching(overrides: &Overrides) -> ClosedLoop {
    let controller = Controller::new(experiment(overrides)).expect("fits the robot");
    let mut initial = controller.robot().home.clone();
    initial.p_WR = Vector3::from(BEFORE);
    let mut running = simulated(controller, vec![wall()], initial);
    let approach = MinJerk::new(BEYOND, 2.0).starting_at(BEFORE);
    running
        .controller
        .follow("base_position", approach)
        .expect("follows");
    running
}
