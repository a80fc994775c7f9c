//! The base does not tilt too far.
//!
//! # Notation
//! W world, R base; `z` is R's z axis in world axes.
#![allow(non_snake_case)]

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use wbqp::{dynamics::elementary, prelude::*};

use super::{
    barrier::{DEFAULT_RATE, least, validate_rate},
    friction_pyramid::validate_sides,
};

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
#[wbqp::constraint("tilt_limit")]
pub struct TiltLimit {
    /// Largest angle between the base's z and the vertical, rad, below π/2.
    #[wbqp(unit = "rad")]
    pub max_tilt: f64,
    /// Rate `a₁`, 1/s, at most one over the control period.
    #[wbqp(default = DEFAULT_RATE, unit = "1/s")]
    pub a1: f64,
    /// Rate `a₂`, 1/s, at most one over the control period.
    #[wbqp(default = DEFAULT_RATE, unit = "1/s")]
    pub a2: f64,
    /// Number of directions N, 3 to 64.
    #[wbqp(default = 8_usize)]
    #[schemars(range(min = 3, max = 64))]
    pub sides: usize,
}

/// Where the base's turning is, and the directions.
#[derive(Debug)]
pub struct Cone {
    angular: [VelocityId; 3],
    /// `d_k`.
    directions: Vec<Vector3<f64>>,
}

impl TiltLimit {
    /// At this angle (rad), with the default rates and sides.
    pub fn new(max_tilt: f64) -> Self {
        Self {
            max_tilt,
            a1: DEFAULT_RATE,
            a2: DEFAULT_RATE,
            sides: Self::default_sides(),
        }
    }

    /// With other rates, 1/s.
    pub fn with_rates(mut self, a1: f64, a2: f64) -> Self {
        (self.a1, self.a2) = (a1, a2);
        self
    }
}

impl Constraint for TiltLimit {
    type Running = Cone;

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(ConstraintLayout, Cone), BindError> {
        let [_, _, _, angular @ ..] = setup.base_velocities()?;
        if !(self.max_tilt > 0.0 && self.max_tilt < FRAC_PI_2) {
            let problem = format!("is {} rad, must be above 0 and below π/2", self.max_tilt);
            return Err(BindError::value("max_tilt", problem));
        }
        validate_sides(self.sides)?;
        validate_rate("a1", self.a1, setup.period())?;
        validate_rate("a2", self.a2, setup.period())?;
        let directions = (0..self.sides).map(|k| {
            let (sin, cos) = elementary::sin_cos(TAU * k as f64 / self.sides as f64);
            Vector3::new(cos, sin, 0.0)
        });
        let cone = Cone {
            angular,
            directions: directions.collect(),
        };
        let rows = (0..self.sides).map(|k| (format!("side {k}"), "1/s²"));
        Ok((Layout::rows(rows).vdot_dense().limits(), cone))
    }

    fn update(&self, cone: &mut Cone, tick: &Tick<'_>, rows: &mut ConstraintRows<'_>) {
        let z = tick.state.R_WR * Vector3::z();
        let w = Vector3::from(cone.angular.map(|column| tick.state.v[column]));
        let (zdot, centripetal) = (w.cross(&z), w.cross(&w.cross(&z)));
        let room =
            elementary::sin_cos(self.max_tilt).0 * elementary::sin_cos(PI / self.sides as f64).1;
        let mut vdot = rows.vdot();
        for (k, d) in cone.directions.iter().enumerate() {
            let gradient = -z.cross(d);
            for (column, along) in cone.angular.iter().zip(&gradient) {
                vdot[(k, column.index())] = *along;
            }
        }
        for (k, d) in cone.directions.iter().enumerate() {
            let (h, hdot) = (room - d.dot(&z), -d.dot(&zdot));
            let bias = -d.dot(&centripetal);
            rows.limit(k, least([self.a1, self.a2], h, hdot) - bias, f64::INFINITY);
        }
    }

    fn remembered(&self, _: &mut Self::Running, _: &mut Remembered<'_>) {}
}
