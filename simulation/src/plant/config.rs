//! The `[plant]` table: everything about the simulated world that is not the robot.

use std::collections::HashSet;

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::PlantError;
use crate::check::Problems;

/// Largest step that is accepted, s: the contact needs it.
pub const LARGEST_STEP: f64 = 4e-4;

/// Smallest step that is accepted, s: of smaller ones there is no end, and rounding grows.
pub const SMALLEST_STEP: f64 = 1e-7;

/// Tolerances that make sense: below rounding stops steps, above nothing is controlled.
const TOLERANCES: (f64, f64) = (1e-12, 1e-3);

/// Shortest time that a disturbance acts, s: the clock's tolerance has no part in it.
const SHORTEST_WINDOW: f64 = 1e-6;

/// Largest factor of a mismatch: beyond it, it was meant as something else.
const LARGEST_FACTOR: f64 = 20.0;

/// Name of a disturbance that is given none.
pub const DISTURBANCE: &str = "disturbance";

/// Everything about the simulated world that is not the robot. The default is free space, exact parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PlantConfig {
    /// Integration step, s; from [`SMALLEST_STEP`] to [`LARGEST_STEP`]. Each [`advance`](super::Plant::advance) takes
    /// whole steps of at most this length.
    pub step: f64,
    /// Error-controlled steps in place of equal ones: the largest estimated error of one step in any of m, rad, m/s
    /// and rad/s, or of 100 N of thrust; 1e-12 to 1e-3. Steps are as long as that allows, up to a whole period. Touch
    /// and release are where they are, disturbances begin and end at their times. Steps get as short as an eighth of
    /// `step`, below 1e-6 with the fifth root of the tolerance (`step` / 127 at 1e-12), and are then
    /// taken whatever their error, which [`Plant::beyond_tolerance`](super::Plant::beyond_tolerance) tells. Without it
    /// all steps are `step` long. 1e-6 is nearer to the truth than the default step and several times as fast.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
    /// Control periods between a measurement and the start of its command.
    pub command_delay: usize,
    /// Speed below which the Coulomb friction of a joint without servo fades, rad/s or m/s: `F tanh(q̇ / this)`.
    /// Made larger where the step needs it.
    pub friction_speed: f64,
    /// How the plant's parameters differ from the controller's.
    pub mismatch: Mismatch,
    /// Servos of the joints that are commanded with a velocity.
    pub servo: ServoConfig,
    /// Planes that the contact points cannot pass.
    #[serde(rename = "wall", skip_serializing_if = "Vec::is_empty")]
    pub walls: Vec<WallConfig>,
    /// The points of the robot that touch walls. Every point can touch every wall.
    #[serde(rename = "contact_point", skip_serializing_if = "Vec::is_empty")]
    pub contact_points: Vec<ContactPointConfig>,
    /// Wrenches from outside, unknown to the controller and to the sensors.
    #[serde(rename = "disturbance", skip_serializing_if = "Vec::is_empty")]
    pub disturbances: Vec<Disturbance>,
}

/// How the plant's parameters differ from the controller's. The default is not at all.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Mismatch {
    /// Factor on the mass of every body and, as it would be with a denser material, on its inertia.
    pub mass_scale: f64,
    /// Shift of the base body's centre of mass, m, body axes.
    #[serde(deserialize_with = "crate::exact::numbers")]
    pub com_shift: [f64; 3],
    /// Further factor on every body's inertia about its centre of mass.
    pub inertia_scale: f64,
    /// Thrust that rotors produce relative to the thrust that was commanded.
    pub thrust_scale: f64,
    /// Further factors on it, one per rotor in the robot's order, 0 for one that is dead; none: all 1.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub rotor_scales: Vec<f64>,
    /// Factor on the time constants of all rotors.
    pub rotor_lag_scale: f64,
    /// Largest thrust that a rotor produces, N, whatever the controller's limit; `inf` for no other limit.
    pub thrust_max: f64,
}

/// A velocity servo: `v̇ = sat((v_ref − v) / time_constant)`, whatever effort that takes up to the stall limit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ServoConfig {
    /// Time constant, s.
    pub time_constant: f64,
    /// Largest acceleration, rad/s² or m/s²; `inf` for none.
    pub acceleration_limit: f64,
}

/// A plane with friction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WallConfig {
    /// Unique name, for logs.
    pub name: String,
    /// A point of the plane, m, world.
    #[serde(deserialize_with = "crate::exact::numbers")]
    pub point: [f64; 3],
    /// Outward normal, towards the robot, world axes; any length but zero.
    #[serde(deserialize_with = "crate::exact::numbers")]
    pub normal: [f64; 3],
    /// Normal stiffness k, N/m.
    #[serde(default = "stiffness")]
    pub stiffness: f64,
    /// Normal damping c, N·s/m.
    #[serde(default = "damping")]
    pub damping: f64,
    /// Coulomb coefficient μ, for sticking and for sliding.
    #[serde(default = "friction")]
    pub friction: f64,
    /// Viscous coefficient b, N·s/m: a force `−b v_t` while in contact, beside the Coulomb force.
    #[serde(default)]
    pub viscous: f64,
    /// Tangential stiffness k_t, N/m; the normal stiffness if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tangential_stiffness: Option<f64>,
    /// Tangential damping c_t, N·s/m; the default normal damping if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tangential_damping: Option<f64>,
}

