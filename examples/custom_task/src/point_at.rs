//! A tool that points at a place.
//!
//! # Notation
//! W world, E the tool's frame with axes `x_E, y_E, z_E` in world coordinates, `p` its origin, `v`, `ω` its velocities.
//!
//! # Mathematics
//! With `u = target − p`, `r = ‖u‖` and `d = u/r` the direction to the target in the tool's axes is
//! `e = (x_E·d, y_E·d)`: zero where `z_E` points at the target. Its derivatives are
//! ```text
//! ḋ = −(v − d (d·v))/r,                     ė = a·ḋ + (a × d)·ω                        for a = x_E, y_E
//! ë = −a·(1 − d dᵀ)/r · v̇_E + (a × d)·ω̇_E + β
//! ```
//! where β collects what the velocities alone make. The task asks for `ë = −kd ė − kp e`.

use wbqp::prelude::*;

/// Keeps the z axis of a frame pointing at a place in the world: `ë = −kd ė − kp e` for the direction e to it, seen in
/// the frame's x and y.
#[wbqp::task("pointing.point_at")]
pub struct PointAt {
    /// The frame.
    pub frame: String,
    /// The place, m, world.
    pub target: [f64; 3],
    /// Stiffness, 1/s².
    pub kp: f64,
    /// Damping, 1/s.
    pub kd: f64,
}

impl Task for PointAt {
    type Running = FrameHandle;

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(Layout, FrameHandle), BindError> {
        for (key, gain) in [("kp", self.kp), ("kd", self.kd)] {
            if !(gain.is_finite() && gain >= 0.0) {
                return Err(BindError::value(
                    key,
                    format!("is {gain}, must be finite and not negative"),
                ));
            }
        }
        let rows = Layout::rows([("x", "1/s²"), ("y", "1/s²")]).error_unit("1");
        Ok((rows.vdot_dense(), setup.frame(&self.frame)?))
    }

    fn update(&self, tool: &mut FrameHandle, tick: &Tick<'_>, rows: &mut Rows<'_>) {
        let tool = tick.frame(*tool);
        let (v, w) = (tool.v_WF, tool.w_WF);
        let u = Vector3::from(self.target) - tool.p_WF;
        let r = u.norm().max(1e-3); // no direction at the target itself
        let d = u / r;
        let d_dot = -(v - d * d.dot(&v)) / r;
        // d̈ and ω̇ as far as the velocities make them.
        let drift = tool.Jdot_v.fixed_rows::<3>(0).into_owned();
        let turn = tool.Jdot_v.fixed_rows::<3>(3).into_owned();
        let d_ddot =
            (d_dot * (2.0 * d.dot(&v)) + d * d_dot.dot(&v) - drift + d * d.dot(&drift)) / r;
        for k in 0..2 {
            let a = tool.R_WF.matrix().column(k).into_owned();
            let (linear, angular) = (-(a - d * d.dot(&a)) / r, a.cross(&d));
            let row = tool.J.column_iter().map(|column| {
                linear.dot(&column.fixed_rows::<3>(0)) + angular.dot(&column.fixed_rows::<3>(3))
            });
            let a_dot = w.cross(&a);
            let beta = (turn.cross(&a) + w.cross(&a_dot)).dot(&d)
                + 2.0 * a_dot.dot(&d_dot)
                + a.dot(&d_ddot);
            rows.jacobian(k, row, beta);
            let motion = MotionRow {
                error: a.dot(&d),
                rate: a.dot(&d_dot) + a_dot.dot(&d),
                acceleration: 0.0,
                kp: self.kp,
                kd: self.kd,
            };
            rows.motion(k, motion);
        }
    }

    fn remembered(&self, _: &mut Self::Running, _: &mut Remembered<'_>) {}
}
