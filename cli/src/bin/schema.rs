//! Writes the JSON Schema of a file, for editors: `cargo run --bin schema > wbqp.schema.json`.

use anyhow::Result;
use clap::Parser;
use wbqp_cli::schema::Arguments;

#[derive(Parser)]
struct CommandLine {
    #[command(flatten)]
    arguments: Arguments,
}

fn main() -> Result<()> {
    CommandLine::parse().arguments.run()
}
