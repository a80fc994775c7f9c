//! What can be wrong when a controller is made or asked for something by name.

use crate::{
    config::ConfigErrors,
    error::BindError,
    robot::{Place, RobotError},
};

/// Why a controller could not be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ControllerError {
    /// The robot was refused. What is wrong may be in the configuration or in a file that it names.
    #[error("{}", robot_lines(places, tag, source))]
    Robot {
        /// For each thing that is wrong, the key in the configuration's file, or its table `[robot]`; nothing if there
        /// is no file.
        places: Vec<Option<Place>>,
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
fn robot_lines(places: &[Option<Place>], tag: &str, source: &RobotError) -> String {
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

/// Why a running controller could not do what was asked.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RequestError {
    /// Nothing has that name.
    #[error("there is no {kind} `{name}`{hint} (known: {known})")]
    Absent {
        /// `task`, `constraint`, `entry` or `contact`.
        kind: &'static str,
        /// The name given.
        name: String,
        /// `; did you mean …?` or empty.
        hint: String,
        /// The names there are.
        known: String,
    },
    /// The plug-in is of another type.
    #[error("{kind} `{name}` is of type `{is}`, not a `{asked}`")]
    OtherType {
        /// `task` or `constraint`.
        kind: &'static str,
        /// The name given.
        name: String,
        /// Its plug-in's tag.
        is: &'static str,
        /// The Rust type asked for, without its path.
        asked: &'static str,
    },
    /// The id was made by another controller.
    #[error("this id of an entry of type `{asked}` is another controller's")]
    OtherController {
        /// The Rust type asked for, without its path.
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
