//! Replicates the paper's experiments.

use std::process::ExitCode;

use anyhow::Result;
use clap::Parser;
use wbqp_examples::{cli::Common, push_with_disturbance};

/// Replicates the paper's experiments: logs, figures and a table of results
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
