//! A velocity servo as MuJoCo can have it.
//!
//! The plant's servo is `q̈ = (v_ref − q̇) / τ` whatever effort that takes. An engine that integrates forces needs a
//! controller that finds this effort: here a PI controller of velocity, whose reference has the servo's lag,
//!
//! ```text
//! v̇_f = (v_ref − v_f) / τ
//! effort = kv (v_f − q̇) + ki ∫ (v_f − q̇) dt,   kv = 2 ω Λ,  ki = ω² Λ,  ω = 5 / τ
//! ```
//!
//! critically damped with `Λ = 1 / (M⁻¹)_jj`, the inertia that the joint sees in the initial posture. Two actuators
//! with one control, `v_ref`, are this sum. Their activations are `v_f` and `x_r = ∫ v_ref dt`, and because
//! `∫ v_f dt = x_r − τ v_f`:
//!
//! ```text
//! first    (kv − ki τ) v_f − kv q̇       dyntype filterexact, named as the joint
//! second   ki x_r − ki q                dyntype integrator, named <joint>_integral
//! ```

/// ω τ: how many times faster than its reference's lag the servo takes away a disturbance.
pub const HARDNESS: f64 = 5.0;

/// What is behind the name of the joint in the name of the second actuator.
pub const INTEGRAL: &str = "_integral";

/// The servo's gains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gains {
    /// N·m·s/rad or N·s/m.
    pub kv: f64,
    /// N·m/rad or N/m.
    pub ki: f64,
}

impl Gains {
    /// For a joint with an inertia Λ (kg·m² or kg) and a servo with a time constant τ (s).
    pub fn new(inertia: f64, time_constant: f64) -> Self {
        let rate = HARDNESS / time_constant;
        Self {
            kv: 2.0 * rate * inertia,
            ki: rate * rate * inertia,
        }
    }
}
