//! Runs a shipped scenario natively and writes what was measured and commanded in every tick: what the module's
//! commands are compared with. `cargo run -p wbqp-web --example record -- push_with_disturbance with_ft FILE`
//!
//! The file has 64-bit numbers: how many a measurement has, how many a command has, then both of every tick.

use std::{env, error::Error, fs};

use wbqp_web::{Session, keep_shipped};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [scenario, case, file] = arguments.as_slice() else {
        return Err("three arguments: scenario, case, file".into());
    };
    keep_shipped();
    let mut session = Session::new(&format!("scenarios/{scenario}.toml"), case, 1, "")?;
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
    fs::write(file, bytes)?;
    Ok(())
}
