//! Runs an experiment's scenario in memory and prints what was measured.
//!
//! `cargo run --release --bin experiment push_away`

use std::{env, error::Error, path::Path};

use wbqp_examples::live_port;
use wbqp_measures::{
    Cases, Recording, experiments,
    log::{Log, Recorder},
    number,
};
use wbqp_sim::{LiveWatcher, RunOptions, Scenario};

// Plug-ins are found once their crate is linked, and a crate that no code names is not.
use {wbqp_robots as _, wbqp_tasks as _};

/// Seed of the sensors' noise.
const SEED: u64 = 1;

fn main() -> Result<(), Box<dyn Error>> {
    let name = env::args().nth(1).filter(|name| name != "--live");
    let name = name.unwrap_or("push_away".to_owned());
    let known: Vec<&str> = experiments::ALL.iter().map(|e| e.name).collect();
    let experiment = experiments::of(&name).ok_or_else(|| {
        format!(
            "there is no experiment `{name}`; known: {}",
            known.join(", ")
        )
    })?;
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    let scenario = Scenario::from_file(&folder.join(format!("{name}.toml")))?;

    let mut logs: Vec<(&str, Log)> = Vec::new();
    for case in experiment.cases {
        let mut log = Recorder::default();
        let mut announce = |port| println!("{case}: live on ws://127.0.0.1:{port}");
        let mut live = live_port()?.map(|port| LiveWatcher::new(port, &mut announce));
        let options = RunOptions {
            watchers: vec![&mut live],
            ..RunOptions::default()
        };
        let summary = wbqp_sim::run_with(&scenario, case, SEED, &mut log, options)?;
        println!("{case}: {} ticks", summary.ticks);
        logs.push((case, log.into_log()));
    }

    let cases: Cases<'_> = logs
        .iter()
        .map(|(case, log)| (*case, log as &dyn Recording))
        .collect();
    println!("{}", experiment.title);
    for row in experiment.rows(&cases)? {
        let verdict = match row.pass {
            Some(true) => "met",
            Some(false) => "missed",
            None => "",
        };
        let measured = row.measured.map_or_else(|| "nothing".to_owned(), number);
        println!(
            "{:6} {:8} {measured:>10} {:6} {}",
            row.id, verdict, row.unit, row.quantity
        );
    }
    Ok(())
}
