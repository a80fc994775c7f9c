//! Writes the JSON Schema of a file, for editors: `cargo run --bin schema > wbqp.schema.json`.

use std::io::Write;

use clap::{Parser, ValueEnum};
use wbqp::{registry::json_schema, serde_json};
use wbqp_robots as _;
use wbqp_tasks as _;

/// Writes the JSON Schema of wbqp's files, with all plug-ins of this workspace, to the standard output.
#[derive(Parser)]
struct Args {
    /// Of which file.
    #[arg(value_enum, default_value_t = File::Controller)]
    file: File,
}

#[derive(Clone, Copy, ValueEnum)]
enum File {
    /// A controller's file.
    Controller,
    /// A scenario's file.
    Scenario,
}

fn main() -> anyhow::Result<()> {
    let schema = match Args::parse().file {
        File::Controller => json_schema::controller(),
        File::Scenario => wbqp_sim::scenario::json_schema(),
    };
    let text = serde_json::to_string_pretty(&schema)?;
    writeln!(std::io::stdout(), "{text}")?;
    Ok(())
}
