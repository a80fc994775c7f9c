//! What can be wrong with a table.

use std::{io, path::PathBuf};

/// Why a table could not be read, written or made of others.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TableError {
    /// The operating system refuses.
    #[error("{}: {source}", path.display())]
    File {
        /// The file or folder.
        path: PathBuf,
        /// What it says.
        source: io::Error,
    },
    /// It is a damaged Parquet file, or cannot be written.
    #[error("{}: {source}", path.display())]
    Parquet {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: Box<parquet::errors::ParquetError>,
    },
    /// It is no table of a campaign.
    #[error("{}: is not a table of a campaign: {what}", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What is missing.
        what: String,
    },
    /// There is nothing to merge.
    #[error("{}: has no table of a shard (shard-1-of-N.parquet)", directory.display())]
    Nothing {
        /// The folder.
        directory: PathBuf,
    },
    /// Some parts are not there.
    #[error(
        "{}: of {of} shards {} not finished; run each with `--shard I/{of}`",
        directory.display(),
        missing_words(missing)
    )]
    Missing {
        /// The folder.
        directory: PathBuf,
        /// Number of parts.
        of: u32,
        /// The numbers of those that are not there.
        missing: Vec<u32>,
    },
    /// Parts of different campaigns, or of different divisions.
    #[error(
        "{} and {} are of different campaigns, or divided into different numbers of shards; keep those of one \
         campaign in a folder",
        one.display(),
        other.display()
    )]
    Mixed {
        /// A file.
        one: PathBuf,
        /// Another.
        other: PathBuf,
    },
}

fn missing_words(missing: &[u32]) -> String {
    let numbers: Vec<String> = missing.iter().take(20).map(u32::to_string).collect();
    let more = missing.len().saturating_sub(20);
    let verb = if missing.len() == 1 { "is" } else { "are" };
    match more {
        0 => format!("{} {verb}", numbers.join(", ")),
        more => format!("{} and {more} more {verb}", numbers.join(", ")),
    }
}
