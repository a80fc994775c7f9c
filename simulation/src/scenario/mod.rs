//! Scenarios: a controller, a plant, sensors, and what happens when.
//!
//! A scenario is one TOML file:
//! ```toml
//! name = "push"
//! controller = "push.controller.toml"   # relative to this file
//! duration = 25.0                       # s
//!
//! [initial]
//! position = [-0.9, 0.0, 1.26]          # m, world
//!
//! [plant]                               # PlantConfig: walls, disturbances, mismatch …
//! [sensors]                             # SensorsConfig: noise, force-torque sensors …
//!
//! [[detector]]                          # contact on and off by measured force
//! contact = "tip"
//!
//! [[event]]                             # what changes at a given time
//! at = 1.0
//! follow.base = { type = "min_jerk", to = [-0.5, 0.0, 1.26], duration = 4.0 }
//!
//! [[case]]                              # variants that share everything else
//! name = "no_ft"
//! set.task.force.feedback = "off"
//! ```
//! Everything is checked when the file is loaded, against the robot and the controller of every case.

mod error;
mod event;

pub use error::{RunError, ScenarioError};
pub use event::Event;

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use nalgebra::{UnitQuaternion, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use wbqp::{
    config::{ControllerConfig, Overrides},
    contact::Detector,
    controller::Controller,
    model::Model,
    robot::{RobotModel, SourceFile},
    state::State,
};

use crate::{Plant, PlantConfig, PlantError, Sensors, SensorsConfig};

/// A loaded and checked scenario.
#[derive(Clone, Debug)]
pub struct Scenario {
    file: ScenarioFile,
    controller: PathBuf,
    source: SourceFile,
}

/// The file as it is written.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ScenarioFile {
    name: String,
    controller: PathBuf,
    duration: f64,
    #[serde(default)]
    initial: Initial,
    #[serde(default)]
    plant: PlantConfig,
    #[serde(default)]
    sensors: SensorsConfig,
    #[serde(default, rename = "detector")]
    detectors: Vec<Detector>,
    #[serde(default, rename = "event")]
    events: Vec<Event>,
    #[serde(default, rename = "case")]
    cases: Vec<Case>,
}

/// Where the robot starts, at rest.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Initial {
    /// Position of the base, m, world.
    pub position: [f64; 3],
    /// Roll, pitch, yaw of the base, rad.
    pub rpy: [f64; 3],
    /// Joint positions that differ from the robot's home, rad or m.
    pub joints: BTreeMap<String, f64>,
}

/// A variant: values put into the controller's configuration before it is read.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Case {
    name: String,
    #[serde(default)]
    set: Overrides,
}

impl Scenario {
    /// Loads a scenario and checks it by making the controller, plant and sensors of every case.
    ///
    /// # Errors
    /// [`ScenarioError`] naming the file, the place and what is wrong.
    pub fn from_file(path: &Path) -> Result<Self, ScenarioError> {
        let name = path.display().to_string();
        let contents = fs::read_to_string(path).map_err(|source| ScenarioError::Read {
            file: name.clone(),
            source,
        })?;
        Self::from_text(&contents, &name, path.parent().unwrap_or(Path::new("")))
    }

    /// Like [`Scenario::from_file`], from a text; relative paths count from `directory`.
    ///
    /// # Errors
    /// [`ScenarioError`] naming the file, the place and what is wrong.
    pub fn from_text(text: &str, name: &str, directory: &Path) -> Result<Self, ScenarioError> {
        let file: ScenarioFile = toml::from_str(text).map_err(|error| {
            let before = &text[..error.span().map_or(0, |s| s.start.min(text.len()))];
            let line = before.matches('\n').count() + 1;
            let column = before.chars().rev().take_while(|&c| c != '\n').count() + 1;
            ScenarioError::Syntax {
                place: format!("{name}:{line}:{column}"),
                message: error.message().to_owned(),
            }
        })?;
        let scenario = Self {
            controller: directory.join(&file.controller),
            source: SourceFile {
                name: name.to_owned(),
                media_type: "application/toml",
                contents: text.to_owned(),
            },
            file,
        };
        scenario.check()?;
        Ok(scenario)
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.file.name
    }

    /// Names of the cases, in the file's order.
    pub fn cases(&self) -> impl Iterator<Item = &str> {
        self.file.cases.iter().map(|c| c.name.as_str())
    }

    /// Simulated time, s.
    pub fn duration(&self) -> f64 {
        self.file.duration
    }

    /// The file it was loaded from.
    pub fn source(&self) -> &SourceFile {
        &self.source
    }

    /// The controller's configuration in a case.
    ///
    /// # Errors
    /// [`ScenarioError`] if there is no such case or the configuration is refused.
    pub fn controller_config(&self, case: &str) -> Result<ControllerConfig, ScenarioError> {
        let found = self.file.cases.iter().find(|c| c.name == case);
        let Some(found) = found else {
            let known: Vec<&str> = self.cases().collect();
            return Err(self.refuse(&format!(
                "there is no case `{case}`; known: {}",
                known.join(", ")
            )));
        };
        ControllerConfig::from_file_with(&self.controller, &found.set).map_err(|errors| {
            ScenarioError::Config {
                file: self.source.name.clone(),
                case: case.to_owned(),
                source: Box::new(errors),
            }
        })
    }

