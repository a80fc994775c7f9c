//! What makes a point and its multipliers exact, and says whether they are.

use super::{
    super::{
        constraint::{add_normal, largest_normal, limits},
        kernels::{axpy, largest_product},
    },
    CONVERGED, Dual, EXACT,
};
use crate::Qp;

/// Refinements on one set of held constraints.
const REFINEMENTS: u32 = 50;
/// What one of them has to make the residual smaller by: else what is left is rounding.
const GAIN: f64 = 0.3;
/// A residual below this is that of a point whose correction is a small one.
const NEAR: f64 = 1e-10;
/// How many times larger than the cost's terms those of multipliers, which cancel one another, may count.
const OPPOSED: f64 = 1e2;
/// Terms of `H x` that are so many times larger than their sum and than g are those of a variable that is the quotient
/// of g and rounding.
const CANCELLED: f64 = 1e6;

impl Dual {
    /// Corrects `x` and the multipliers by the residuals of the optimality conditions on the held constraints, until
    /// these are exact or only rounding is left.
    pub(super) fn refine(&mut self, qp: &Qp, exact: f64) {
        let k = self.set.len();
        let mut before = f64::INFINITY;
        let mut stationarity = self.residual_of_gradient(qp);
        for _ in 0..REFINEMENTS {
            let primal = self.residual_of_held(qp);
            let residual = primal.max(stationarity);
            if residual <= exact || residual > GAIN * before {
                break;
            }
            before = residual;
            // A small correction of what is held leaves a gradient exact that is so.
            let stays_exact = stationarity <= exact && residual <= NEAR;
            let (d, p) = (&mut self.gradient[..self.stride], &mut self.p[..k]);
            if stays_exact {
                d.fill(0.0);
            }
            self.set.correct(&self.hessian, d, p);
            axpy(self.point.x_mut(), 1.0, d);
            self.passed = f64::INFINITY;
            axpy(&mut self.set.multipliers, 1.0, p);
            self.evaluate(qp);
            if !stays_exact {
                stationarity = self.residual_of_gradient(qp);
            }
        }
        self.residual = self.residual.max(self.primal);
    }

    /// Corrects the point and the multipliers by what the constraints held are away from their limits, which is in
    /// `self.p`: multipliers of limits that contradict one another are large, and their sums cancel.
    pub(super) fn come_back(&mut self, qp: &Qp) {
        let k = self.set.len();
        let (d, p) = (&mut self.gradient[..self.stride], &mut self.p[..k]);
        d.fill(0.0);
        self.set.correct(&self.hessian, d, p);
        axpy(self.point.x_mut(), 1.0, d);
        axpy(&mut self.set.multipliers, 1.0, p);
        self.evaluate(qp);
    }

    /// `H x + g + N λ` into `self.gradient`; returns its size relative to what it is the difference of.
    fn residual_of_gradient(&mut self, qp: &Qp) -> f64 {
        let point = &self.point;
        let gradient = &mut self.gradient[..self.stride];
        self.hessian.product(qp, point.x(), gradient);
        gradient[qp.n()..].fill(0.0);
        let unit = point.unit();
        let size = largest_product(gradient, unit).max(self.steepest);
        let size = size.max(self.set.pull_of_soft());
        axpy(gradient, 1.0, qp.g());
        for (held, &m) in self.set.active().iter().zip(&self.set.multipliers) {
            add_normal(qp, held.index, m, gradient);
        }
        let stationarity = largest_product(gradient, unit);
        // The entries of H x may be small differences of large terms, none of which exceeds the largest variable.
        self.size = size.max(point.largest()).max(f64::MIN_POSITIVE);
        self.residual = stationarity / self.size;
        self.pull = size;
        stationarity / size.max(f64::MIN_POSITIVE)
    }

