//! One case of a scenario, with everything that the file, its changes and a variation say.

use std::{
    collections::{BTreeMap, HashSet},
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

use super::{
    Event, ScenarioError, Variation,
    check::{Common, Groups, Known, Robots},
    contents::Contents,
    file::{CaseFile, Text},
    push::Asked,
};
use crate::{Plant, PlantConfig, PlantError, Sensors, SensorsConfig, World};

/// Control periods of a run, at most: at 250 Hz more than four days of simulated time.
const MOST_TICKS: f64 = 1e8;
/// Integration steps of a run, at most: at some microseconds each, a day.
const MOST_STEPS: f64 = 1e10;

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
    /// Roll, pitch, yaw of the base, rad.
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

    pub(super) fn initial_state(&self, robot: &RobotModel) -> Result<State, ScenarioError> {
        let Initial {
            position,
            rpy,
            joints,
        } = &self.contents.initial;
        let numbers = [
            (
                "position",
                position.as_ref().map_or(&[][..], <[f64; 3]>::as_slice),
            ),
            ("rpy", rpy.as_slice()),
        ];
        let joints_numbers = joints.iter().map(|(name, q)| {
            let key = format!("joints.{name}");
            (key, std::slice::from_ref(q))
        });
        let numbers = numbers.map(|(key, numbers)| (key.to_owned(), numbers));
        for (key, numbers) in numbers.into_iter().chain(joints_numbers) {
            if !numbers.iter().all(|x| x.is_finite()) {
                let what = format!("initial.{key}: has a number that is not finite");
                return Err(self.refuse(&what));
            }
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

    /// Makes everything once, as far as no other case of its group did.
    pub(super) fn check(
        &self,
        index: usize,
        text: &Text<'_>,
        groups: &Groups<'_>,
    ) -> Result<(), ScenarioError> {
        if !(self.contents.duration.is_finite() && self.contents.duration > 0.0) {
            return Err(self.refuse(&format!(
                "duration: is {} s, must be positive and finite",
                self.contents.duration
            )));
        }
        let common = groups.common(index, self)?;
        if common.is_checked(&self.contents) {
            return Ok(());
        }
        if self.ticks(common.rate) == 0 {
            return Err(self.refuse(&format!(
                "duration: is {} s, shorter than a control period, which is {} s",
                self.contents.duration,
                1.0 / common.rate
            )));
        }
        self.check_marks(text)?;
        let plant = self.make_plant(&common.robot)?;
        self.check_length(common.rate)?;
        self.make_sensors(&plant, 0)?;
        self.check_beginnings(text, common.rate)?;
        self.check_detectors(text, groups, &common)?;
        let known = if let Some(known) = common.known(&self.contents) {
            known
        } else {
            let asked = self.check_events(text, groups, &common)?;
            let known = Arc::new(Known {
                contents: self.contents.clone(),
                asked,
            });
            common.remember(&known);
            known
        };
        self.check_pushes(text, &common.robot, &common.contacts, &known.asked)?;
        common.checked(&self.contents);
        Ok(())
    }

    /// Refuses a run that would not end in a day or two.
    fn check_length(&self, rate: f64) -> Result<(), ScenarioError> {
        let ticks = self.contents.duration * rate;
        if ticks > MOST_TICKS {
            return Err(self.refuse(&format!(
                "duration: is {:e} s, which are {ticks:.1e} control periods at {rate} Hz; a run has at most \
                 {MOST_TICKS:e}: make it shorter",
                self.contents.duration
            )));
        }
        let steps = ticks * (1.0 / (rate * self.contents.plant.step)).ceil();
        if steps > MOST_STEPS {
            return Err(self.refuse(&format!(
                "plant.step: is {:e} s, which makes {steps:.1e} steps in {} s; a run has at most {MOST_STEPS:e}: make \
                 the step larger or the run shorter",
                self.contents.plant.step, self.contents.duration
            )));
        }
        Ok(())
    }

    /// The log keeps the times of each disturbance under marks of its own.
    fn check_marks(&self, text: &Text<'_>) -> Result<(), ScenarioError> {
        let mut disturbances: HashSet<&str> = HashSet::new();
        for (index, disturbance) in self.contents.plant.disturbances.iter().enumerate() {
            let name = disturbance.name.as_str();
            // Changes call it by its name as well.
            if !disturbances.insert(name) {
                let of_nameless = match name {
                    crate::plant::DISTURBANCE => ", which one without a name has,",
                    _ => "",
                };
                return Err(self.refuse(&format!(
                    "plant.disturbance[{index}].name: `{name}`{of_nameless} is used twice: give it another one"
                )));
            }
        }
        for (event, span) in self.contents.events.iter() {
            let Some(mark) = &event.mark else {
                continue;
            };
            let mut names = ["_start", "_end"]
                .iter()
                .filter_map(|end| mark.strip_suffix(end));
            let taken = names.find(|name| disturbances.contains(name));
            if let Some(disturbance) = taken {
                return Err(ScenarioError::Value {
                    place: text.place(span.start),
                    what: format!(
                        "event `{mark}` at {} s: the log keeps a time of the disturbance `{}` under this mark; take \
                         another one",
                        event.at, disturbance
                    ),
                });
            }
        }
        Ok(())
    }

    fn check_detectors(
        &self,
        text: &Text<'_>,
        groups: &Groups<'_>,
        common: &Common,
    ) -> Result<(), ScenarioError> {
        let mut detected = HashSet::new();
        for (detector, span) in self.contents.detectors.iter() {
            let refuse = |what: String| ScenarioError::Value {
                place: text.place(span.start),
                what: format!("detector: {what}"),
            };
            detector.validate().map_err(|e| refuse(e.to_string()))?;
            if !detected.insert(&detector.contact) {
                let what = format!("contact `{}` has a detector already", detector.contact);
                return Err(refuse(what));
            }
            let mut contacts = common.contacts.iter();
            let Some(contact) = contacts.find(|c| c.name == detector.contact) else {
                // It says which there are.
                let controller = groups.fresh(self, common)?;
                let unknown = controller.contact(&detector.contact).err();
                return Err(refuse(unknown.map_or_else(String::new, |e| e.to_string())));
            };
            let frame = &contact.frame;
            if !self
                .contents
                .sensors
                .force_torque
                .iter()
                .any(|s| &s.frame == frame)
            {
                return Err(refuse(format!(
                    "no force is measured at contact `{}`: there is no [[sensors.force_torque]] with frame = \
                     \"{frame}\"",
                    detector.contact
                )));
            }
        }
        Ok(())
    }

    /// Applies every event once, and looks at what is asked of the controller until the end.
    fn check_events(
        &self,
        text: &Text<'_>,
        groups: &Groups<'_>,
        common: &Common,
    ) -> Result<Vec<Asked>, ScenarioError> {
        let mut controller = groups.fresh(self, common)?;
        let rate = common.rate;
        let last_tick = self.ticks(rate).saturating_sub(1) as f64 / rate;
        let mut marks = HashSet::new();
        for (index, (event, span)) in self.contents.events.iter().enumerate() {
            let refuse = |what: String| ScenarioError::Value {
                place: text.place_in_event(&self.name, index, span, &what),
                what: match &event.mark {
                    Some(mark) => format!("event `{mark}` at {} s: {what}", event.at),
                    None => format!("event at {} s: {what}", event.at),
                },
            };
            if event.is_idle() {
                return Err(refuse(
                    "does nothing: give it an action, such as `follow`, or a `mark`, or take it out".into(),
                ));
            }
            // The check applies every event to a controller that never runs.
            event.apply(&mut controller).map_err(&refuse)?;
            if event.at > last_tick + 1e-6 / rate {
                return Err(refuse(format!(
                    "would never happen: the last tick is at {last_tick:.3} s"
                )));
            }
            if let Some(mark) = &event.mark
                && !marks.insert(mark.as_str())
            {
                return Err(refuse("another event has the same mark".into()));
            }
        }
        let mut events: Vec<&Event> = self.events().iter().collect();
        events.sort_by(|a, b| a.at.total_cmp(&b.at));
        if !events.is_empty() {
            // Without what happens later.
            controller = groups.fresh(self, common)?;
        }
        self.asked(&mut controller, &events)
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
