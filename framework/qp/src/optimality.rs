//! How far a point is from the optimality conditions.
//!
//! # Mathematics
//! At an optimum `H x + g + Aᵀ y + z = 0`, all rows and bounds hold, and a multiplier is zero unless its side is
//! at its limit. The three errors below are zero there, and only there.

use crate::{Qp, Solution};

/// Errors of a primal-dual point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Optimality {
    /// `‖H x + g + Aᵀ y + z‖∞ / (1 + ‖g‖∞)`.
    pub stationarity: f64,
    /// Largest violation of a row or bound, in its unit.
    pub primal: f64,
    /// Largest |multiplier × distance to its limit| / (1 + |objective|); infinite for a multiplier on a side
    /// without limit.
    pub complementarity: f64,
}

impl Optimality {
    /// The errors of a solution; infinite if it is one of a smaller problem.
    pub fn of(qp: &Qp, s: &Solution) -> Self {
        let (n, m) = (qp.n(), qp.m());
        if qp.fits(s.capacity()).is_err() {
            return Self {
                stationarity: f64::INFINITY,
                primal: f64::INFINITY,
                complementarity: f64::INFINITY,
            };
        }
        let mut out = Self::default();
        let largest_g = qp.g().iter().fold(0.0_f64, |a, g| a.max(g.abs()));
        for j in 0..n {
            let mut r = qp.g()[j] + s.z[j];
            for (h, x) in qp.h()[j * n..(j + 1) * n].iter().zip(&s.x) {
                r += h * x;
            }
            for i in 0..m {
                r += qp.row(i)[j] * s.y[i];
            }
            out.stationarity = worse(out.stationarity, r.abs() / (1.0 + largest_g));
        }
        let cost = 1.0 + qp.objective(&s.x).abs();
        let mut side = |value: f64, lower: f64, upper: f64, multiplier: f64| {
            out.primal = worse(worse(out.primal, lower - value), value - upper);
            let distance = if multiplier > 0.0 {
                upper - value
            } else {
                value - lower
            };
            if multiplier != 0.0 {
                let price = (multiplier * distance).abs() / cost;
                out.complementarity = worse(out.complementarity, price);
            }
        };
        for i in 0..m {
            let ax: f64 = qp.row(i).iter().zip(&s.x).map(|(a, x)| a * x).sum();
            side(ax, qp.row_lower()[i], qp.row_upper()[i], s.y[i]);
        }
        for j in 0..n {
            side(s.x[j], qp.lower()[j], qp.upper()[j], s.z[j]);
        }
        out
    }

    /// The largest of the three.
    pub fn worst(&self) -> f64 {
        worse(worse(self.stationarity, self.primal), self.complementarity)
    }
}

/// The larger of two errors, where a NaN is the largest (`f64::max` would drop it).
fn worse(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() {
        f64::INFINITY
    } else {
        a.max(b)
    }
}