    /// `b − Nᵀ x` into `self.p`; returns its size relative to what it is the difference of.
    pub(super) fn residual_of_held(&mut self, qp: &Qp) -> f64 {
        let mut primal = 0.0_f64;
        let held = self.set.active().iter().zip(&self.set.multipliers);
        for ((held, m), p) in held.zip(&mut self.p) {
            // What the row gives is part of what is at the limit.
            let gives = m * self.set.compliance(held.index);
            *p = held.limit - (self.point.value(held.index) - gives);
            // Else exact whatever the magnitude.
            if p.abs() > EXACT * held.limit.abs() {
                let size = held.limit.abs() + gives.abs() + self.point.magnitude(qp, held.index);
                primal = primal.max(p.abs() / size);
            }
        }
        self.primal = primal;
        primal
    }

    /// Whether the gradient vanishes beside its terms. Those of the multipliers, which may be large and cancel one
    /// another, are looked at only if it matters.
    pub(super) fn has_converged(&self, qp: &Qp) -> bool {
        if self.residual < CONVERGED {
            return true;
        }
        let unit = self.point.unit();
        let held = self.set.active().iter().zip(&self.set.multipliers);
        let terms = held.map(|(held, m)| m.abs() * largest_normal(qp, held.index, unit));
        // Beyond that they are the quotient of rounding and rounding: parallel normals were both held.
        let largest = terms.fold(self.size, f64::max).min(OPPOSED * self.size);
        self.primal < CONVERGED && self.residual * self.size < CONVERGED * largest
    }

    /// Whether the variables are so large beside `H x` and g that what is left of the terms may be rounding: then x is
    /// g divided by a pivot that ought to be zero.
    pub(super) fn cancels(&self) -> bool {
        self.point.largest() > CANCELLED * self.pull
    }

    /// Whether the refined point violates nothing and holds nothing with a multiplier of the wrong sign, beyond what is
    /// forgiven.
    pub(super) fn is_settled(&mut self, qp: &Qp, tolerance: f64, forgiven: f64) -> bool {
        let tolerance = tolerance.max(forgiven);
        if self.passed > tolerance {
            self.find_violated(qp, tolerance);
            if !self.violated.is_empty() {
                return false;
            }
        }
        (0..self.set.len()).all(|j| !self.is_wrong(qp, j, forgiven))
    }

    /// Whether the multiplier of the j-th constraint held has the wrong sign by more than is forgiven.
    pub(super) fn is_wrong(&self, qp: &Qp, j: usize, forgiven: f64) -> bool {
        let held = self.set.active()[j];
        let wrong = -self.set.multipliers[j] * held.side;
        wrong > 0.0
            && wrong * largest_normal(qp, held.index, self.point.unit()) > forgiven * self.size
    }

    /// The largest violation, relative to the numbers that are added up, of the constraints that were found to be
    /// implied.
    pub(super) fn missed(&self, qp: &Qp) -> f64 {
        let mut worst = 0.0_f64;
        for implied in &self.implied {
            // On the other side, too: what is implied is not checked any more.
            let (value, (lower, upper)) =
                (self.point.value(implied.index), limits(qp, implied.index));
            let (excess, limit) = if value > upper {
                (value - upper, upper)
            } else {
                (lower - value, lower)
            };
            if excess <= 0.0 {
                continue;
            }
            let size = limit.abs() + self.point.magnitude(qp, implied.index);
            let relative = excess / size;
            // A NaN is the worst.
            if relative.is_nan() {
                return f64::INFINITY;
            }
            worst = worst.max(relative);
        }
        worst
    }

    /// Has the constraints checked again that were found to be implied: those held may be others now. Equalities stay:
    /// what implies them is never let go.
    pub(super) fn reconsider(&mut self) {
        let settled = &mut self.settled;
        self.implied.retain(|implied| {
            settled[implied.index] = implied.side == 0.0;
            implied.side == 0.0
        });
        self.passed = f64::INFINITY;
    }

    /// The next proximal step, or another look at a point that was refined: what is wrongly held is let go.
    pub(super) fn move_on(&mut self, qp: &Qp, forgiven: f64) {
        let w = &mut self.w[..self.stride];
        self.set.centre(&self.hessian, self.point.x(), w);
        for j in (0..self.set.len()).rev() {
            if self.is_wrong(qp, j, forgiven) {
                self.release(j);
            }
        }
        for (held, m) in self.set.held_mut() {
            if *m * held.side < 0.0 {
                *m = 0.0;
            }
        }
    }
}
