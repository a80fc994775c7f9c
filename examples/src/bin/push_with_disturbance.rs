//! Runs experiment B, pushing with disturbances, with and without force feedback.

use std::process::ExitCode;

use anyhow::Result;
use clap::Parser;
use wbqp_examples::{cli::Common, push_with_disturbance};

/// Experiment B: push against a wall with 5 N while something pushes back
#[derive(Parser, Debug)]
#[command(version)]
struct Arguments {
    #[command(flatten)]
    common: Common,
}

fn main() -> Result<ExitCode> {
    let arguments = Arguments::parse();
    let outcome = push_with_disturbance::run(&arguments.common)?;
    Ok(if outcome.completed() {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}
