//! After set-up nothing allocates.
#![allow(non_snake_case)]

#[path = "simulation/common.rs"]
mod common;

use std::alloc::System;

use common::{against, hexarotor, wall};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};
use wbqp_sim::{
    CommandDelay, Plant, PlantCommand, Sensors, SensorsConfig, sensors::ForceTorqueConfig,
};

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Without the test harness, whose threads would be counted too.
fn main() {
    a_control_period_does_not_allocate(None);
    a_control_period_does_not_allocate(Some(1e-7));
    println!("a_control_period_does_not_allocate ... ok");
}

fn a_control_period_does_not_allocate(tolerance: Option<f64>) {
    let robot = hexarotor();
    let mut config = against(wall());
    config.tolerance = tolerance;
    config.walls[0].point = [0.2, 0.0, 0.0];
    let mut plant = Plant::new(&robot, &config, robot.home.clone()).unwrap();
    let sensors = SensorsConfig {
        force_torque: vec![ForceTorqueConfig::new("tip")],
        ..SensorsConfig::default()
    };
    let mut sensors = Sensors::new(&sensors, &plant, 1).unwrap();
    let mut delay = CommandDelay::new(2, PlantCommand::rest(&robot));
    let mut command = PlantCommand::rest(&robot);

    let region = Region::new(ALLOCATOR);
    for k in 0..100 {
        let reading = sensors.sample(&plant);
        command.values_mut()[7] = 0.5 - reading.state.q[1] + f64::from(k % 2);
        let applied = delay.exchange(&command);
        plant
            .advance_with(applied, 0.004, |plant| sensors.observe(plant))
            .unwrap();
    }
    let change = region.change();
    assert_eq!((change.allocations, change.reallocations), (0, 0));
}
