//! Why a robot cannot be loaded.

use crate::SourceLocation;
use wbqp_dynamics::model::ModelError;

/// Why a robot's description was refused. Messages start with the file and name the element.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RobotError {
    /// A file could not be read.
    #[error("{file}: cannot be read: {source}")]
    Read {
        /// The file.
        file: String,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// A file is not in the format it should be in.
    #[error("{place}: {what}")]
    Syntax {
        /// Where.
        place: SourceLocation,
        /// What is wrong.
        what: String,
    },
    /// An element of a file is missing, unknown or has a value that cannot be.
    #[error("{place}: {element}: {what}")]
    Element {
        /// Where.
        place: SourceLocation,
        /// The element, such as ``joint `elbow` ``.
        element: String,
        /// What is wrong, and what to do.
        what: String,
    },
    /// The rigid-body tree was refused.
    #[error("{file}: {source}")]
    Model {
        /// The file.
        file: String,
        /// What is wrong.
        source: ModelError,
    },
    /// An option asks for what the robot does not have.
    #[error("option `{option}`: {what}")]
    Option {
        /// The key.
        option: String,
        /// What is wrong, and what to do.
        what: String,
    },
    /// Several things at once, in the order of the file.
    #[error("{}", lines(errors))]
    Several {
        /// Each of them; at least two.
        errors: Vec<RobotError>,
    },
    /// Anything else, from a loader of another format.
    #[error("{file}: {source}")]
    Other {
        /// The file, or whatever the robot comes from.
        file: String,
        /// What the loader says.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
}

impl RobotError {
    /// One error of some; nothing if there are none.
    pub fn of(mut errors: Vec<RobotError>) -> Option<Self> {
        match errors.len() {
            0 => None,
            1 => errors.pop(),
            _ => Some(Self::Several { errors }),
        }
    }
}

/// One error a line.
fn lines(errors: &[RobotError]) -> String {
    let lines: Vec<String> = errors.iter().map(ToString::to_string).collect();
    lines.join("\n")
}
