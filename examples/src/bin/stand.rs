//! A quadruped stands: a controller from a file, in a closed loop with a simulated robot.
//!
//! `cargo run --release --bin stand`

use std::{error::Error, path::Path};

use wbqp_examples::Live;
use wbqp_sim::{ClosedLoop, Scenario};

// Plug-ins are found once their crate is linked, and a crate that no code names is not.
use {wbqp_robots as _, wbqp_tasks as _};

/// Seed of the sensors' noise.
const SEED: u64 = 1;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    let scenario = Scenario::from_file(&folder.join("quadruped_short.toml"))?;
    let case = scenario.case("stand")?;
    let mut controller = case.make_controller(case.controller_config()?)?;
    // Plant, sensors and the delay of commands, as the scenario has them.
    let mut robot = ClosedLoop::new(case, &controller, SEED)?;

    let feet: Vec<String> = controller.contact_names().map(str::to_owned).collect();
    println!("t [s]  height [m]  normal force of {} [N]", feet.join(", "));
    let rate = controller.settings().rate;
    let mut live = Live::from_args(&controller)?; // nothing without `--live`
    for tick in 0..case.ticks(rate) {
        let measurement = robot.measure().clone();
        let (command, report) = controller.tick(&measurement);
        if tick % 500 == 0 {
            let height = robot.plant().state().p_WR.z;
            let forces = report.contacts.iter().map(|c| c.solution[2]);
            let forces: Vec<String> = forces.map(|f| format!("{f:6.2}")).collect();
            println!("{:5.1}  {height:10.4}  {}", report.time, forces.join(" "));
        }
        robot.advance(command)?;
        live.update(&mut controller, &measurement);
    }
    Ok(())
}
