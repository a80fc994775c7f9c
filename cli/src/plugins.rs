//! The table of all plug-ins.

use std::io::Write;

use anyhow::Result;
use clap::{Args, ValueEnum};

use crate::plugin_table;

/// Lists all plug-ins of this workspace with their parameters, on the standard output
#[derive(Args, Debug)]
pub struct Arguments {
    /// As docs/plugins.md, or one line per plug-in and parameter.
    #[arg(long, value_enum, default_value_t = Format::Markdown)]
    format: Format,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Format {
    Markdown,
    Text,
}

impl Arguments {
    /// Prints the table.
    ///
    /// # Errors
    /// A standard output that is closed.
    pub fn run(&self) -> Result<()> {
        let listing = wbqp::registry();
        let text = match self.format {
            Format::Markdown => plugin_table::markdown(&listing),
            Format::Text => listing.iter().map(ToString::to_string).collect(),
        };
        write!(std::io::stdout(), "{text}")?;
        Ok(())
    }
}
