//! One case of a scenario, with everything that the file, its changes and a variation say.

use std::{
    collections::BTreeMap,
    f64::consts::TAU,
    path::{Path, PathBuf},
    sync::Arc,
};

use nalgebra::{UnitQuaternion, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use wbqp::{
    config::{ControllerConfig, Overrides},
    contact::Detector,
    controller::Controller,
    robot::RobotModel,
    state::State,
    suggestion::suggestion,
};

use super::{Event, ScenarioError, Variation, contents::Contents, file::CaseFile, groups::Robots};
use crate::{
    Plant, PlantConfig, PlantError, Sensors, SensorsConfig, World, check::Problems,
    sensors::ForceTorqueConfig,
};

/// One case of a [`Scenario`](super::Scenario).
#[derive(Clone, Debug)]
pub struct Case {
    name: String,
    /// The scenario's file.
    file: String,
    controller: PathBuf,
    set: Overrides,
    pub(super) contents: Arc<Contents>,
    variation: Arc<Variation>,
    /// Robots that are there already, if they are to be used.
    robots: Option<Arc<Robots>>,
}

/// Where the robot starts, at rest.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Initial {
    /// Position of the base, m, world. Default: the controller's home, which stands on its contacts where nothing else
    /// places it.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[serde(deserialize_with = "crate::exact::maybe")]
    pub position: Option<[f64; 3]>,
    /// Roll, pitch, yaw of the base, rad, each at most a turn.
    #[serde(deserialize_with = "crate::exact::numbers")]
    pub rpy: [f64; 3],
    /// Joint positions that differ from the robot's home, rad or m.
    pub joints: BTreeMap<String, f64>,
}

impl Case {
    pub(super) fn new(
        case: CaseFile,
        file: &str,
        directory: &Path,
        variation: &Arc<Variation>,
    ) -> Self {
        Self {
            name: case.name.into_inner(),
            file: file.to_owned(),
            controller: directory.join(&case.contents.controller),
            set: case.set,
            contents: case.contents,
            variation: variation.clone(),
            robots: None,
        }
    }

