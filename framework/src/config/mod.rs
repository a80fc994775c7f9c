//! The configuration of a controller: what a TOML file says, or what code puts together.
//!
//! A file has the tables `[controller]` ([`Settings`]), `[robot]`, `[solver]`, `[fallback]` and `[measurement]`
//! ([`MeasurementLimits`]; these three are optional), and any number of `[[contact]]` ([`ContactSpec`]), `[[task]]` and
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
//! | `hardness` | tasks `"soft"`, constraints `"hard"` | or `{ exact = λ }`: [`Hardness`](crate::plugin::Hardness) |
//!
//! A file may be short ([`expand()`] writes it out, [`ControllerConfig::implied`] lists what it leaves to defaults): a
//! contact with the key `motion` brings its own constraints, a robot with a `file` needs no `type`, and names, weights
//! and dampings have defaults.
//!
//! Loading refuses every key that nobody knows, and reports all mistakes of a file at once
//! ([`ConfigErrors`]). [`Overrides`] replace single values. Saving what was loaded, loading and saving again
//! gives the same text.

mod build;
mod compose;
mod defaults;
mod document;
mod entry;
mod error;
mod expand;
pub mod json_schema;
mod load;
mod meaning;
mod origin;
mod overrides;
pub mod plausible;
mod report;
mod save;
mod table;
mod words;

use std::path::PathBuf;

use crate::{
    contact::ContactSpec,
    plugin::{AnyConstraint, AnyFallbackLaw, AnyTask, Entry},
    qp::Solver,
    settings::{MeasurementLimits, Settings},
};
use wbqp_robot_model::{Diagnostic, Robot, SourceFile};

pub use build::Plan;
pub use error::{ConfigError, ConfigErrorKind, ConfigErrors};
pub use expand::expand;
pub use meaning::check_reference;
pub use overrides::{Overrides, key_path};
pub use words::in_words;

/// Everything a controller is made of.
#[derive(Debug)]
pub struct ControllerConfig {
    /// Rate, formulation and the other settings of the loop.
    pub settings: Settings,
    /// The robot.
    pub robot: Box<dyn Robot>,
    /// The solver.
    pub solver: Box<dyn Solver>,
    /// The fallback law.
    pub fallback: Box<dyn AnyFallbackLaw>,
    /// What a measurement may be.
    pub measurement: MeasurementLimits,
    /// Contacts, in the order of their ids.
    pub contacts: Vec<ContactSpec>,
    /// Tasks, in the order of their ids.
    pub tasks: Vec<Entry<dyn AnyTask>>,
    /// Constraints, in the order of their ids.
    pub constraints: Vec<Entry<dyn AnyConstraint>>,
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

impl ControllerConfig {
    /// A configuration without tasks, constraints and contacts, with the default solver.
    pub fn new(settings: Settings, robot: Box<dyn Robot>) -> Self {
        Self {
            settings,
            robot,
            solver: defaults::solver(),
            fallback: defaults::fallback(),
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
    /// go with the robot's own into [`RobotModel::diagnostics`](wbqp_robot_model::RobotModel::diagnostics) of the
    /// controller's robot, into logs and dumps.
    pub fn warnings(&self) -> &[Diagnostic] {
        &self.warnings
    }
}
