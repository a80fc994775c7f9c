//! A controller that is made in code, without a file, and changed while it runs.
//!
//! `cargo run --release --bin in_code`

use std::error::Error;

use wbqp::{ControllerConfig, plugin::Entry};
use wbqp_examples::Live;
use wbqp_robots::Othex;
use wbqp_tasks::{
    ActuatorLimits, BaseOrientation, BasePosition, MinJerk, Posture, PropellerRegularisation,
};

fn main() -> Result<(), Box<dyn Error>> {
    let config = ControllerConfig::at_rate(250.0, Othex::default())
        .with_task(Entry::task(
            "base",
            1.0,
            BasePosition::new([9.0, 9.0, 12.0], 6.0),
        ))
        .with_task(Entry::task(
            "attitude",
            1.0,
            BaseOrientation::new(40.0, 12.0),
        ))
        .with_task(Entry::task("arm", 0.1, Posture::new(25.0, 10.0)).with_transition(0.5))
        .with_task(Entry::task("thrusts", 1e-5, PropellerRegularisation::new()))
        .with_constraint(Entry::constraint("limits", ActuatorLimits::new()));
    println!("# the file that says the same\n{}", config.to_toml()?);
    let mut controller = config.build()?;

    let mut live = Live::from_args(&controller)?; // nothing without `--live`
    let mut measurement = controller.measurement(); // at home, where the robot stays in this program
    controller.tick(&measurement);

    // Between two ticks, by name: the arm goes somewhere else, and counts for more.
    controller.follow("arm", MinJerk::new([0.0, 0.3, 0.9], 2.0))?;
    controller.reweight("arm", 0.5)?; // gets there within the entry's transition

    for tick in 1..=500_u32 {
        measurement.time = f64::from(tick) / controller.settings().rate;
        let (command, report) = controller.tick(&measurement);
        if tick % 125 == 0 {
            let level = report.level.as_str();
            println!(
                "{:.1} s, {level}: joints {:6.2?} rad/s²",
                report.time, command.joint_acceleration
            );
        }
        live.update(&mut controller, &measurement);
    }
    Ok(())
}
