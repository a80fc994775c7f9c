//! The JSON Schema of a file, for editors.

use std::io::Write;

use anyhow::Result;
use clap::{Args, ValueEnum};
use wbqp::{config::json_schema, serde_json};

/// Writes the JSON Schema of wbqp's files, with all plug-ins of this workspace, to the standard output
#[derive(Args, Debug)]
pub struct Arguments {
    /// Of which file
    #[arg(value_enum, default_value_t = File::Controller)]
    file: File,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum File {
    /// A controller's file.
    Controller,
    /// A scenario's file.
    Scenario,
    /// A campaign's plan.
    Plan,
}

impl Arguments {
    /// Prints the schema.
    ///
    /// # Errors
    /// A standard output that is closed.
    pub fn run(&self) -> Result<()> {
        let schema = match self.file {
            File::Controller => json_schema::controller(),
            File::Scenario => wbqp_sim::scenario::json_schema(),
            File::Plan => wbqp_campaign::json_schema(),
        };
        let text = serde_json::to_string_pretty(&schema)?;
        writeln!(std::io::stdout(), "{text}")?;
        Ok(())
    }
}
