//! One table of all shards.

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Args;
use wbqp_campaign::table::{self, Table};
use wbqp_terminal::say;

use crate::output::{self, Existing};

/// Makes one table of the tables of all shards: the same bytes for any number of them
#[derive(Args, Debug)]
pub(super) struct Arguments {
    /// Directory with the shards' tables
    #[arg(value_name = "DIR")]
    directory: PathBuf,
    /// The table
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Replaces a file that is there; an older table of the same campaign is replaced without
    #[arg(long)]
    force: bool,
}

impl Arguments {
    pub(super) fn run(&self) -> Result<()> {
        let shards = table::shards(&self.directory)?;
        output::refuse_input(&self.out, shards.iter().map(PathBuf::as_path))?;
        let existing = Existing::of_force(self.force);
        let existing = existing.or_own(&self.out, |out| is_of_campaign(out, &shards));
        output::refuse_existing(&self.out, existing)?;
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

/// Whether a file is a table of the campaign that the shards are of: all that it has is in theirs.
fn is_of_campaign(file: &Path, shards: &[PathBuf]) -> bool {
    let first = shards.first().and_then(|first| Table::open(first).ok());
    let (Some(first), Ok(found)) = (first, Table::open(file)) else {
        return false;
    };
    found.description() == first.description()
}
