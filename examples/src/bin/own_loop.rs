//! A control loop of one's own, around the drivers of a robot: what is to be filled in is in `Driver`.
//!
//! `cargo run --release --bin own_loop`

use std::{error::Error, path::Path};

use wbqp::{Controller, Measurement, controller::Command, state::State};

// Plug-ins are found once their crate is linked, and a crate that no code names is not.
use {wbqp_robots as _, wbqp_tasks as _};

/// The robot's drivers. This stub is a robot that stays where it is, whatever it is told.
struct Driver {
    state: State,
    period: f64,
    time: f64,
}

impl Driver {
    /// Waits for the next period and takes over what the sensors say; nothing here may allocate in a real-time loop.
    fn read(&mut self, measurement: &mut Measurement) {
        self.time += self.period;
        measurement.time = self.time; // of the sensors' clock, s
        measurement.state.copy_from(&self.state); // pose and twist of the base, positions and velocities of the joints
        // measurement.wrenches: one per contact, of the sensor at its frame; zero without a sensor.
    }

    /// Sends efforts to torque-driven joints (N·m) and rotors (N); servoed joints take `joint_velocity` (rad/s).
    fn write(&mut self, _: &Command) {}
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    let mut controller = Controller::from_file(folder.join("quadruped_short.controller.toml"))?;
    let mut measurement = controller.measurement(); // of the right sizes, at home
    let mut driver = Driver {
        state: measurement.state.clone(),
        period: 1.0 / controller.settings().rate,
        time: 0.0,
    };
    for _ in 0..1000 {
        driver.read(&mut measurement);
        let (command, _) = controller.tick(&measurement);
        driver.write(command); // always: the command is within the actuators' limits, also after a fault
        if let Some(why) = controller.explain() {
            eprintln!("{why}"); // in words: not in a real-time loop
        }
    }
    println!(
        "after {} s, {}",
        driver.time,
        controller.report().rung.as_str()
    );
    for (actuator, effort) in controller
        .robot()
        .actuators
        .iter()
        .zip(&controller.command().effort)
    {
        println!("  {:14} {effort:7.3} N·m", actuator.name);
    }
    Ok(())
}
