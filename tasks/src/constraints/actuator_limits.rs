//! What the actuators can do.

use wbqp::{
    actuator::ActuatorKind,
    error::BindError,
    model::JointKind,
    plugin::{Constraint, ConstraintRows, Layout, Setup, Tick},
    schemars::JsonSchema,
    serde::{Deserialize, Serialize},
};

/// Keeps every effort within its actuator's limits, the paper's (10b).
///
/// `u_l ≤ u ≤ u_u`, N for rotors and prismatic joints, N·m for revolute ones.
///
/// The limits are the robot's (`lower` and `upper` of each actuator). The paper prints bounds on ω that act on its
/// input ω²; here the variable is the thrust itself, and so are its bounds. Where an actuator has a `slew`, the effort
/// also stays within `slew` × T of the last one that was sent, where T is the time since then, at most a period.
///
/// Bounds on single variables, no rows; they are hard whatever the entry says.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(crate = "wbqp::serde", deny_unknown_fields)]
#[schemars(crate = "wbqp::schemars")]
pub struct ActuatorLimits {
    /// Lower and upper limit, and `slew`.
    #[serde(skip)]
    limits: Vec<[f64; 3]>,
}

impl ActuatorLimits {
    /// For all actuators.
    pub fn new() -> Self {
        Self::default()
    }
}

#[wbqp::constraint("actuator_limits")]
impl Constraint for ActuatorLimits {
    fn bind(&mut self, setup: &mut Setup<'_>) -> Result<Layout, BindError> {
        let model = setup.model();
        let mut layout = Layout::empty();
        for (index, actuator) in setup.actuators().iter().enumerate() {
            let (lower, upper) = (actuator.lower, actuator.upper);
            if lower.is_nan() || upper.is_nan() || lower > upper {
                return Err(BindError::Other(format!(
                    "actuator `{}` has limits {lower} and {upper}",
                    actuator.name
                )));
            }
            let turns = match &actuator.kind {
                ActuatorKind::Joint(motor) => {
                    model.joints()[motor.joint.index()].kind == JointKind::Revolute
                }
                _ => false,
            };
            let unit = if turns { "N·m" } else { "N" };
            layout = layout.bound_effort(index, &actuator.name, unit);
        }
        let limits = setup.actuators().iter();
        let limits = limits.map(|a| [a.lower, a.upper, a.slew]);
        self.limits = limits.collect();
        Ok(layout)
    }

    fn update(&mut self, tick: &Tick<'_>, rows: &mut ConstraintRows<'_>) {
        let sent = tick.last.effort.iter();
        for ((index, [lower, upper, slew]), sent) in self.limits.iter().enumerate().zip(sent) {
            let change = slew * tick.slew_time;
            rows.bound(index, lower.max(sent - change), upper.min(sent + change));
        }
    }
}
