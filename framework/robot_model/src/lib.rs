//! A robot as a controller sees it: rigid bodies, actuators, a home posture.

mod diagnostic;
mod error;
mod source_location;

pub use diagnostic::{Diagnostic, Severity};
pub use error::RobotError;
pub use source_location::SourceLocation;

use std::{collections::HashSet, fmt, sync::Arc};

use serde::{Deserialize, Serialize};
use wbqp_dynamics::{
    actuator::{Actuator, ActuatorId, ActuatorKind, Rotor},
    model::{JointId, Model},
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
    /// Whether something says where the base is at home. If nothing does, a floating base whose contacts are on at the
    /// start stands on them.
    pub base_is_placed: bool,
    /// The files it came from, for logs.
    pub sources: Vec<SourceFile>,
    /// What the loader noticed in them and did about it.
    pub diagnostics: Vec<Diagnostic>,
}

/// A file that describes a robot, as read.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SourceFile {
    /// File name or path, as given.
    pub name: String,
    /// The whole text.
    pub contents: String,
}

impl SourceFile {
    /// Its MIME type by its first character: `application/xml`, or `application/toml`.
    pub fn media_type(&self) -> &'static str {
        let text = self.contents.trim_start_matches('\u{feff}').trim_start();
        if text.starts_with('<') {
            "application/xml"
        } else {
            "application/toml"
        }
    }
}

impl RobotModel {
    /// A robot that is put together in code: no files, nothing noticed, its base where `home` says.
    pub fn new(model: impl Into<Arc<Model>>, actuators: Vec<Actuator>, home: State) -> Self {
        Self {
            model: model.into(),
            actuators,
            home,
            base_is_placed: true,
            sources: Vec::new(),
            diagnostics: Vec::new(),
        }
    }

    /// Number of actuators: the size of `u`.
    pub fn nu(&self) -> usize {
        self.actuators.len()
    }

    /// Index in `u` of the actuator of that name.
    pub fn actuator(&self, name: &str) -> Option<ActuatorId> {
        self.find(|actuator| actuator.name == name)
    }

    /// Index in `u` of the motor of a joint; `None` for a passive joint.
    pub fn joint_actuator(&self, joint: JointId) -> Option<ActuatorId> {
        self.find(|a| matches!(&a.kind, ActuatorKind::Joint(motor) if motor.joint == joint))
    }

    fn find(&self, is_it: impl Fn(&Actuator) -> bool) -> Option<ActuatorId> {
        let position = self.actuators.iter().position(is_it)?;
        Some(ActuatorId::new(position))
    }

    /// All actuators with their index in `u`.
    pub fn numbered_actuators(&self) -> impl Iterator<Item = (ActuatorId, &Actuator)> {
        (0..).map(ActuatorId::new).zip(&self.actuators)
    }

    /// All rotors with their index in `u`.
    pub fn rotors(&self) -> impl Iterator<Item = (ActuatorId, &Actuator, &Rotor)> {
        self.numbered_actuators()
            .filter_map(|(id, actuator)| match &actuator.kind {
                ActuatorKind::Rotor(rotor) => Some((id, actuator, rotor)),
                ActuatorKind::Joint(_) => None,
            })
    }

    /// What no controller can work with, whoever made the robot: sizes, names and limits that contradict one another.
    /// Empty if a controller can be made of it; a sentence each if not.
    pub fn problems(&self) -> Vec<String> {
        let mut problems = Vec::new();
        if self.model.nv() == 0 {
            problems.push("it has a fixed base and no moving joint: nothing to control".to_owned());
        }
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
        let mut names = HashSet::new();
        for actuator in &self.actuators {
            let name = &actuator.name;
            if !names.insert(name) {
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
