//! The file of a dump.

use std::{fs, io, path::Path};

use wbqp::{
    config::{ConfigErrors, in_words},
    controller::{Dump, RequestError},
    input,
};

/// Why a dump could not be written, read or run again.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DumpError {
    /// The file cannot be written.
    #[error("{file}: cannot be written: {source}")]
    Write {
        /// The file.
        file: String,
        /// Why.
        source: io::Error,
    },
    /// The file cannot be read.
    #[error("{file}: cannot be read: {source}")]
    Read {
        /// The file.
        file: String,
        /// Why.
        source: io::Error,
    },
    /// The file is not a dump.
    #[error("{file}: is not a dump of ticks: {problem}")]
    Format {
        /// The file.
        file: String,
        /// What is wrong.
        problem: String,
    },
    /// The configuration in it is refused, by a program that does not link its plug-ins for example.
    #[error("the dump's configuration: {0}")]
    Refused(ConfigErrors),
    /// The controller cannot be made.
    #[error("the dump's controller: {0}")]
    Controller(ConfigErrors),
    /// The controller cannot record its ticks.
    #[error(transparent)]
    Unrecordable(#[from] RequestError),
    /// The robot's files are others by now.
    #[error(
        "the robot's file `{0}` is not the one in the dump; give a directory where it is as it was, or where it is not"
    )]
    OtherRobot(String),
    /// A record does not fit the configuration beside it.
    #[error("record {index}: {what}")]
    Misfit {
        /// Which record, from 0.
        index: usize,
        /// What does not fit.
        what: String,
    },
}

/// Writes the file of a dump.
///
/// # Errors
/// [`DumpError::Write`].
pub fn save(dump: &Dump, file: &Path) -> Result<(), DumpError> {
    let name = || file.display().to_string();
    let text = toml::to_string(dump).map_err(|error| DumpError::Format {
        file: name(),
        problem: error.to_string(),
    })?;
    fs::write(file, text).map_err(|source| DumpError::Write {
        file: name(),
        source,
    })
}

/// Reads the file of a dump.
///
/// # Errors
/// [`DumpError::Read`], [`DumpError::Format`].
pub fn load(file: &Path) -> Result<Dump, DumpError> {
    let name = || file.display().to_string();
    let bytes = input::read(file, input::LARGEST_RECORD);
    let text = bytes
        .and_then(input::text)
        .map_err(|source| DumpError::Read {
            file: name(),
            source,
        })?;
    let refused = |problem: String| DumpError::Format {
        file: name(),
        problem,
    };
    input::check_lines(&text).map_err(refused)?;
    // In one line: a quoted part of a file of another kind says nothing.
    let dump: Dump = toml::from_str(&text).map_err(|error| {
        let before = error.span().and_then(|span| text.get(..span.start));
        let line = 1 + before.map_or(0, |before| before.matches('\n').count());
        refused(format!("line {line}: {}", in_words(error.message())))
    })?;
    if dump.format != Dump::FORMAT {
        return Err(refused(format!(
            "format {}, this version reads {}",
            dump.format,
            Dump::FORMAT
        )));
    }
    Ok(dump)
}