/// A point of the robot that touches walls.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactPointConfig {
    /// Named frame of the robot.
    pub frame: String,
    /// The point in that frame, m.
    #[serde(default)]
    #[serde(deserialize_with = "crate::exact::numbers")]
    pub offset: [f64; 3],
}

/// A wrench at the origin of a frame during `[from, until)`. Of equal steps in which it begins or ends it acts on all
/// with the share of it that it has.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Disturbance {
    /// Name under which the log's timeline keeps its start and end, and by which a case changes it.
    #[serde(default = "disturbance_name")]
    pub name: String,
    /// Named frame of the robot; links are frames too.
    pub frame: String,
    /// Force on the robot, N, world axes.
    #[serde(default)]
    #[serde(deserialize_with = "crate::exact::numbers")]
    pub force: [f64; 3],
    /// Moment on the robot about the frame's origin, N·m, world axes.
    #[serde(default)]
    #[serde(deserialize_with = "crate::exact::numbers")]
    pub moment: [f64; 3],
    /// Start, s.
    #[serde(default)]
    pub from: f64,
    /// End, s; `inf` (the default) for never.
    #[serde(default = "never")]
    pub until: f64,
}

fn stiffness() -> f64 {
    2e4
}
// A little under half of critical for 0.2 kg, the effective mass of a small arm's tip.
fn damping() -> f64 {
    60.0
}
fn friction() -> f64 {
    0.5
}
fn disturbance_name() -> String {
    DISTURBANCE.to_owned()
}
fn never() -> f64 {
    f64::INFINITY
}

impl Default for PlantConfig {
    fn default() -> Self {
        Self {
            step: 2.5e-4,
            tolerance: None,
            command_delay: 1,
            friction_speed: 0.01,
            mismatch: Mismatch::default(),
            servo: ServoConfig::default(),
            walls: Vec::new(),
            contact_points: Vec::new(),
            disturbances: Vec::new(),
        }
    }
}

impl Default for Mismatch {
    fn default() -> Self {
        Self {
            mass_scale: 1.0,
            com_shift: [0.0; 3],
            inertia_scale: 1.0,
            thrust_scale: 1.0,
            rotor_scales: Vec::new(),
            rotor_lag_scale: 1.0,
            thrust_max: f64::INFINITY,
        }
    }
}

impl Default for ServoConfig {
    fn default() -> Self {
        Self {
            time_constant: 0.03,
            acceleration_limit: 100.0,
        }
    }
}

impl WallConfig {
    /// A wall of the default material.
    pub fn new(name: &str, point: Vector3<f64>, normal: Vector3<f64>) -> Self {
        Self {
            name: name.to_owned(),
            point: point.into(),
            normal: normal.into(),
            stiffness: stiffness(),
            damping: damping(),
            friction: friction(),
            viscous: 0.0,
            tangential_stiffness: None,
            tangential_damping: None,
        }
    }

    /// k_t, N/m.
    pub(super) fn tangential_stiffness(&self) -> f64 {
        self.tangential_stiffness.unwrap_or(self.stiffness)
    }

    /// c_t, N·s/m. Not the normal damping by default: that one may be zero.
    pub(super) fn tangential_damping(&self) -> f64 {
        self.tangential_damping.unwrap_or_else(damping)
    }

    fn check(&self, key: &str, step: f64, problems: &mut Problems) {
        let key = |name| format!("{key} `{}`: {name}", self.name.escape_debug());
        problems.finite(&key("point"), &self.point, "m");
        problems.finite(&key("normal"), &self.normal, "1");
        if Vector3::from(self.normal).norm() == 0.0 {
            problems.add(
                &key("normal"),
                "is zero, must point from the wall to the robot",
            );
        }
        problems.positive(&key("stiffness"), self.stiffness, "N/m");
        problems.not_negative(&key("damping"), self.damping, "N·s/m");
        problems.not_negative(&key("friction"), self.friction, "1");
        problems.not_negative(&key("viscous"), self.viscous, "N·s/m");
        let (k_t, c_t) = (self.tangential_stiffness(), self.tangential_damping());
        problems.positive(&key("tangential_stiffness"), k_t, "N/m");
        problems.positive(&key("tangential_damping"), c_t, "N·s/m");
        if k_t * step > c_t {
            let what = format!(
                "is {c_t}, must be at least tangential_stiffness × step = {}",
                k_t * step
            );
            problems.add(&key("tangential_damping"), &what);
        }
    }
}

