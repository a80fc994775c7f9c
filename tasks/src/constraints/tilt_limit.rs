//! The base does not tilt too far.
//!
//! # Notation
//! W world, R base; `z` is R's z axis in world axes.
#![allow(non_snake_case)]

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use wbqp::{
    error::BindError,
    nalgebra::Vector3,
    plugin::{Constraint, ConstraintRows, Layout, Setup, Tick},
    schemars::JsonSchema,
    serde::{Deserialize, Serialize},
};

use super::{
    barrier::{default_rate, least, validate_rate},
    friction_pyramid::validate_sides,
};
use crate::tasks::require_floating;

/// Keeps the base's z axis within an angle of the vertical.
///
/// With the horizontal directions `d_k` at `2πk/N` and `h_k = sin(max_tilt) cos(π/N) − d_kᵀ z`, one row per direction,
/// 1/s²:
///
/// `−(z × d_k)ᵀ ẇ_WR ≥ −(a₁ + a₂) ḣ_k − a₁ a₂ h_k + d_kᵀ (w × (w × z))`, that is `ḧ_k + (a₁ + a₂) ḣ_k + a₁ a₂ h_k ≥ 0`,
///
/// an exponential control barrier function (Nguyen and Sreenath, ACC 2016). The N sides lie inside the cone: the tilt
/// never exceeds `max_tilt`, and is stopped at `asin(sin(max_tilt) cos(π/N))` between the corners (8 sides: 92 %).
/// The one row with `h = e₃ᵀ z − cos(max_tilt)` would not do: upright, its gradient is zero, and any turning makes it
/// infeasible.
///
/// The base must start within the limit. Floating base only.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(crate = "wbqp::serde", deny_unknown_fields)]
#[schemars(crate = "wbqp::schemars")]
pub struct TiltLimit {
    /// Largest angle between the base's z and the vertical, rad, below π/2.
    #[schemars(extend("x-unit" = "rad"))]
    pub max_tilt: f64,
    /// Rate `a₁`, 1/s, at most one over the control period.
    #[serde(default = "default_rate")]
    #[schemars(extend("x-unit" = "1/s"))]
    pub a1: f64,
    /// Rate `a₂`, 1/s, at most one over the control period.
    #[serde(default = "default_rate")]
    #[schemars(extend("x-unit" = "1/s"))]
    pub a2: f64,
    /// Number of directions N, 3 to 64.
    #[serde(default = "default_sides")]
    #[schemars(range(min = 3, max = 64))]
    pub sides: usize,
    /// `d_k`.
    #[serde(skip)]
    directions: Vec<Vector3<f64>>,
}

fn default_sides() -> usize {
    8
}

impl TiltLimit {
    /// At this angle (rad), with the default rates and sides.
    pub fn new(max_tilt: f64) -> Self {
        Self {
            max_tilt,
            a1: default_rate(),
            a2: default_rate(),
            sides: default_sides(),
            directions: Vec::new(),
        }
    }

    /// With other rates, 1/s.
    pub fn with_rates(mut self, a1: f64, a2: f64) -> Self {
        (self.a1, self.a2) = (a1, a2);
        self
    }
}

#[wbqp::constraint("tilt_limit")]
impl Constraint for TiltLimit {
    fn bind(&mut self, setup: &mut Setup<'_>) -> Result<Layout, BindError> {
        require_floating(setup)?;
        if !(self.max_tilt > 0.0 && self.max_tilt < FRAC_PI_2) {
            let problem = format!("is {} rad, must be above 0 and below π/2", self.max_tilt);
            return Err(BindError::value("max_tilt", problem));
        }
        validate_sides(self.sides)?;
        validate_rate("a1", self.a1, setup.period())?;
        validate_rate("a2", self.a2, setup.period())?;
        let directions = (0..self.sides).map(|k| {
            let (sin, cos) = (TAU * k as f64 / self.sides as f64).sin_cos();
            Vector3::new(cos, sin, 0.0)
        });
        self.directions = directions.collect();
        let rows = (0..self.sides).map(|k| (format!("side {k}"), "1/s²"));
        Ok(Layout::rows(rows).vdot_dense())
    }

    fn update(&mut self, tick: &Tick<'_>, rows: &mut ConstraintRows<'_>) {
        let z = tick.state.R_WR * Vector3::z();
        let w = Vector3::from_fn(|i, _| tick.state.v[3 + i]);
        let (zdot, centripetal) = (w.cross(&z), w.cross(&w.cross(&z)));
        let room = self.max_tilt.sin() * (PI / self.sides as f64).cos();
        let mut vdot = rows.vdot();
        for (k, d) in self.directions.iter().enumerate() {
            let gradient = -z.cross(d);
            for i in 0..3 {
                vdot[(k, 3 + i)] = gradient[i];
            }
        }
        for (k, d) in self.directions.iter().enumerate() {
            let (h, hdot) = (room - d.dot(&z), -d.dot(&zdot));
            let bias = -d.dot(&centripetal);
            rows.limit(k, least([self.a1, self.a2], h, hdot) - bias, f64::INFINITY);
        }
    }
}
