//! Recorded ticks with everything that is needed to run them again.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::Record;
use wbqp_robot_model::{RobotModel, SourceFile};

/// Recorded ticks with the configuration and the robot that they belong to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Dump {
    /// Version of the format; another one than [`Dump::FORMAT`] cannot be read.
    pub format: u32,
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
    pub robot: Vec<SourceFile>,
    /// The ticks, oldest first.
    pub(super) records: Vec<Record>,
}

impl Dump {
    /// The version of the format that is written and read.
    pub const FORMAT: u32 = 1;

    /// Number of ticks.
    pub fn len(&self) -> usize {
        self.records.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.records.is_empty()
    }

    /// Time stamp of a tick's measurement, s; the oldest tick is 0.
    pub fn time(&self, tick: usize) -> Option<f64> {
        self.records.get(tick).map(|record| record.time)
    }

    /// What came out of a tick, by name, with all digits: `level`, `status`, `iterations`, the solution `x[0]` …, and
    /// the command, `effort[0]` … `joint_velocity[0]` …, in SI units.
    pub fn outcome(&self, tick: usize) -> Option<Vec<(String, String)>> {
        self.records.get(tick).map(Record::outcome)
    }

    pub(crate) fn new(
        directory: &Path,
        configuration: String,
        robot: &RobotModel,
        records: Vec<Record>,
    ) -> Self {
        Self {
            format: Self::FORMAT,
            wbqp: env!("CARGO_PKG_VERSION").to_owned(),
            directory: directory.display().to_string(),
            configuration,
            robot: robot.sources.clone(),
            diagnostics: robot.diagnostics.iter().map(ToString::to_string).collect(),
            records,
        }
    }
}
