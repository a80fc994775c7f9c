//! The `[sensors]` table.

use std::collections::HashSet;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::OutageConfig;
use crate::{check::Problems, plant::PlantError};

/// Errors of all sensors. The default is perfect knowledge of the state and no force-torque sensor.
///
/// `sd` is the standard deviation of white Gaussian noise, drawn per axis and per sample.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SensorsConfig {
    /// Motion capture of the base.
    pub base: BaseSensorConfig,
    /// Joint encoders.
    pub joints: JointSensorConfig,
    /// Force-torque sensors.
    #[serde(rename = "force_torque", skip_serializing_if = "Vec::is_empty")]
    pub force_torque: Vec<ForceTorqueConfig>,
    /// Times in which a sensor is broken.
    #[serde(rename = "outage", skip_serializing_if = "Vec::is_empty")]
    pub outages: Vec<OutageConfig>,
}

/// Noise on pose and twist of the base. The twist is truth plus noise, or estimated from the poses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct BaseSensorConfig {
    /// Position, m.
    pub position_sd: f64,
    /// Rotation vector, rad, world axes.
    pub rotation_sd: f64,
    /// Linear velocity, m/s.
    pub linear_sd: f64,
    /// Angular velocity, rad/s.
    pub angular_sd: f64,
    /// Cut-off, Hz, of a first-order low-pass on differences of the measured poses, which are the twist then; without
    /// it the twist is truth plus noise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity_cutoff: Option<f64>,
}

/// Noise on joint positions and velocities. The velocity is truth plus noise, or estimated from the positions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct JointSensorConfig {
    /// Position, rad or m.
    pub position_sd: f64,
    /// Velocity, rad/s or m/s.
    pub velocity_sd: f64,
    /// Cut-off, Hz, of a first-order low-pass on differences of the measured positions, which are the velocities then;
    /// without it they are truth plus noise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity_cutoff: Option<f64>,
}

/// A force-torque sensor: `low-pass(truth + bias + noise)`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ForceTorqueConfig {
    /// Named frame of the robot; readings are in its axes, about its origin. A frame has one sensor.
    pub frame: String,
    /// Constant error of the force, N.
    #[serde(default)]
    #[serde(deserialize_with = "crate::exact::numbers")]
    pub force_bias: [f64; 3],
    /// Constant error of the moment, N·m.
    #[serde(default)]
    #[serde(deserialize_with = "crate::exact::numbers")]
    pub moment_bias: [f64; 3],
    /// White noise on the force before the filter, N.
    #[serde(default)]
    pub force_sd: f64,
    /// White noise on the moment before the filter, N·m.
    #[serde(default)]
    pub moment_sd: f64,
    /// Cut-off of the first-order low-pass, Hz; `inf` for no filter.
    #[serde(default = "cutoff")]
    pub cutoff: f64,
}

fn cutoff() -> f64 {
    15.0
}

impl ForceTorqueConfig {
    /// An ideal sensor with the default filter.
    pub fn new(frame: &str) -> Self {
        Self {
            frame: frame.to_owned(),
            force_bias: [0.0; 3],
            moment_bias: [0.0; 3],
            force_sd: 0.0,
            moment_sd: 0.0,
            cutoff: cutoff(),
        }
    }
}

impl SensorsConfig {
    /// Checks every number. Names of frames are checked when the sensors are made.
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
        problems.not_negative("base.position_sd", self.base.position_sd, "m");
        problems.not_negative("base.rotation_sd", self.base.rotation_sd, "rad");
        problems.not_negative("base.linear_sd", self.base.linear_sd, "m/s");
        problems.not_negative("base.angular_sd", self.base.angular_sd, "rad/s");
        problems.not_negative("joints.position_sd", self.joints.position_sd, "rad or m");
        problems.not_negative(
            "joints.velocity_sd",
            self.joints.velocity_sd,
            "rad/s or m/s",
        );
        let cutoffs = [
            ("base.velocity_cutoff", self.base.velocity_cutoff),
            ("joints.velocity_cutoff", self.joints.velocity_cutoff),
        ];
        for (key, cutoff) in cutoffs {
            if let Some(cutoff) = cutoff {
                problems.limit(key, cutoff, "Hz");
            }
        }
        let mut frames = HashSet::new();
        for (i, sensor) in self.force_torque.iter().enumerate() {
            let key = |name| format!("force_torque[{i}].{name}");
            if !frames.insert(&sensor.frame) {
                let what = format!(
                    "`{}` has a sensor already: what is measured at a frame is one wrench",
                    sensor.frame
                );
                problems.add(&key("frame"), &what);
            }
            problems.finite(&key("force_bias"), &sensor.force_bias, "N");
            problems.finite(&key("moment_bias"), &sensor.moment_bias, "N·m");
            problems.not_negative(&key("force_sd"), sensor.force_sd, "N");
            problems.not_negative(&key("moment_sd"), sensor.moment_sd, "N·m");
            problems.limit(&key("cutoff"), sensor.cutoff, "Hz");
        }
        OutageConfig::validate(&self.outages, &mut problems);
        problems
    }
}
