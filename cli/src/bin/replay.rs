//! Runs dumped ticks again and prints problem, rows by name, solution and active set.

use std::process::ExitCode;

use anyhow::Result;
use clap::Parser;
use wbqp_cli::replay::Arguments;

#[derive(Parser)]
struct CommandLine {
    #[command(flatten)]
    arguments: Arguments,
}

fn main() -> Result<ExitCode> {
    CommandLine::parse().arguments.run()
}
