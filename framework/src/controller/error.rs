//! What can be wrong when a controller is made or asked for something by name.

use crate::{robot::RobotError, setup::BindError};

/// Why a controller could not be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ControllerError {
    /// The robot was refused.
    #[error("robot: {0}")]
    Robot(#[source] Box<RobotError>),
    /// An entry does not fit the robot.
    #[error("{kind} `{name}` ({tag}): {source}")]
    Bind {
        /// `task`, `constraint` or `contact`.
        kind: &'static str,
        /// The entry's name.
        name: String,
        /// Its plug-in's tag.
        tag: String,
        /// What is wrong.
        source: Box<BindError>,
    },
    /// Two entries share a name.
    #[error("{kind} `{name}` is defined twice; give each entry a name of its own")]
    Duplicate {
        /// `entry` or `contact`.
        kind: &'static str,
        /// The name.
        name: String,
    },
    /// A setting of the loop makes no sense.
    #[error("controller: {0}")]
    Settings(#[source] BindError),
    /// The solver refused its settings.
    #[error("solver: {0}")]
    Solver(String),
}

impl From<RobotError> for ControllerError {
    fn from(error: RobotError) -> Self {
        Self::Robot(Box::new(error))
    }
}

/// Why a running controller could not do what was asked.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RequestError {
    /// Nothing has that name.
    #[error("there is no {kind} `{name}`{hint}; known: {known}")]
    Absent {
        /// `task`, `entry` or `contact`.
        kind: &'static str,
        /// The name given.
        name: String,
        /// `; did you mean …?` or empty.
        hint: String,
        /// The names there are.
        known: String,
    },
    /// The plug-in is of another type.
    #[error("task `{name}` is a `{is}`, not a `{asked}`")]
    OtherType {
        /// The name given.
        name: String,
        /// Its plug-in's tag.
        is: &'static str,
        /// The type asked for.
        asked: &'static str,
    },
    /// The task follows no reference.
    #[error("task `{name}` follows no reference")]
    NoReference {
        /// The task.
        name: String,
    },
    /// The new value does not fit.
    #[error("`{name}`: {source}")]
    Value {
        /// The entry.
        name: String,
        /// What is wrong.
        source: BindError,
    },
}
