//! Limits that contradict one another: the tick still has a command, and `explain` says which limits, and by how much.
//!
//! `cargo run --release --bin limits`

use std::error::Error;

use wbqp::{Controller, ControllerConfig};
use wbqp_examples::Live;

// Plug-ins are found once their crate is linked, and a crate that no code names is not.
use {wbqp_robots as _, wbqp_tasks as _};

/// The base is to keep 1.3 m from the floor and 0.9 m from the ceiling, in a room of 2 m.
const FILE: &str = r#"
[controller]
rate = 250.0

[robot]
type = "othex"

[[task]]
type = "base_position"
kp = 9.0

[[task]]
type = "base_orientation"
kp = 40.0

[[task]]
type = "posture"
kp = 25.0

[[constraint]]
name = "above the floor"
type = "plane_distance"
frame = "base_link"
point = [0.0, 0.0, 0.0]
normal = [0.0, 0.0, 1.0]
margin = 1.3

[[constraint]]
name = "below the ceiling"
type = "plane_distance"
frame = "base_link"
point = [0.0, 0.0, 2.0]
normal = [0.0, 0.0, -1.0]
margin = 0.9
"#;

fn main() -> Result<(), Box<dyn Error>> {
    let mut controller = Controller::new(ControllerConfig::from_str(FILE, "limits.toml", "")?)?;
    let mut live = Live::from_args(&controller)?; // nothing without `--live`
    let mut measurement = controller.measurement(); // at home
    controller.tick(&measurement);
    if let Some(why) = controller.explain() {
        println!("{why}");
    }
    // With a live view, until the program is ended: there, `margin` of the ceiling can be made smaller.
    while live.is_on() {
        measurement.time += 0.004;
        controller.tick(&measurement);
        live.update(&mut controller, &measurement);
    }
    Ok(())
}
