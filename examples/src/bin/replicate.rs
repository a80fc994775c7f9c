//! Replicates the paper's experiments.

use std::process::ExitCode;

use anyhow::Result;
use clap::Parser;
use wbqp_examples::{cli::Common, experiments};

/// Replicates the paper's experiments: logs, figures and a table of results
#[derive(Parser, Debug)]
#[command(version)]
struct Arguments {
    #[command(flatten)]
    common: Common,
}

fn main() -> Result<ExitCode> {
    let arguments = Arguments::parse();
    let mut completed = true;
    for experiment in experiments::ALL {
        println!("\n{}", experiment.title);
        completed &= experiment.run(&arguments.common)?.completed();
    }
    Ok(if completed {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}
