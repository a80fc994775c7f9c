//! Runs a shipped scenario natively and writes what was measured and commanded in every tick, which the module's
//! commands are compared with, and its log, which the page replays:
//! `cargo run -p wbqp-web --example record -- push_with_disturbance with_ft FOLDER`
//!
//! `FOLDER/SCENARIO.bin` has 64-bit numbers: how many a measurement has, how many a command has, then both of every
//! tick. `FOLDER/SCENARIO.mcap` is the log of the same run.

use std::{env, error::Error, fs, path::Path};

use wbqp_log::McapLog;
use wbqp_sim::{Scenario, run};
use wbqp_web::{Session, keep_shipped};

const SEED: u64 = 1;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [scenario, case, folder] = arguments.as_slice() else {
        return Err("three arguments: scenario, case, folder".into());
    };
    let folder = Path::new(folder);
    fs::create_dir_all(folder)?;
    keep_shipped();
    let path = format!("scenarios/{scenario}.toml");
    let mut session = Session::new(&path, case, SEED, "")?;
    let mut numbers: Vec<f64> = Vec::new();
    while !session.is_over() && session.tick(&mut || 0.0) {
        let (measured, command) = (session.measured(), session.command());
        if numbers.is_empty() {
            numbers.extend([measured.len() as f64, command.len() as f64]);
        }
        numbers.extend(measured);
        numbers.extend(command);
    }
    let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
    fs::write(folder.join(format!("{scenario}.bin")), bytes)?;

    let scenario_of_log = Scenario::from_file(Path::new(&path))?;
    let mut log = McapLog::create(&folder.join(format!("{scenario}.mcap")))?;
    run(&scenario_of_log, case, SEED, &mut log, &mut |_| ())?;
    wbqp_log::LogSink::finish(&mut log)?;
    Ok(())
}
