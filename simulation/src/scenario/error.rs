//! What can be wrong with a scenario or stop a run.

use wbqp::{config::ConfigErrors, controller::ControllerError, log::LogError};

use crate::PlantError;

/// Why a scenario was refused.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ScenarioError {
    /// The file cannot be read.
    #[error("{file}: cannot be read: {source}")]
    Read {
        /// The file.
        file: String,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// The text is not a scenario.
    #[error("{place}: {message}")]
    Syntax {
        /// `file:line:column`.
        place: String,
        /// What is wrong.
        message: String,
    },
    /// A value makes no sense or a name refers to nothing.
    #[error("{file}: {what}")]
    Value {
        /// The file.
        file: String,
        /// Key and what is wrong.
        what: String,
    },
    /// The controller's file is refused.
    #[error("{0}")]
    Config(Box<ConfigErrors>),
    /// The controller does not fit the robot.
    #[error("{file}: {source}")]
    Controller {
        /// The controller's file.
        file: String,
        /// What is wrong.
        source: Box<ControllerError>,
    },
    /// The plant or its sensors are refused.
    #[error("{file}: {source}")]
    Plant {
        /// The scenario's file.
        file: String,
        /// What is wrong.
        source: Box<PlantError>,
    },
}

/// Why a run stopped.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// The scenario is wrong.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// The log cannot be written.
    #[error(transparent)]
    Log(#[from] LogError),
    /// An event could not be applied.
    #[error("event at {at} s: {what}")]
    Event {
        /// Its time.
        at: f64,
        /// What is wrong.
        what: String,
    },
    /// The plant refused a command.
    #[error("plant: {0}")]
    Plant(#[from] PlantError),
}
