//! Whether multipliers prove that no point is feasible.
//!
//! # Mathematics
//! Where all limits hold, `yᵀ A x + zᵀ x` is at most the sum of the limits on the multipliers' sides, weighted with
//! them; if `Aᵀ y + z = 0`, it is zero, and a negative sum a contradiction (J. Farkas, *Theorie der einfachen
//! Ungleichungen*, J. für die reine und angewandte Mathematik 124 (1902)). What rounding leaves of `Aᵀ y + z` is a
//! multiplier of a bound, where there is one on the side that it needs, and counts with it.

use super::{
    constraint::{ENDLESS, impossible, limits},
    twofold::Twofold,
};
use crate::{Qp, Solution};

/// A sum below zero by less than this part of its terms may be rounding.
const BEYOND: f64 = 1e-13;
/// What the rest of a sum that has to vanish may be of its terms, where no bound takes it.
const CLOSED: f64 = 1e-13;

/// Whether no point is feasible: limits of one constraint alone say so, or the multipliers do.
pub(super) fn holds(qp: &Qp, solution: &Solution) -> bool {
    impossible(qp).is_some() || margin(qp, solution).0 > BEYOND
}

/// By how much the weighted limits' sum is below zero, relative to its terms, the rest of `Aᵀ y + z` included;
/// whether that rest is rounding where no bound takes it. With twice as many digits: large multipliers cancel.
pub(super) fn margin(qp: &Qp, solution: &Solution) -> (f64, bool) {
    let (mut sum, mut size, mut is_closed) = (Twofold::ZERO, 0.0, true);
    let mut weigh = |multiplier: f64, (lower, upper): (f64, f64)| {
        let limit = if multiplier > 0.0 { upper } else { lower };
        sum += Twofold::new(multiplier) * limit;
        size += (multiplier * limit).abs();
    };
    for i in (0..qp.m()).filter(|i| solution.y[*i] != 0.0) {
        weigh(solution.y[i], limits(qp, i));
    }
    for (j, z) in solution.z[..qp.n()].iter().enumerate() {
        let (mut combined, mut terms) = (Twofold::ZERO, z.abs());
        let weighted = solution.y[..qp.m()].iter().enumerate();
        for (i, y) in weighted.filter(|(_, y)| **y != 0.0) {
            let a = qp.row(i)[j];
            combined += Twofold::new(a) * *y;
            terms += (a * y).abs();
        }
        // What balances the rows exactly, if a bound takes it.
        let needed = -combined.rounded();
        let bound = limits(qp, qp.m() + j);
        let limit = if needed > 0.0 { bound.1 } else { bound.0 };
        let is_none = if needed > 0.0 {
            limit >= ENDLESS
        } else {
            limit <= -ENDLESS
        };
        if needed != 0.0 && !is_none {
            weigh(needed, bound);
        } else if (needed - z).abs() > CLOSED * terms || (*z != 0.0 && is_none) {
            is_closed = false;
        }
    }
    let margin = -sum.rounded() / size;
    (if size > 0.0 { margin } else { 0.0 }, is_closed)
}
