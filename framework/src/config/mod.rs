//! The configuration of a controller: what a TOML file says, or what code puts together.
//!
//! A file has the tables `[controller]` ([`Settings`]), `[robot]`, `[solver]` and `[measurement]`
//! ([`MeasurementLimits`]; both optional), and any number of `[[contact]]` ([`ContactSpec`]), `[[task]]` and
//! `[[constraint]]`:
//! ```toml
//! [[task]]
//! name = "arm"            # entry keys: name, type, weight, active, transition, hardness
//! type = "posture"        # a linked plug-in
//! weight = 0.1            # a number, or one per row
//! kp = 25.0               # the plug-in's own keys
//! ```
//! | entry key | default | meaning |
//! |---|---|---|
//! | `name` | `<frame>_<type>`, `<contact>_<type>` or `<type>` | unique among tasks and constraints |
//! | `type` | | the plug-in |
//! | `weight` | the plug-in's, if it declares one | linear, ≥ 0; needed unless hard |
//! | `active` | `true` | on at the start |
//! | `transition` | `0.0` | duration of the ramp when it is switched or reweighted, s |
//! | `hardness` | tasks `"soft"`, constraints `"hard"` | or `{ exact = λ }`, see [`Hardness`](crate::entry::Hardness) |
//!
//! A file may be short ([`expand()`] writes it out, [`ControllerConfig::implied`] lists what it leaves to defaults): a
//! contact with the key `motion` brings its own constraints, a robot with a `file` needs no `type`, and names, weights
//! and dampings have defaults.
//!
//! Loading refuses every key that nobody knows, and reports all mistakes of a file at once
//! ([`ConfigErrors`]). [`Overrides`] replace single values. Saving what was loaded, loading and saving again
//! gives the same text.

mod compose;
mod document;
mod entry;
mod error;
pub(crate) mod expand;
mod fault;
mod load;
mod meaning;
mod measurement;
mod overrides;
mod report;
mod save;
pub(crate) mod schema;
mod table;

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{
    actuator::ActuatorKind,
    constraint::Constraint,
    contact::ContactSpec,
    entry::Entry,
    qp::{ActiveSet, Solver},
    robot::{Diagnostic, Robot, RobotModel, SourceFile},
    setup::BindError,
    task::Task,
};

pub use error::{ConfigError, ConfigErrorKind, ConfigErrors};
pub use expand::{Implied, ImpliedValue, expand};
pub(crate) use fault::{Fault, Origin};
pub use measurement::MeasurementLimits;
pub use overrides::{Override, Overrides, Target};
pub use save::SaveError;

/// The framework's keys of a task or constraint beside `type`; no plug-in may have them.
const ENTRY_KEYS: [&str; 6] = [
    "name",
    "weight",
    "active",
    "transition",
    "hardness",
    "level",
];

/// Everything a controller is made of.
#[derive(Debug)]
pub struct ControllerConfig {
    /// Rate, formulation and the other settings of the loop.
    pub settings: Settings,
    /// The robot.
    pub robot: Box<dyn Robot>,
    /// The solver.
    pub solver: Box<dyn Solver>,
    /// What a measurement may be.
    pub measurement: MeasurementLimits,
    /// Contacts, in the order of their ids.
    pub contacts: Vec<ContactSpec>,
    /// Tasks, in the order of their ids.
    pub tasks: Vec<Entry<dyn Task>>,
    /// Constraints, in the order of their ids.
    pub constraints: Vec<Entry<dyn Constraint>>,
    /// Where relative paths count from.
    pub directory: PathBuf,
    /// The file it was loaded from, for logs, and for errors that only the robot shows.
    pub source: Option<SourceFile>,
    /// What replaced the file's values.
    pub(crate) overrides: Overrides,
    /// What may be a mistake in it.
    pub(crate) warnings: Vec<Diagnostic>,
    /// Whether a controller keeps its text.
    pub(crate) keeping: Keeping,
}

/// What a controller keeps of its configuration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Keeping {
    /// Its text, for dumps of ticks.
    #[default]
    Text,
    Nothing,
}

