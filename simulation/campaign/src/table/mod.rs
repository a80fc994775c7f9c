//! Tables of results as Parquet files: a line per run, sorted by run.
//!
//! | column | contents |
//! |---|---|
//! | `run`, `point`, `seed`, `variant` | which run |
//! | `factor.<name>` | the factors' numbers; null where the scenario's own counts |
//! | `status`, `reason` | how it ended, and why not otherwise, or why a measure has no value |
//! | `holds` | whether it reached its end and every measure that counts holds; null if it was refused |
//! | `ticks`, `held_ticks` | control periods, and those whose command was not their optimum |
//! | `measure.<name>`, `holds.<name>` | the measures, and verdicts of those that are judged; null where there is none |
//! | `covered.<name>` | of measures with `gaps`: share of the window's ticks that have all signals |
//!
//! Groups of lines have a fixed size, and nothing in a file says when, where or in how many parts it was made: the same
//! campaign gives the same bytes. The metadata `wbqp.campaign` is a [`Description`] as JSON.

mod column;
mod description;
mod error;
mod file;
mod merge;

use std::path::Path;

pub use column::Data;
pub use description::{Description, FactorDescription};
pub use error::TableError;
pub use file::Table;
pub(crate) use file::refuse_irregular;
pub use merge::{merge, shards};

use crate::{Campaign, Outcome};

/// Writes the outcomes of a campaign's first `runs` runs, or of a part of them, sorted by run.
///
/// # Errors
/// [`TableError`] if the file cannot be written; what was there before is still there then.
pub(crate) fn write(
    campaign: &Campaign,
    runs: u64,
    outcomes: &[Outcome],
    path: &Path,
) -> Result<(), TableError> {
    let description = Description::of(campaign, runs);
    let mut writer = file::Writer::create(path, &description, &column::of_outcomes(campaign, &[]))?;
    for group in outcomes.chunks(file::GROUP) {
        writer.group(&column::of_outcomes(campaign, group))?;
    }
    writer.finish()
}
