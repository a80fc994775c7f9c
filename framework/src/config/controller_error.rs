//! What can be wrong when a controller is made.

use super::ConfigErrors;
use wbqp_robot_model::{RobotError, SourceLocation};

/// Why a controller could not be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ControllerError {
    /// The robot was refused. What is wrong may be in the configuration or in a file that it names.
    #[error("{}", robot_lines(places, tag, source))]
    Robot {
        /// For each thing that is wrong, the key in the configuration's file, or its table `[robot]`; nothing if there
        /// is no file.
        places: Vec<Option<SourceLocation>>,
        /// The robot's tag.
        tag: String,
        /// What is wrong.
        source: Box<RobotError>,
    },
    /// Entries or settings do not fit the robot or one another: everything that is wrong, each with its place in the
    /// file if there is one.
    #[error(transparent)]
    Config(#[from] ConfigErrors),
}

/// One line for each thing that is wrong.
fn robot_lines(places: &[Option<SourceLocation>], tag: &str, source: &RobotError) -> String {
    let errors = match source {
        RobotError::Several { errors } => errors.as_slice(),
        one => std::slice::from_ref(one),
    };
    let line = |(i, error): (usize, &RobotError)| {
        let place = places.get(i).and_then(Option::as_ref);
        let place = place.map_or_else(String::new, |place| format!("{place}: "));
        format!("{place}robot ({tag}): {error}")
    };
    let lines: Vec<String> = errors.iter().enumerate().map(line).collect();
    lines.join("\n")
}
