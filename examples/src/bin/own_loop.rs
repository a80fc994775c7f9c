//! A control loop of one's own, around the drivers of a robot: what is to be filled in is in `Driver`.
//!
//! `cargo run --release --bin own_loop [-- --live]`

use std::{error::Error, path::Path};

use wbqp::{Controller, Measurement, controller::Command};
use wbqp_examples::Live;

// Plug-ins are found once their crate is linked, and a crate that no code names is not.
use {wbqp_robots as _, wbqp_tasks as _};

/// The robot's drivers. This stub is a robot that stays where it is, whatever it is told.
struct Driver {
    period: f64,
    ticks: u32,
    sent: Vec<f64>,
}

impl Driver {
    /// Waits for the next period and takes over what the sensors say.
    fn read(&mut self, measurement: &mut Measurement) {
        self.ticks += 1;
        measurement.time = f64::from(self.ticks) * self.period; // of the sensors' clock, s
        // measurement.state: pose and twist of the base, positions and velocities of the joints
        // measurement.wrenches: one per contact, of the sensor at its frame; zero without a sensor
    }

    /// Sends efforts to torque-driven joints (N·m) and rotors (N); servoed joints take `joint_velocity` (rad/s).
    fn write(&mut self, command: &Command) {
        self.sent.copy_from_slice(&command.effort);
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    let mut controller = Controller::from_file(folder.join("quadruped_short.controller.toml"))?;
    let mut measurement = controller.measurement(); // of the right sizes, at home
    let mut driver = Driver {
        period: 1.0 / controller.settings().rate,
        ticks: 0,
        sent: vec![0.0; controller.robot().nu()],
    };
    let mut live = Live::from_args(&controller)?; // nothing without `--live`
    for _ in 0..1000 {
        driver.read(&mut measurement);
        let (command, _) = controller.tick(&measurement);
        driver.write(command); // also after a fault: it is within the actuators' limits
        live.update(&mut controller, &measurement);
        if let Some(why) = controller.explain() {
            eprintln!("{why}"); // in words: not in a real-time loop
        }
    }
    let level = controller.report().level.as_str();
    println!("after {} s, {level}", measurement.time);
    for (actuator, effort) in controller.robot().actuators.iter().zip(&driver.sent) {
        println!("  {:14} {effort:7.3} N·m", actuator.name);
    }
    Ok(())
}
