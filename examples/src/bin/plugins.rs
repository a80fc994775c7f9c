//! Writes the table of all plug-ins: `cargo run --bin plugins > docs/plugins.md`.

use std::io::Write;

use clap::{Parser, ValueEnum};
use wbqp_examples::plugin_table;

/// Lists all plug-ins of this workspace with their parameters, on the standard output.
#[derive(Parser)]
struct Args {
    /// As docs/plugins.md, or one line per plug-in and parameter.
    #[arg(long, value_enum, default_value_t = Format::Markdown)]
    format: Format,
}

#[derive(Clone, Copy, ValueEnum)]
enum Format {
    Markdown,
    Text,
}

fn main() -> anyhow::Result<()> {
    let listing = wbqp::registry();
    let text = match Args::parse().format {
        Format::Markdown => plugin_table::markdown(&listing),
        Format::Text => listing.to_string(),
    };
    write!(std::io::stdout(), "{text}")?;
    Ok(())
}
