//! A dump: recorded ticks and everything that is needed to run them again, and its file.

use std::{fs, io, path::Path};

use serde::{Deserialize, Serialize};

use super::record::Record;
use crate::{config::ConfigErrors, controller::ControllerError, input, robot::RobotModel};

/// The file format's version; a file of another one is refused.
const FORMAT: u32 = 1;

/// Recorded ticks with the configuration and the robot that they belong to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Dump {
    pub(super) format: u32,
    /// Version of wbqp that wrote it: bits are the same only with the same.
    pub wbqp: String,
    /// Where the configuration's relative paths count from.
    pub directory: String,
    /// The configuration as TOML, overrides and defaults filled in.
    pub configuration: String,
    /// What the loader noticed in the robot's files and did about it, in words.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub diagnostics: Vec<String>,
    /// The robot's files.
    pub robot: Vec<Source>,
    /// The ticks, oldest first.
    pub records: Vec<Record>,
}

/// A file that describes the robot.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Source {
    /// Its name.
    pub name: String,
    /// Its text.
    pub contents: String,
}

/// Why a dump could not be written, read or run again.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DumpError {
    /// The controller's configuration cannot be written as TOML.
    #[error("the configuration cannot be saved: {0}")]
    Configuration(String),
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
    Refused(#[from] ConfigErrors),
    /// The controller cannot be made.
    #[error("the dump's controller: {0}")]
    Controller(#[from] ControllerError),
    /// The robot's files are others by now.
    #[error("the robot's file `{0}` is not the one in the dump")]
    OtherRobot(String),
    /// A record does not fit the configuration beside it.
    #[error("record {index}: {what} does not fit the configuration")]
    Misfit {
        /// Which record, from 0.
        index: usize,
        /// What does not fit.
        what: String,
    },
}

impl Dump {
    pub(crate) fn new(
        directory: &Path,
        configuration: String,
        robot: &RobotModel,
        records: Vec<Record>,
    ) -> Self {
        let files = robot.sources.iter().map(|file| Source {
            name: file.name.clone(),
            contents: file.contents.clone(),
        });
        Self {
            format: FORMAT,
            wbqp: env!("CARGO_PKG_VERSION").to_owned(),
            directory: directory.display().to_string(),
            configuration,
            robot: files.collect(),
            diagnostics: robot.diagnostics.iter().map(ToString::to_string).collect(),
            records,
        }
    }

    /// Writes the file.
    ///
    /// # Errors
    /// [`DumpError::Write`].
    pub fn save(&self, file: &Path) -> Result<(), DumpError> {
        let name = || file.display().to_string();
        let text = toml::to_string(self).map_err(|error| DumpError::Format {
            file: name(),
            problem: error.to_string(),
        })?;
        fs::write(file, text).map_err(|source| DumpError::Write {
            file: name(),
            source,
        })
    }

    /// Reads a file.
    ///
    /// # Errors
    /// [`DumpError::Read`], [`DumpError::Format`].
    pub fn load(file: &Path) -> Result<Self, DumpError> {
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
        let dump: Self = toml::from_str(&text).map_err(|error| refused(error.to_string()))?;
        if dump.format != FORMAT {
            return Err(refused(format!(
                "format {}, this version reads {FORMAT}",
                dump.format
            )));
        }
        Ok(dump)
    }
}