/// The `[controller]` table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Ticks per second, Hz.
    #[schemars(extend("x-unit" = "Hz"))]
    pub rate: f64,
    /// Which variables the problem has.
    #[serde(default)]
    pub formulation: Formulation,
    /// Weight of `‖(u, f)‖²` relative to the largest weight that is on; owned by the row `regularisation`.
    #[serde(default = "default_regularisation")]
    #[schemars(extend("x-unit" = "1"))]
    pub regularisation: f64,
    /// Time constant with which a joint's velocity reference leaks to the measured velocity, s.
    #[serde(default = "default_velocity_leak")]
    #[schemars(extend("x-unit" = "s"))]
    pub velocity_leak: f64,
    /// How long the last solution is carried on when a tick has none, s; after it the safe law takes over. The default
    /// is a few periods, and no longer than a rotor or a servo takes to follow a command: the robot hardly leaves the
    /// path that was planned.
    #[serde(default = "default_extrapolation")]
    #[schemars(extend("x-unit" = "s"))]
    pub extrapolation: f64,
    /// Whether a robot with a floating base is refused if nothing carries it at the start: neither a contact that is on
    /// nor rotors that can hold its home posture.
    #[serde(default)]
    pub hover: Hover,
    /// Where references begin that have no value of their own.
    #[serde(default)]
    pub start: StartFrom,
    /// The largest error of a task in the first tick: beyond it the tick is a fault, and nothing moves until one is
    /// plausible.
    #[serde(default)]
    pub max_first_error: FirstError,
    /// The most memory that the problem of a tick and its solvers may take, MiB. What they take is known from the
    /// numbers of variables and rows; a controller that needs more is refused before any of it is allocated.
    #[serde(default = "default_max_memory")]
    #[schemars(extend("x-unit" = "MiB"))]
    pub max_memory: f64,
}

/// Where references begin that have no value of their own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum StartFrom {
    /// At what is measured in the first tick. A robot that is measured near its home
    /// ([`AT_HOME`](crate::reference::AT_HOME)) begins there.
    #[default]
    Measured,
    /// At the home posture, wherever the robot is.
    Home,
}

/// How far a task may be from its reference in the first tick; `inf` for any distance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct FirstError {
    /// Of tasks whose error is a length: its norm, of prismatic joints the largest, m.
    #[schemars(extend("x-unit" = "m"))]
    pub position: f64,
    /// Of tasks whose error is an angle: its norm, of revolute joints the largest, rad.
    #[schemars(extend("x-unit" = "rad"))]
    pub rotation: f64,
}

impl Default for FirstError {
    fn default() -> Self {
        Self {
            position: 0.5,
            rotation: 0.5,
        }
    }
}

impl FirstError {
    /// Any error is taken.
    pub const ANY: Self = Self {
        position: f64::INFINITY,
        rotation: f64::INFINITY,
    };
}

/// Whether a robot must be able to hover.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Hover {
    /// With a floating base and no contact that is on at the start: in the home posture, within the limits of its
    /// actuators; without rotors it cannot.
    #[default]
    Required,
    /// Not checked: a robot that falls at first, that something else carries, or that hovers in another posture.
    Unchecked,
}

fn default_regularisation() -> f64 {
    1e-9
}
fn default_extrapolation() -> f64 {
    0.02
}
fn default_max_memory() -> f64 {
    1024.0
}
fn default_velocity_leak() -> f64 {
    0.5
}

impl Settings {
    /// Defaults at a rate in Hz.
    pub fn at_rate(rate: f64) -> Self {
        Self {
            rate,
            formulation: Formulation::default(),
            regularisation: default_regularisation(),
            velocity_leak: default_velocity_leak(),
            extrapolation: default_extrapolation(),
            hover: Hover::default(),
            start: StartFrom::default(),
            max_first_error: FirstError::default(),
            max_memory: default_max_memory(),
        }
    }

    /// Checks the numbers.
    ///
    /// # Errors
    /// Names the first key that is not finite or out of range.
    pub fn validate(&self) -> Result<(), BindError> {
        match self.problems().next() {
            Some((key, problem)) => Err(BindError::value(key, problem)),
            None => Ok(()),
        }
    }

