//! What a task says of its rows beside their coefficients.

use nalgebra::Vector3;

use crate::contact::ContactId;

/// What a row of a motion task is told: the error, its rate, the acceleration wanted, and the gains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionRow {
    /// `e`, actual minus desired, in the layout's error unit.
    pub error: f64,
    /// `ė`, the same per second.
    pub rate: f64,
    /// `a_d`, in the row's unit.
    pub acceleration: f64,
    /// Stiffness `K_P`, 1/s².
    pub kp: f64,
    /// Damping `K_D`, 1/s.
    pub kd: f64,
}

impl MotionRow {
    /// To a place that rests, critically damped: `ë + 2 √K_P ė + K_P e = 0`.
    pub fn to_rest(error: f64, rate: f64, kp: f64) -> Self {
        Self {
            error,
            rate,
            acceleration: 0.0,
            kp,
            kd: 2.0 * kp.sqrt(),
        }
    }
}

/// The two forces that only a force task knows, C axes, N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceReport {
    /// The contact that is controlled.
    pub contact: ContactId,
    /// Set point `f^d`.
    pub reference: Vector3<f64>,
    /// What the outer loop asks of the solver, `f*` of the paper's (11).
    pub virtual_input: Vector3<f64>,
    /// Whether the integrator stands at its clamp.
    pub clamped: bool,
}
