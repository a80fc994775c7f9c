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

/// What multipliers prove, with twice as many digits: large ones cancel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Proof {
    /// By how much the weighted limits' sum is below zero, relative to its terms, the rest of `Aᵀ y + z` included.
    pub(super) margin: f64,
    /// Whether that rest, where no bound takes it, is rounding of its own terms.
    pub(super) is_closed: bool,
    /// The largest of it, relative to the largest term, in units in which the diagonal of H is one.
    rest: f64,
}

/// Whether no point is feasible: limits of one constraint alone say so, or the multipliers do.
pub(super) fn holds(qp: &Qp, solution: &Solution) -> bool {
    let is_proven = || {
        let proof = Proof::of(qp, solution);
        proof.margin > BEYOND && proof.rest <= CLOSED
    };
    impossible(qp).is_some() || is_proven()
}

impl Proof {
    pub(super) fn of(qp: &Qp, solution: &Solution) -> Self {
        let n = qp.n();
        let (mut sum, mut size, mut is_closed) = (Twofold::ZERO, 0.0, true);
        let (mut rest, mut largest) = (0.0_f64, 0.0_f64);
        let mut weigh = |multiplier: f64, (lower, upper): (f64, f64)| {
            let limit = if multiplier > 0.0 { upper } else { lower };
            sum += Twofold::new(multiplier) * limit;
            size += (multiplier * limit).abs();
        };
        for i in (0..qp.m()).filter(|i| solution.y[*i] != 0.0) {
            weigh(solution.y[i], limits(qp, i));
        }
        for (j, z) in solution.z[..qp.n()].iter().enumerate() {
            let h = qp.h()[j * n + j];
            let unit = if h > 0.0 { 1.0 / h.sqrt() } else { 1.0 };
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
            largest = largest.max(unit * terms);
            if needed != 0.0 && !is_none {
                weigh(needed, bound);
                continue;
            }
            rest = rest.max(unit * needed.abs());
            if (needed - z).abs() > CLOSED * terms || (*z != 0.0 && is_none) {
                is_closed = false;
            }
        }
        let margin = -sum.rounded() / size;
        Self {
            margin: if size > 0.0 { margin } else { 0.0 },
            is_closed,
            rest: if rest > 0.0 { rest / largest } else { 0.0 },
        }
    }
}
