//! A point of the robot stays on one side of a plane.
//!
//! # Notation
//! W world, F the frame, P the point at `o` in F. All vectors in world axes.
#![allow(non_snake_case)]

use wbqp::prelude::*;

use super::barrier::{DEFAULT_RATE, least, validate_rate};
use crate::check;

/// Keeps a point of a frame at a distance from a plane: ground, ceiling, a wall that is not to be touched.
///
/// With `h = nᵀ (p_WP − p₀) − margin`, one row, m/s²:
///
/// `nᵀ J_P v̇ ≥ −(a₁ + a₂) ḣ − a₁ a₂ h − nᵀ J̇_P v`, that is `ḧ + (a₁ + a₂) ḣ + a₁ a₂ h ≥ 0`,
///
/// an exponential control barrier function (Nguyen and Sreenath, ACC 2016): the point comes no nearer than `margin` if
/// it starts further away and not too fast (`ḣ ≥ −a₁ h`). Larger rates let it come nearer before it is slowed down; the
/// braking that they need is about `a₁ a₂ h`.
#[wbqp::constraint("plane_distance")]
pub struct PlaneDistance {
    /// The frame, by name.
    pub frame: String,
    /// The point in the frame, m.
    #[wbqp(default, unit = "m")]
    pub offset: [f64; 3],
    /// A point `p₀` of the plane, m, world.
    #[wbqp(unit = "m")]
    pub point: [f64; 3],
    /// Direction `n` from the plane to the side where the point has to be, world axes; normalised when read.
    #[wbqp(unit = "1")]
    pub normal: [f64; 3],
    /// Smallest distance, m.
    #[wbqp(default, unit = "m")]
    pub margin: f64,
    /// Rate `a₁`, 1/s, at most one over the control period.
    #[wbqp(default = DEFAULT_RATE, unit = "1/s")]
    pub a1: f64,
    /// Rate `a₂`, 1/s, at most one over the control period.
    #[wbqp(default = DEFAULT_RATE, unit = "1/s")]
    pub a2: f64,
}

impl PlaneDistance {
    /// Keeps the origin of a frame on the side of a plane where the normal points.
    pub fn new(frame: impl Into<String>, point: [f64; 3], normal: [f64; 3]) -> Self {
        Self {
            frame: frame.into(),
            offset: [0.0; 3],
            point,
            normal,
            margin: 0.0,
            a1: DEFAULT_RATE,
            a2: DEFAULT_RATE,
        }
    }

    /// At another distance than 0, m.
    pub fn with_margin(mut self, margin: f64) -> Self {
        self.margin = margin;
        self
    }

    /// With other rates, 1/s.
    pub fn with_rates(mut self, a1: f64, a2: f64) -> Self {
        (self.a1, self.a2) = (a1, a2);
        self
    }
}

impl Constraint for PlaneDistance {
    type Running = FrameHandle;

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(ConstraintLayout, FrameHandle), BindError> {
        let frame = setup.frame(&self.frame)?;
        check::finite("offset", &self.offset)?;
        check::finite("point", &self.point)?;
        check::finite("normal", &self.normal)?;
        check::finite("margin", &[self.margin])?;
        validate_rate("a1", self.a1, setup.period())?;
        validate_rate("a2", self.a2, setup.period())?;
        if Vector3::from(self.normal).try_normalize(1e-9).is_none() {
            return Err(BindError::value("normal", "is zero"));
        }
        let layout = Layout::rows([("distance", "m/s²")]).vdot_dense();
        Ok((layout.limits(), frame))
    }

    fn update(&self, frame: &mut FrameHandle, tick: &Tick<'_>, rows: &mut ConstraintRows<'_>) {
        let (frame, n) = (tick.frame(*frame), Vector3::from(self.normal).normalize());
        let o = frame.R_WF * Vector3::from(self.offset);
        let w = frame.w_WF;
        let h = n.dot(&(frame.p_WF + o - Vector3::from(self.point))) - self.margin;
        let hdot = n.dot(&(frame.v_WF + w.cross(&o)));
        // nᵀ (J_v − S(o) J_w) = nᵀ J_v + (o × n)ᵀ J_w.
        let turning = o.cross(&n);
        let along = |six: [f64; 6]| {
            let [x, y, z, a, b, c] = six;
            n.dot(&Vector3::new(x, y, z)) + turning.dot(&Vector3::new(a, b, c))
        };
        let mut vdot = rows.vdot();
        for (j, c) in frame.J.column_iter().enumerate() {
            vdot[(0, j)] = along([c[0], c[1], c[2], c[3], c[4], c[5]]);
        }
        let j = &frame.Jdot_v;
        let bias = along([j[0], j[1], j[2], j[3], j[4], j[5]]) + n.dot(&w.cross(&w.cross(&o)));
        rows.limit(0, least([self.a1, self.a2], h, hdot) - bias, f64::INFINITY);
    }

    fn remembered(&self, _: &mut Self::Running, _: &mut Remembered<'_>) {}
}
