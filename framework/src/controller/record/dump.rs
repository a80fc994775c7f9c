//! Recorded ticks with everything that is needed to run them again.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::Record;
use crate::robot::RobotModel;

/// The file format's version; a file of another one is refused.
pub(crate) const FORMAT: u32 = 1;

/// Recorded ticks with the configuration and the robot that they belong to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Dump {
    pub(crate) format: u32,
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
}
