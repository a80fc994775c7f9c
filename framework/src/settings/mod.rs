//! The settings of a controller: the tables `[controller]` and `[measurement]` of a file.

mod formulation;
mod measurement;
mod observer;
mod target;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error::BindError;

pub use formulation::Formulation;
pub use measurement::MeasurementLimits;
pub use observer::{ContactForces, Observer};
pub(crate) use target::Target;

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
    /// Velocities and an unknown wrench from the motion that the model predicts. Without it velocities are those that
    /// are measured, and the model is taken at its word.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub observer: Option<Observer>,
}

/// Where references begin that have no value of their own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum StartFrom {
    /// At what is measured in the first tick. A robot that is measured near its home
    /// ([`AT_HOME`](crate::plugin::AT_HOME)) begins there.
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

/// Hz. A simulation of a rate far above would not end.
const FASTEST: f64 = 1e6;

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
            observer: None,
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
        .map(move |(key, value, _, rule)| {
            // Of a value that nobody wrote the rate is what is wrong.
            if key == "velocity_leak" && rate_is_good && value == default_velocity_leak() {
                let problem = format!(
                    "is {} Hz, whose period is longer than `velocity_leak`, {value} s: set that too",
                    self.rate
                );
                return ("rate", problem);
            }
            (key, format!("must be finite and {rule}, is {value}"))
        })
        .chain((self.rate.is_finite() && self.rate > FASTEST).then(|| {
            let rate = self.rate;
            ("rate", format!("must be at most {FASTEST:e} Hz, is {rate:e}: no tick takes less than a microsecond"))
        }))
        .chain(self.first_error_problems())
        .chain(
            self.observer
                .iter()
                .flat_map(|observer| observer.problems(self.rate)),
        )
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
