//! A limit of the tilt, kept by a barrier on accelerations.
//!
//! # Notation
//! W world (z up), R base, `z_R` its z axis in world coordinates, ω its angular velocity, world axes.
//!
//! # Mathematics
//! `h = z_R·e_z − cos θ_max` is positive inside the limit. The barrier `ḧ + (α₁ + α₂) ḣ + α₁ α₂ h ≥ 0` keeps it so:
//! close to the limit it may only be approached ever more slowly (a control barrier function of relative degree two,
//! Nguyen and Sreenath 2016). With `ḣ = (z_R × e_z)·ω` and `ḧ = (z_R × e_z)·ω̇ + (ω × (ω × z_R))·e_z` it is one row on
//! the base's angular acceleration.

use wbqp::prelude::*;

/// How fast the limit may be approached, 1/s: both rates of the barrier.
const RATE: f64 = 8.0;

/// Keeps the base's z axis within an angle of the vertical.
#[wbqp::constraint("pointing.max_tilt")]
pub struct MaxTilt {
    /// The limit, degrees, above 0 and below 90.
    pub degrees: f64,
}

impl Constraint for MaxTilt {
    type Running = FrameHandle;

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(ConstraintLayout, FrameHandle), BindError> {
        if !(self.degrees > 0.0 && self.degrees < 90.0) {
            let problem = format!("is {}, must be above 0 and below 90", self.degrees);
            return Err(BindError::value("degrees", problem));
        }
        let layout = Layout::rows([("tilt", "1/s²")]).vdot_dense();
        Ok((layout.limits(), setup.base_frame()))
    }

    fn update(&self, base: &mut FrameHandle, tick: &Tick<'_>, rows: &mut ConstraintRows<'_>) {
        let base = tick.frame(*base);
        let up = Vector3::z();
        let z = base.R_WF * up;
        let axis = z.cross(&up);
        for (out, column) in rows.vdot().row_mut(0).iter_mut().zip(base.J.column_iter()) {
            *out = axis.dot(&column.fixed_rows::<3>(3));
        }
        let h = z.dot(&up) - self.degrees.to_radians().cos();
        let h_dot = axis.dot(&base.w_WF);
        let turn = base.Jdot_v.fixed_rows::<3>(3).into_owned();
        let beta = axis.dot(&turn) + base.w_WF.cross(&base.w_WF.cross(&z)).dot(&up);
        rows.limit(
            0,
            -beta - 2.0 * RATE * h_dot - RATE * RATE * h,
            f64::INFINITY,
        );
    }

    fn remembered(&self, _: &mut Self::Running, _: &mut Remembered<'_>) {}
}