    /// The same whose controllers take their robots from there.
    pub(super) fn with_robots(mut self, robots: &Arc<Robots>) -> Self {
        self.robots = Some(robots.clone());
        self
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What differs from the scenario's file, beside the case's own changes.
    pub fn variation(&self) -> &Variation {
        &self.variation
    }

    /// The scenario's file, as errors call it.
    pub(super) fn file(&self) -> &str {
        &self.file
    }

    /// The controller's file.
    pub(super) fn controller_file(&self) -> &Path {
        &self.controller
    }

    /// Simulated time, s.
    pub fn duration(&self) -> f64 {
        self.contents.duration
    }

    /// Where the robot starts.
    pub fn initial(&self) -> &Initial {
        &self.contents.initial
    }

    /// The simulated world.
    pub fn plant(&self) -> &PlantConfig {
        &self.contents.plant
    }

    /// What the controller measures.
    pub fn sensors(&self) -> &SensorsConfig {
        &self.contents.sensors
    }

    /// The sensor at a frame.
    pub fn force_torque_at(&self, frame: &str) -> Option<&ForceTorqueConfig> {
        let mut sensors = self.contents.sensors.force_torque.iter();
        sensors.find(|sensor| sensor.frame == frame)
    }

    /// Contacts switched by measured force.
    pub fn detectors(&self) -> &[Detector] {
        &self.contents.detectors.entries
    }

    /// What changes at a given time, in the file's order.
    pub fn events(&self) -> &[Event] {
        &self.contents.events.entries
    }

    /// What is put into the controller's file.
    pub fn overrides(&self) -> &Overrides {
        &self.set
    }

    /// The values that a variation can scale, in the shape of the scenario's file: `duration`, `initial`, `plant`,
    /// `sensors`, with all defaults.
    pub fn values(&self) -> toml::Table {
        let mut values = toml::Table::new();
        values.insert("duration".into(), self.contents.duration.into());
        let tables = [
            ("initial", toml::Value::try_from(&self.contents.initial)),
            ("plant", toml::Value::try_from(&self.contents.plant)),
            ("sensors", toml::Value::try_from(&self.contents.sensors)),
        ];
        for (key, table) in tables {
            // What no TOML file can say has no values.
            if let Ok(table) = table {
                values.insert(key.into(), table);
            }
        }
        values
    }

    /// The controller's configuration.
    ///
    /// # Errors
    /// [`ScenarioError::Config`] if it is refused.
    pub fn controller_config(&self) -> Result<ControllerConfig, ScenarioError> {
        ControllerConfig::from_file_with(&self.controller, &self.set).map_err(|errors| {
            ScenarioError::Config {
                file: self.file.clone(),
                case: self.name.clone(),
                source: errors,
            }
        })
    }

    /// The controller of a configuration, its own or one like it.
    ///
    /// # Errors
    /// [`ScenarioError::Controller`] if it does not fit the robot.
    pub fn make_controller(&self, config: ControllerConfig) -> Result<Controller, ScenarioError> {
        let made = match &self.robots {
            Some(robots) => robots
                .load(&config)
                .and_then(|robot| Controller::with_robot(config, robot)),
            None => Controller::new(config),
        };
        made.map_err(|source| self.controller_error(source))
    }

    /// The plant, in its initial state, with the rotors at rest.
    ///
    /// # Errors
    /// [`ScenarioError::Plant`] if it refuses the robot, which is then not the controller's.
    pub fn make_plant(&self, robot: &RobotModel) -> Result<Plant, ScenarioError> {
        let initial = self.initial_state(robot)?;
        Plant::new(robot, &self.contents.plant, initial).map_err(|e| self.plant_error("plant", e))
    }

    pub(crate) fn make_sensors(
        &self,
        world: &dyn World,
        seed: u64,
    ) -> Result<Sensors, ScenarioError> {
        Sensors::new(&self.contents.sensors, world, seed)
            .map_err(|e| self.plant_error("sensors", e))
    }

    /// What is to be said of the numbers of `[initial]`.
    pub(super) fn initial_numbers(&self) -> Problems {
        let Initial {
            position,
            rpy,
            joints,
        } = &self.contents.initial;
        let mut problems = Problems::default();
        if let Some(position) = position {
            problems.finite("initial.position", position, "m");
        }
        problems.finite("initial.rpy", rpy, "rad");
        for (name, position) in joints {
            problems.number(&format!("initial.joints.{name}"), *position, "rad or m");
        }
        problems
    }

    pub(super) fn initial_state(&self, robot: &RobotModel) -> Result<State, ScenarioError> {
        let Initial {
            position,
            rpy,
            joints,
        } = &self.contents.initial;
        self.initial_numbers().into_result(|problems| {
            let first = problems.first().map_or("", String::as_str);
            self.refuse(first)
        })?;
        if let Some(angle) = rpy.iter().find(|angle| angle.abs() > TAU) {
            return Err(self.refuse(&format!(
                "initial.rpy: has {angle}, more than a turn: angles are in rad, 90° are 1.5708"
            )));
        }
        let mut state = robot.home.clone();
        if let Some(position) = position {
            state.p_WR = Vector3::from(*position);
        }
        state.R_WR = UnitQuaternion::from_euler_angles(rpy[0], rpy[1], rpy[2]);
        for (name, position) in joints {
            let joint = robot.model.joint(name).ok_or_else(|| {
                let known: Vec<&str> = robot
                    .model
                    .joints()
                    .iter()
                    .map(|j| j.name.as_str())
                    .collect();
                let hint = suggestion(name, &known);
                self.refuse(&format!(
                    "initial.joints: the robot has no joint `{name}`{hint}"
                ))
            })?;
            state.q[joint.index()] = *position;
        }
        Ok(state)
    }

    /// Number of control periods, at a rate in Hz.
    pub fn ticks(&self, rate: f64) -> usize {
        (self.contents.duration * rate).round() as usize
    }

    pub(super) fn refuse(&self, what: &str) -> ScenarioError {
        ScenarioError::Value {
            place: self.file.clone(),
            what: what.to_owned(),
        }
    }

    /// Keys in the error count from `table`.
    pub(crate) fn plant_error(&self, table: &'static str, source: PlantError) -> ScenarioError {
        ScenarioError::Plant {
            file: self.file.clone(),
            table,
            places: Vec::new(),
            source: Box::new(source),
        }
    }
}
