//! Replicates the paper's experiments.

use std::process::ExitCode;

use anyhow::Result;
use clap::Parser;
use wbqp_replication::command::Arguments;

#[derive(Parser)]
#[command(version)]
struct CommandLine {
    #[command(flatten)]
    arguments: Arguments,
}

fn main() -> Result<ExitCode> {
    CommandLine::parse().arguments.run()
}