    /// Keys with what is wrong with them.
    pub(crate) fn problems(&self) -> impl Iterator<Item = (&'static str, String)> {
        let rate_is_good = self.rate.is_finite() && self.rate > 0.0;
        [
            ("rate", self.rate, rate_is_good, "positive"),
            (
                "regularisation",
                self.regularisation,
                self.regularisation > 0.0,
                "positive",
            ),
            (
                "velocity_leak",
                self.velocity_leak,
                !rate_is_good || self.velocity_leak * self.rate >= 1.0,
                "at least one period",
            ),
            (
                "extrapolation",
                self.extrapolation,
                self.extrapolation >= 0.0,
                "not negative",
            ),
            (
                "max_memory",
                self.max_memory,
                self.max_memory > 0.0,
                "positive",
            ),
        ]
        .into_iter()
        .filter(|(_, value, allowed, _)| !value.is_finite() || !allowed)
        .map(|(key, value, _, rule)| (key, format!("must be finite and {rule}, is {value}")))
        .chain(self.first_error_problems())
    }

    fn first_error_problems(&self) -> impl Iterator<Item = (&'static str, String)> {
        let FirstError { position, rotation } = self.max_first_error;
        [
            ("max_first_error.position", position),
            ("max_first_error.rotation", rotation),
        ]
        .into_iter()
        .filter(|(_, value)| value.is_nan() || *value <= 0.0)
        .map(|(key, value)| (key, format!("must be positive, `inf` for any, is {value}")))
    }
}

/// Formulations of the same optimum.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Formulation {
    /// The faster one of the next two: torque-eliminated for a robot with a joint motor, condensed for one with rotors
    /// alone, where they are the same.
    ///
    /// Without hard contacts both have as many variables. The torque-eliminated form factorises 6 rows of the dynamics
    /// (and those of passive joints) instead of all nv and keeps the tree's sparsity, against one row instead of a
    /// bound per torque limit: it is the cheaper the more joints there are. Whole ticks, condensed over
    /// torque-eliminated, from the table of formulations in `docs/performance.md`: 1.05 for six rotors and three joints
    /// at a point contact, 1.8 for a standing quadruped (12 joints), 2.3 for a humanoid (31 joints, two soles). Light
    /// arms on heavy bases are better conditioned, too, by their accelerations than by their torques.
    #[default]
    Auto,
    /// Variables (u, f): `v̇` is substituted from the dynamics, the paper's (8).
    Condensed,
    /// Variables (q̈, u, f): the torques of driven joints are substituted from their own rows of the dynamics, the
    /// other accelerations from the rest. `u` is then the thrusts. Contacts whose motion is a hard constraint determine
    /// as many accelerations of their joints as they have rows: these are substituted as well, unless the limb is
    /// stretched.
    TorqueEliminated,
    /// Variables (v̇, u, f): the dynamics are equality rows, (10d).
    Explicit,
}

impl Formulation {
    /// What `Auto` means for a robot; the formulation itself otherwise.
    pub fn resolve(self, robot: &RobotModel) -> Self {
        match self {
            Self::Auto
                if robot
                    .actuators
                    .iter()
                    .any(|a| matches!(a.kind, ActuatorKind::Joint(_))) =>
            {
                Self::TorqueEliminated
            }
            Self::Auto => Self::Condensed,
            other => other,
        }
    }
}

impl ControllerConfig {
    /// A configuration without tasks, constraints and contacts, with the default solver.
    pub fn new(settings: Settings, robot: Box<dyn Robot>) -> Self {
        Self {
            settings,
            robot,
            solver: Box::new(ActiveSet::default()),
            measurement: MeasurementLimits::default(),
            contacts: Vec::new(),
            tasks: Vec::new(),
            constraints: Vec::new(),
            directory: PathBuf::new(),
            source: None,
            overrides: Overrides::new(),
            warnings: Vec::new(),
            keeping: Keeping::default(),
        }
    }

    /// A controller that keeps nothing of what it was made from, for one that is only looked at: writing a
    /// configuration out takes as long as making the controller. It cannot record its ticks
    /// ([`Controller::with_recorder`](crate::Controller::with_recorder)).
    pub fn without_record(mut self) -> Self {
        self.keeping = Keeping::Nothing;
        self
    }

    /// What may be a mistake in the file and was taken as it is: numbers that no robot has, weights too far apart. They
    /// go with the robot's own into [`RobotModel::diagnostics`] of the controller's robot, into logs and dumps.
    pub fn warnings(&self) -> &[Diagnostic] {
        &self.warnings
    }
}
