//! Writes the table of all plug-ins: `cargo run --bin plugins > docs/plugins.md`.

use anyhow::Result;
use clap::Parser;
use wbqp_cli::plugins::Arguments;

#[derive(Parser)]
struct CommandLine {
    #[command(flatten)]
    arguments: Arguments,
}

fn main() -> Result<()> {
    CommandLine::parse().arguments.run()
}