impl Disturbance {
    pub(super) fn check(&self, key: &str, problems: &mut Problems) {
        problems.finite(&format!("{key}.force"), &self.force, "N");
        problems.finite(&format!("{key}.moment"), &self.moment, "N·m");
        problems.number(&format!("{key}.from"), self.from, "s");
        if self.until.is_nan() || self.until < self.from {
            let what = format!("is {}, must not be before from = {}", self.until, self.from);
            problems.add(&format!("{key}.until"), &what);
        } else if self.until > self.from && self.until - self.from < SHORTEST_WINDOW {
            let what = format!(
                "is less than {SHORTEST_WINDOW:e} s after from = {}: let a smaller force act for longer",
                self.from
            );
            problems.add(&format!("{key}.until"), &what);
        } else if self.until.is_finite() {
            problems.number(&format!("{key}.until"), self.until, "s");
        }
    }
}

/// A factor that nobody means, such as a percentage.
fn check_factor(key: &str, value: f64, problems: &mut Problems) {
    if value.is_finite() && value > LARGEST_FACTOR {
        let what = format!(
            "is {value}, must be at most {LARGEST_FACTOR}: it is a factor, 1.05 for 5 % more"
        );
        problems.add(key, &what);
    }
}

impl PlantConfig {
    /// Checks every number. Names of frames are checked when the plant is made.
    ///
    /// # Errors
    /// [`PlantError::Config`] with every problem, each naming its key.
    pub fn validate(&self) -> Result<(), PlantError> {
        let problems = self.check();
        problems.into_result(|problems| PlantError::Config { problems })
    }

    /// What is to be said of its numbers.
    pub(crate) fn check(&self) -> Problems {
        let mut problems = Problems::default();
        let step = self.step;
        if step.is_nan() || step <= 0.0 || step > LARGEST_STEP {
            let what = format!("is {step}, must be positive and at most {LARGEST_STEP} s");
            problems.add("step", &what);
        } else if step < SMALLEST_STEP {
            let what = format!("is {step:e}, must be at least {SMALLEST_STEP:e} s");
            problems.add("step", &what);
        }
        if let Some(tolerance) = self.tolerance
            && !(TOLERANCES.0..=TOLERANCES.1).contains(&tolerance)
        {
            let (least, most) = TOLERANCES;
            let what = format!("is {tolerance}, must be from {least:e} to {most:e}");
            problems.add("tolerance", &what);
        }
        if self.command_delay > 1000 {
            let what = format!("is {}, must be at most 1000 periods", self.command_delay);
            problems.add("command_delay", &what);
        }
        let Mismatch {
            mass_scale,
            com_shift,
            inertia_scale,
            thrust_scale,
            ref rotor_scales,
            rotor_lag_scale,
            thrust_max,
        } = self.mismatch;
        let mut factor = |key: &str, value: f64| {
            let key = format!("mismatch.{key}");
            problems.positive(&key, value, "1");
            check_factor(&key, value, &mut problems);
        };
        factor("mass_scale", mass_scale);
        factor("inertia_scale", inertia_scale);
        factor("rotor_lag_scale", rotor_lag_scale);
        factor("thrust_scale", thrust_scale);
        problems.finite("mismatch.com_shift", &com_shift, "m");
        for (i, &scale) in rotor_scales.iter().enumerate() {
            let key = format!("mismatch.rotor_scales[{i}]");
            problems.not_negative(&key, scale, "1");
            check_factor(&key, scale, &mut problems);
        }
        problems.limit("mismatch.thrust_max", thrust_max, "N");
        let ServoConfig {
            time_constant,
            acceleration_limit,
        } = self.servo;
        problems.positive("servo.time_constant", time_constant, "s");
        if time_constant < 2.0 * step {
            let what = format!("is {time_constant}, must be at least two steps of {step} s");
            problems.add("servo.time_constant", &what);
        }
        problems.limit(
            "servo.acceleration_limit",
            acceleration_limit,
            "rad/s² or m/s²",
        );
        problems.positive("friction_speed", self.friction_speed, "rad/s or m/s");
        for (i, wall) in self.walls.iter().enumerate() {
            problems.name(&format!("wall[{i}].name"), &wall.name);
            wall.check(&format!("wall[{i}]"), step, &mut problems);
            if self.walls.iter().take(i).any(|w| w.name == wall.name) {
                let what = format!("`{}` is used twice", wall.name);
                problems.add(&format!("wall[{i}].name"), &what);
            }
        }
        let mut points = HashSet::new();
        for (i, point) in self.contact_points.iter().enumerate() {
            let key = format!("contact_point[{i}].offset");
            problems.finite(&key, &point.offset, "m");
            if !points.insert((&point.frame, point.offset.map(f64::to_bits))) {
                let what = format!(
                    "is the frame `{}` of a point at the same place: it would push twice",
                    point.frame
                );
                problems.add(&format!("contact_point[{i}].frame"), &what);
            }
        }
        for (i, disturbance) in self.disturbances.iter().enumerate() {
            let key = format!("disturbance[{i}]");
            problems.name(&format!("{key}.name"), &disturbance.name);
            disturbance.check(&key, &mut problems);
        }
        problems
    }
}
