//! One table of all shards.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use wbqp_campaign::table;
use wbqp_terminal::say;

/// Makes one table of the tables of all shards: the same bytes for any number of them
#[derive(Args, Debug)]
pub(super) struct Arguments {
    /// Directory with the shards' tables
    #[arg(value_name = "DIR")]
    directory: PathBuf,
    /// The table
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
}

impl Arguments {
    pub(super) fn run(&self) -> Result<()> {
        let description = table::merge(&self.directory, &self.out)?;
        say!(
            "{}: {} runs in {}",
            description.name,
            description.runs,
            self.out.display()
        );
        Ok(())
    }
}
