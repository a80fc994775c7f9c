//! A robot as a controller sees it: rigid bodies, actuators, a home posture.

use std::{fmt, sync::Arc};

use crate::{
    actuator::{Actuator, ActuatorKind, Rotor},
    model::{JointId, Model, ModelError},
    state::State,
};

/// Everything a controller needs to know of a robot, immutable.
#[derive(Clone, Debug)]
pub struct RobotModel {
    /// The rigid-body tree.
    pub model: Arc<Model>,
    /// The columns of `S(q)`, in the order of `u`. A joint without an actuator is passive.
    pub actuators: Vec<Actuator>,
    /// Where the robot rests or starts, at rest.
    pub home: State,
    /// The files it came from, for logs.
    pub sources: Vec<SourceFile>,
}

/// A file that describes a robot, as read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SourceFile {
    /// File name or path, as given.
    pub name: String,
    /// MIME type: `application/xml` or `application/toml`.
    pub media_type: &'static str,
    /// The whole text.
    pub contents: String,
}

impl RobotModel {
    /// Number of actuators: the size of `u`.
    pub fn nu(&self) -> usize {
        self.actuators.len()
    }

    /// Index in `u` of the actuator of that name.
    pub fn actuator(&self, name: &str) -> Option<usize> {
        self.actuators.iter().position(|a| a.name == name)
    }

    /// Index in `u` of the motor of a joint; `None` for a passive joint.
    pub fn joint_actuator(&self, joint: JointId) -> Option<usize> {
        self.actuators
            .iter()
            .position(|a| matches!(&a.kind, ActuatorKind::Joint(motor) if motor.joint == joint))
    }

    /// All rotors with their index in `u`.
    pub fn rotors(&self) -> impl Iterator<Item = (usize, &Actuator, &Rotor)> {
        self.actuators
            .iter()
            .enumerate()
            .filter_map(|(index, actuator)| match &actuator.kind {
                ActuatorKind::Rotor(rotor) => Some((index, actuator, rotor)),
                ActuatorKind::Joint(_) => None,
            })
    }

    /// What no controller can work with, whoever made the robot: sizes, names and limits that contradict one another.
    pub(crate) fn problems(&self) -> Vec<String> {
        let mut problems = Vec::new();
        if !self.home.fits(&self.model) {
            problems.push(format!(
                "its home posture has {} joint positions and {} velocities, its model {} and {}",
                self.home.q.len(),
                self.home.v.len(),
                self.model.joints().len(),
                self.model.nv()
            ));
        } else if !self.home.is_finite() {
            problems.push("its home posture has a number that is not finite".to_owned());
        } else {
            for (joint, &q) in self.model.joints().iter().zip(&self.home.q) {
                let (lower, upper) = (joint.limits.lower, joint.limits.upper);
                if q < lower || q > upper {
                    problems.push(format!(
                        "joint `{}` is at {q} in the home posture, outside its range {lower} to {upper}",
                        joint.name
                    ));
                }
            }
        }
        for (index, actuator) in self.actuators.iter().enumerate() {
            let name = &actuator.name;
            if self
                .actuators
                .iter()
                .take(index)
                .any(|other| other.name == *name)
            {
                problems.push(format!(
                    "actuator `{name}` is there twice; give each a name of its own"
                ));
            }
            problems.extend(
                actuator
                    .problem(&self.model)
                    .map(|what| format!("actuator `{name}`: {what}")),
            );
        }
        problems
    }
}

/// A place in a file, written `file:line:column`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// File name or path, as given.
    pub file: String,
    /// Line and column, from 1, where known.
    pub position: Option<(usize, usize)>,
}

impl Place {
    /// The file as a whole.
    pub fn file(file: &str) -> Self {
        Self {
            file: file.to_owned(),
            position: None,
        }
    }

    /// A line and column, from 1.
    pub fn at(file: &str, line: usize, column: usize) -> Self {
        Self {
            file: file.to_owned(),
            position: Some((line, column)),
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.position {
            Some((line, column)) => write!(f, "{}:{line}:{column}", self.file),
            None => f.write_str(&self.file),
        }
    }
}

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
        place: Place,
        /// What is wrong.
        what: String,
    },
    /// An element of a file is missing, unknown or has a value that cannot be.
    #[error("{place}: {element}: {what}")]
    Element {
        /// Where.
        place: Place,
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
    /// Anything else, from a loader of another format.
    #[error("{file}: {source}")]
    Other {
        /// The file, or whatever the robot comes from.
        file: String,
        /// What the loader says.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
}

/// A robot that a configuration can name: hands out the model, the actuators, the frames, the home posture.
///
/// Registered by `#[wbqp::robot("tag")]` and named by `[robot] type = "tag"`.
#[typetag::serde(tag = "type")]
pub trait Robot: std::any::Any + Send + fmt::Debug {
    /// Makes the robot; relative paths count from `directory` (that of the configuration file).
    ///
    /// # Errors
    /// [`RobotError`] naming file and element.
    fn load(&self, directory: &std::path::Path) -> Result<RobotModel, RobotError>;
}
