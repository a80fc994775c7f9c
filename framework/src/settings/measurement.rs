//! The table `[measurement]`: what a measurement may be.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Bounds on what is measured. A measurement outside of them is a fault, and the tick falls back.
///
/// Every key may be left out: its default is derived from the robot, with margins that no motion of it comes near
/// ([`Controller::measurement_limits`](crate::Controller::measurement_limits) says what became of it). `inf` means any.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct MeasurementLimits {
    /// Longest time from one measurement to the next, s: a later stamp is a fault until the clock goes on from there.
    /// Default: 10 s.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "s"))]
    pub max_gap: Option<f64>,
    /// Largest distance of a floating base from the world's origin, m. Default: 1e8.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "m"))]
    pub max_position: Option<f64>,
    /// Largest size of each joint's position, rad or m. Default: ten times that of its range, but at least ten times
    /// half a turn or 0.1 m; 1e6 without range.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "rad or m"))]
    pub max_joint_position: Option<f64>,
    /// Largest speed of a floating base, m/s. Default: ten times the speed of a limb's end, at least 100.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "m/s"))]
    pub max_linear_velocity: Option<f64>,
    /// Largest angular speed of a floating base, rad/s. Default: that of the fastest revolute joint.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "rad/s"))]
    pub max_angular_velocity: Option<f64>,
    /// Largest speed of each joint, rad/s or m/s. Default: ten times the joint's limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "rad/s or m/s"))]
    pub max_joint_velocity: Option<f64>,
    /// Largest acceleration of a floating base, from one measurement to the next, m/s². Default: to the largest speed
    /// within 1 ms.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "m/s²"))]
    pub max_linear_acceleration: Option<f64>,
    /// Largest angular acceleration of a floating base, rad/s². Default: to the largest speed within 1 ms.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "rad/s²"))]
    pub max_angular_acceleration: Option<f64>,
    /// Largest acceleration of each joint, rad/s² or m/s². Default: to its largest speed within 1 ms.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "rad/s² or m/s²"))]
    pub max_joint_acceleration: Option<f64>,
    /// Largest change of the base's position in a period in which it is not seen, m. Default: the largest speed times
    /// the period.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "m"))]
    pub max_position_jump: Option<f64>,
    /// Largest angle that the base turns in a period, rad. Default: the largest angular speed times the period.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "rad"))]
    pub max_rotation_jump: Option<f64>,
    /// Largest change of each joint's position in a period, rad or m. Default: its largest speed times the period.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "rad or m"))]
    pub max_joint_jump: Option<f64>,
    /// Largest measured force at a contact, N. Default: ten times what weight and actuators amount to, and the
    /// contact's own `force_max`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "N"))]
    pub max_force: Option<f64>,
    /// Largest measured moment at a contact, N·m. Default: the largest force times the robot's reach.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "N·m"))]
    pub max_moment: Option<f64>,
}

impl MeasurementLimits {
    /// Everything that is finite is taken.
    pub const ANY: Self = Self {
        max_gap: Some(f64::INFINITY),
        max_position: Some(f64::INFINITY),
        max_joint_position: Some(f64::INFINITY),
        max_linear_velocity: Some(f64::INFINITY),
        max_angular_velocity: Some(f64::INFINITY),
        max_joint_velocity: Some(f64::INFINITY),
        max_linear_acceleration: Some(f64::INFINITY),
        max_angular_acceleration: Some(f64::INFINITY),
        max_joint_acceleration: Some(f64::INFINITY),
        max_position_jump: Some(f64::INFINITY),
        max_rotation_jump: Some(f64::INFINITY),
        max_joint_jump: Some(f64::INFINITY),
        max_force: Some(f64::INFINITY),
        max_moment: Some(f64::INFINITY),
    };

    /// Keys with what is wrong with them, at a control rate in Hz if there is one.
    pub(crate) fn problems(
        &self,
        rate: Option<f64>,
    ) -> impl Iterator<Item = (&'static str, String)> {
        let gap = self.gap_problem(rate).map(|problem| ("max_gap", problem));
        [
            ("max_position", self.max_position, PLACE),
            ("max_joint_position", self.max_joint_position, PLACE),
            ("max_linear_velocity", self.max_linear_velocity, SPEED),
            ("max_angular_velocity", self.max_angular_velocity, SPEED),
            ("max_joint_velocity", self.max_joint_velocity, SPEED),
            (
                "max_linear_acceleration",
                self.max_linear_acceleration,
                ACCELERATION,
            ),
            (
                "max_angular_acceleration",
                self.max_angular_acceleration,
                ACCELERATION,
            ),
            (
                "max_joint_acceleration",
                self.max_joint_acceleration,
                ACCELERATION,
            ),
            ("max_position_jump", self.max_position_jump, JUMP),
            ("max_rotation_jump", self.max_rotation_jump, JUMP),
            ("max_joint_jump", self.max_joint_jump, JUMP),
            ("max_force", self.max_force, FORCE),
            ("max_moment", self.max_moment, MOMENT),
        ]
        .into_iter()
        .filter_map(|(key, value, least)| Some((key, least.problem(value?)?)))
        .chain(gap)
    }

    fn gap_problem(&self, rate: Option<f64>) -> Option<String> {
        let gap = self.max_gap?;
        if gap.is_nan() || gap <= 0.0 {
            return Some(not_positive(gap));
        }
        let least = FEWEST_PERIODS / rate?;
        (gap < least).then(|| {
            format!(
                "is {gap:e} s, must be at least two periods of `rate`, which are {least:e} s: no measurement would be \
                 in time"
            )
        })
    }
}

/// Below it nothing that a sensor says is within a bound.
struct Least {
    value: f64,
    unit: &'static str,
}

/// A measurement comes after one period, and later where clocks differ.
const FEWEST_PERIODS: f64 = 2.0;

// A thousandth of the noise of what measures best, or less.
const SPEED: Least = Least {
    value: 1e-6,
    unit: "m/s or rad/s",
};
const ACCELERATION: Least = Least {
    value: 1e-4,
    unit: "m/s² or rad/s²",
};
const PLACE: Least = Least {
    value: 1e-6,
    unit: "m or rad",
};
const JUMP: Least = Least {
    value: 1e-9,
    unit: "m or rad",
};
const FORCE: Least = Least {
    value: 1e-4,
    unit: "N",
};
const MOMENT: Least = Least {
    value: 1e-6,
    unit: "N·m",
};

impl Least {
    fn problem(&self, value: f64) -> Option<String> {
        let Self { value: least, unit } = self;
        if value.is_nan() || value <= 0.0 {
            return Some(not_positive(value));
        }
        (value < *least).then(|| {
            format!(
                "is {value:e}, must be at least {least:e} {unit}: what sensors say of a robot at rest differs by more"
            )
        })
    }
}

fn not_positive(value: f64) -> String {
    format!("must be positive, `inf` for any, is {value}")
}
