//! Replicates the paper's experiments.

use std::process::ExitCode;

use anyhow::Result;
use clap::Parser;
use wbqp_examples::{cli::Common, experiments, replication};

/// Replicates the paper's experiments: logs, figures, tables of results and a report
///
/// Succeeds if every promised row is met (examples/promised_rows.toml).
#[derive(Parser, Debug)]
#[command(version)]
struct Arguments {
    #[command(flatten)]
    common: Common,
}

fn main() -> Result<ExitCode> {
    let arguments = Arguments::parse();
    let outcomes = replication::run(experiments::ALL, &arguments.common)?;
    for outcome in &outcomes {
        outcome.print();
    }
    Ok(replication::conclude(&outcomes))
}
