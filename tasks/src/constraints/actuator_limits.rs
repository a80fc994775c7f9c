//! What the actuators can do.

use wbqp::{actuator::ActuatorKind, model::JointKind, prelude::*};

/// Keeps every effort within its actuator's limits, the paper's (10b).
///
/// `u_l ≤ u ≤ u_u`, N for rotors and prismatic joints, N·m for revolute ones.
///
/// The limits are the robot's (`lower` and `upper` of each actuator). The paper prints bounds on ω that act on its
/// input ω²; here the variable is the thrust itself, and so are its bounds. Where an actuator has a `slew`, the effort
/// also stays within `slew` × T of the last one that was sent, where T is the time since then, at most a period.
///
/// Bounds on single efforts, rows only where the formulation has no variable for one; always hard, and another
/// `hardness` is refused.
#[wbqp::constraint("actuator_limits")]
#[derive(Default)]
pub struct ActuatorLimits {}

impl ActuatorLimits {
    /// For all actuators.
    pub fn new() -> Self {
        Self::default()
    }
}

impl Constraint for ActuatorLimits {
    /// Lower and upper limit, and `slew`, of each actuator.
    type Running = Vec<[f64; 3]>;

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(ConstraintLayout, Self::Running), BindError> {
        let model = setup.model();
        let mut layout = ConstraintLayout::bounds();
        for (id, actuator) in setup.actuators() {
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
                ActuatorKind::Rotor(_) => false,
            };
            let unit = if turns { "N·m" } else { "N" };
            layout = layout.bound_effort(id, &actuator.name, unit);
        }
        let limits = setup.actuators();
        let limits = limits.map(|(_, a)| [a.lower, a.upper, a.slew]);
        Ok((layout, limits.collect()))
    }

    fn update(&self, limits: &mut Self::Running, tick: &Tick<'_>, rows: &mut ConstraintRows<'_>) {
        let sent = tick.last_effort.iter();
        for ((index, [lower, upper, slew]), sent) in limits.iter().enumerate().zip(sent) {
            let change = slew * tick.slew_time;
            rows.bound(index, lower.max(sent - change), upper.min(sent + change));
        }
    }

    fn remembered(&self, _: &mut Self::Running, _: &mut Remembered<'_>) {}
}