    pub(crate) fn make_controller(&self, case: &str) -> Result<Controller, ScenarioError> {
        let config = self.controller_config(case)?;
        Controller::new(config).map_err(|source| ScenarioError::Controller {
            file: self.source.name.clone(),
            case: case.to_owned(),
            controller: self.controller.display().to_string(),
            source: Box::new(source),
        })
    }

    pub(crate) fn make_plant(&self, robot: &RobotModel) -> Result<Plant, ScenarioError> {
        let initial = self.initial_state(robot)?;
        Plant::new(robot, &self.file.plant, initial).map_err(|e| self.plant_error("plant", e))
    }

    pub(crate) fn make_sensors(&self, plant: &Plant, seed: u64) -> Result<Sensors, ScenarioError> {
        Sensors::new(&self.file.sensors, plant, seed).map_err(|e| self.plant_error("sensors", e))
    }

    pub(crate) fn events(&self) -> &[Event] {
        &self.file.events
    }

    pub(crate) fn detectors(&self) -> &[Detector] {
        &self.file.detectors
    }

    pub(crate) fn plant(&self) -> &PlantConfig {
        &self.file.plant
    }

    pub(crate) fn sensors(&self) -> &SensorsConfig {
        &self.file.sensors
    }

    fn initial_state(&self, robot: &RobotModel) -> Result<State, ScenarioError> {
        let Initial {
            position,
            rpy,
            joints,
        } = &self.file.initial;
        if !position
            .iter()
            .chain(rpy)
            .chain(joints.values())
            .all(|x| x.is_finite())
        {
            return Err(self.refuse("initial: has a number that is not finite"));
        }
        let mut state = robot.home.clone();
        state.p_WR = Vector3::from(*position);
        state.R_WR = UnitQuaternion::from_euler_angles(rpy[0], rpy[1], rpy[2]);
        for (name, position) in joints {
            let joint = robot.model.joint(name).ok_or_else(|| {
                self.refuse(&format!(
                    "initial.joints: the robot has no joint `{name}`; known: {}",
                    joint_names(&robot.model)
                ))
            })?;
            state.q[joint.index()] = *position;
        }
        Ok(state)
    }

    fn check(&self) -> Result<(), ScenarioError> {
        let file = &self.file;
        if !(file.duration.is_finite() && file.duration > 0.0) {
            let what = format!(
                "duration: is {} s, must be positive and finite",
                file.duration
            );
            return Err(self.refuse(&what));
        }
        if file.cases.is_empty() {
            return Err(self.refuse("case: there is none; add a [[case]] with a name"));
        }
        for (i, case) in file.cases.iter().enumerate() {
            if file.cases[..i].iter().any(|c| c.name == case.name) {
                let what = format!("case[{i}]: the name `{}` is used twice", case.name);
                return Err(self.refuse(&what));
            }
            // The name becomes the name of a log file.
            let plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
            if case.name.is_empty() || !case.name.chars().all(plain) {
                let what = format!(
                    "case[{i}]: name `{}` must be made of letters, digits, `_` and `-`",
                    case.name
                );
                return Err(self.refuse(&what));
            }
        }
        for case in self.cases() {
            let mut controller = self.make_controller(case)?;
            let plant = self.make_plant(controller.robot())?;
            self.make_sensors(&plant, 0)?;
            for (i, detector) in file.detectors.iter().enumerate() {
                let refuse = |what: String| self.refuse(&format!("detector[{i}]: {what}"));
                detector.validate().map_err(|e| refuse(e.to_string()))?;
                let contact = controller
                    .contact(&detector.contact)
                    .map_err(|e| refuse(e.to_string()))?;
                let frame = &controller.contact_spec(contact).frame;
                if !file.sensors.force_torque.iter().any(|s| &s.frame == frame) {
                    let what = format!(
                        "no force is measured at contact `{}`: there is no [[sensors.force_torque]] with frame = \"{frame}\"",
                        detector.contact
                    );
                    return Err(refuse(what));
                }
            }
            for (i, event) in file.events.iter().enumerate() {
                // The check applies every event to a controller that never runs.
                event.apply(&mut controller).map_err(|what| {
                    self.refuse(&format!("event[{i}] at {} s: {what}", event.at))
                })?;
            }
        }
        Ok(())
    }

    fn refuse(&self, what: &str) -> ScenarioError {
        ScenarioError::Value {
            file: self.source.name.clone(),
            what: what.to_owned(),
        }
    }

    /// Keys in the error count from `table`.
    fn plant_error(&self, table: &'static str, source: PlantError) -> ScenarioError {
        ScenarioError::Plant {
            file: self.source.name.clone(),
            table,
            source: Box::new(source),
        }
    }
}

fn joint_names(model: &Model) -> String {
    let names: Vec<&str> = model.joints().iter().map(|j| j.name.as_str()).collect();
    names.join(", ")
}
