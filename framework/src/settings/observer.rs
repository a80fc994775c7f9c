//! What the motion says that the sensors and the model do not: the table `controller.observer`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// An observer of velocities and of an unknown wrench on a floating base: the dynamics predict how the velocities
/// change, the measured ones correct the prediction, and what has to be corrected again and again is a wrench that the
/// model does not have. Tasks and constraints see the observed velocities, and the dynamics of the problem have the
/// wrench: errors of masses and thrusts, wind, a cable.
///
/// For a robot that flies, or stands on sensors: what carries it and is neither a contact nor an effort is taken for
/// an unknown wrench. While the forces at contacts are not known, because a sensor fails, or, with
/// `forces = "planned"`, because a tick has no solution, the wrench is forgotten within some seconds, and velocities
/// are the measured ones.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Observer {
    /// Below this frequency velocities are the measured ones, above it those that the model predicts, Hz. What the
    /// wrench does not explain, errors of joints' servos for instance, makes an error of the velocities: that of the
    /// acceleration, divided by 2π and this.
    #[schemars(extend("x-unit" = "Hz"))]
    pub velocity: f64,
    /// Bandwidth of the unknown wrench, Hz, at most a quarter of `velocity`; 0 for velocities alone. The base then
    /// answers to a steady push as a spring does for that long only.
    #[serde(default)]
    #[schemars(extend("x-unit" = "Hz"))]
    pub wrench: f64,
    /// Largest unknown force, N.
    #[serde(default)]
    #[schemars(extend("x-unit" = "N"))]
    pub max_force: f64,
    /// Largest unknown moment about the base's origin, N·m.
    #[serde(default)]
    #[schemars(extend("x-unit" = "N·m"))]
    pub max_moment: f64,
    /// What the environment is believed to exert at contacts.
    #[serde(default)]
    pub forces: ContactForces,
}

/// What the environment is believed to exert at contacts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ContactForces {
    /// What force-torque sensors measure, also while a contact is off; once where several contacts have one frame.
    #[default]
    Measured,
    /// What the last solution has at contacts that are on: for robots without such sensors.
    Planned,
}

impl Observer {
    /// Keys with what is wrong with them, at a control rate in Hz.
    pub(super) fn problems(&self, rate: f64) -> Vec<(&'static str, String)> {
        let rules = [
            (
                "observer.velocity",
                self.velocity,
                self.velocity > 0.0 && self.velocity < 0.5 * rate,
                "positive and below half the rate",
            ),
            (
                "observer.wrench",
                self.wrench,
                self.wrench >= 0.0 && 4.0 * self.wrench <= self.velocity,
                "0 or up to a quarter of `velocity`",
            ),
            (
                "observer.max_force",
                self.max_force,
                self.max_force >= 0.0,
                "not negative",
            ),
            (
                "observer.max_moment",
                self.max_moment,
                self.max_moment >= 0.0,
                "not negative",
            ),
        ];
        let wrong = |(_, value, allowed, _): &(_, f64, bool, _)| !value.is_finite() || !allowed;
        let mut found: Vec<_> = rules
            .into_iter()
            .filter(wrong)
            .map(|(key, value, _, rule)| (key, format!("must be finite and {rule}, is {value}")))
            .collect();
        if self.wrench > 0.0 && self.max_force == 0.0 && self.max_moment == 0.0 {
            found.push((
                "observer.wrench",
                "nothing would be observed: give `max_force`, N, and `max_moment`, N·m".to_owned(),
            ));
        }
        found
    }
}
