//! Limits that contradict one another: the tick still has a command, and `explain` says which limits, and by how much.
//!
//! `cargo run --release --bin limits`

use std::error::Error;

use wbqp::{Controller, ControllerConfig};

// Plug-ins are found once their crate is linked, and a crate that no code names is not.
use {wbqp_robots as _, wbqp_tasks as _};

/// Each foot is to press with 60 N at least: more than the motors can.
const FILE: &str = r#"
[controller]
rate = 1000.0

[robot]
type = "quadruped"

[[contact]]
frames = ["fl_foot", "fr_foot", "hl_foot", "hr_foot"]
motion = "hard"
friction = 0.6
force_min = 60.0

[[task]]
type = "com"
kp = 100.0

[[task]]
type = "base_orientation"
kp = 100.0

[[task]]
type = "posture"
kp = 30.0
"#;

fn main() -> Result<(), Box<dyn Error>> {
    let mut controller = Controller::new(ControllerConfig::from_str(FILE, "limits.toml", "")?)?;
    let measurement = controller.measurement(); // at home
    controller.tick(&measurement);
    match controller.explain() {
        Some(why) => println!("{why}"),
        None => println!("all limits are kept"),
    }
    Ok(())
}
