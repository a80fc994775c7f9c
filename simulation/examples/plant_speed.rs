//! How long 25 × 1 s of a hexarotor with a servoed arm against a wall take: `cargo run --release -p wbqp-sim
//! --example plant_speed`.
#![allow(non_snake_case)]

#[path = "../tests/simulation/common.rs"]
mod common;

use std::time::Instant;

use common::{against, hexarotor, hover, wall};
use wbqp_sim::{Plant, PlantCommand, Sensors, SensorsConfig, sensors::ForceTorqueConfig};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let robot = hexarotor();
    let free = Plant::new(&robot, &against(wall()), {
        let mut state = robot.home.clone();
        state.p_WR.x = -1.0;
        state
    })?;
    let tip = free.contact(0).map_or(0.0, |contact| contact.p_WC.x) + 1.0;
    let mut start = robot.home.clone();
    start.p_WR.x = -tip + 1e-4;
    let mut plant = Plant::new(&robot, &against(wall()), start.clone())?;
    let config = SensorsConfig {
        force_torque: vec![ForceTorqueConfig::new("tip")],
        ..SensorsConfig::default()
    };
    let mut command = PlantCommand::rest(&robot);
    let thrusts = hover(&robot, &start);
    command.values_mut()[..6].copy_from_slice(&thrusts[..6]);
    plant.settle_rotors(&command)?;

    // Nobody controls the robot: a new start every second keeps it near the wall.
    let begin = Instant::now();
    for _ in 0..25 {
        let mut plant = plant.clone();
        let mut sensors = Sensors::new(&config, &plant, 1)?;
        for _ in 0..250 {
            sensors.sample(&plant);
            plant.advance_with(&command, 0.004, |plant| sensors.observe(plant))?;
        }
        assert!(!plant.is_diverged(), "the robot got lost");
    }
    println!("25 s in {:.3} s", begin.elapsed().as_secs_f64());
    Ok(())
}
