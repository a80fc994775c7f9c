//! Proofs that a problem has no solution.

use super::{
    super::{
        constraint::{Active, add_normal, copy_normal, largest_normal},
        kernels::{axpy, largest_product},
    },
    Dual, VIOLATION, add_multiplier,
};
use crate::{Qp, Solution};

/// Rounding of the coefficients of a combination, relative to the largest.
const COMBINED: f64 = 1e-14;
/// A sum of limits below zero by less than this part of its terms may be rounding.
const BEYOND: f64 = 1e-13;
/// What is left of a dependent normal less its combination, relative to the largest term.
const CLOSED: f64 = 1e-13;
/// How many times larger than at present the variables would have to be for normals that are only nearly dependent to
/// bring contradictory limits together.
const STRETCHED: f64 = 1e3;

impl Dual {
    /// Whether the limits of a dependent constraint and of those held contradict one another by more than rounding.
    pub(super) fn contradicts(&mut self, qp: &Qp, constraint: Active) -> bool {
        self.refine_combination(qp, constraint.index);
        self.drop_wrong(constraint.side);
        let (mut sum, mut size) = (0.0, 0.0);
        let held = self.set.active().iter().zip(self.set.computed());
        let terms = held.map(|(held, r)| -constraint.side * r * held.limit);
        for term in terms.chain([constraint.side * constraint.limit]) {
            sum += term;
            size += f64::abs(term);
        }
        // The sum is what the constraint is violated by wherever the others hold.
        if sum >= -BEYOND * size || -sum <= VIOLATION * self.accepted_size(qp, constraint) {
            return false;
        }
        // Where limits are zero, the whole sum may be the rounding of a coefficient that is zero, too.
        let unit = self.point.unit();
        let held = || self.set.active().iter().zip(self.set.computed());
        let largest = held().fold(
            largest_normal(qp, constraint.index, unit),
            |a, (held, r)| a.max(r.abs() * largest_normal(qp, held.index, unit)),
        );
        let rounding: f64 = held()
            .map(|(held, _)| held.limit.abs() / largest_normal(qp, held.index, unit))
            .sum();
        // `!(… ≤ …)`: a NaN explains nothing.
        let is_rounding = -sum <= COMBINED * largest * rounding;
        !is_rounding && self.is_dependent(qp, constraint.index, -sum, largest)
    }

    /// Whether a normal and its combination, whose largest term is given, differ by rounding only. If by more, they are
    /// nearly dependent, and a gap between the limits is a contradiction only if the variables would have to be very
    /// large to close it.
    fn is_dependent(&mut self, qp: &Qp, index: usize, gap: f64, largest: f64) -> bool {
        let rest = &mut self.gradient[..self.stride];
        copy_normal(qp, index, rest);
        for (held, &r) in self.set.active().iter().zip(&self.p) {
            add_normal(qp, held.index, -r, rest);
        }
        largest_product(rest, self.point.unit()) <= CLOSED * largest
            || gap > STRETCHED * self.leftover()
    }

    /// What a violation is compared with at the minimiser on the constraints held, where it leaves the point.
    fn accepted_size(&mut self, qp: &Qp, constraint: Active) -> f64 {
        self.set.find_targets();
        self.set.primal(&self.hessian, self.point.x_mut());
        self.evaluate(qp);
        self.set.take_combination(&self.p[..self.set.len()]);
        constraint.limit.abs() + self.point.magnitude_with_rounding(qp, constraint.index)
    }

    /// What the rest in `self.gradient` may come to with variables of the size that they have at the point.
    fn leftover(&self) -> f64 {
        let sizes = self.point.x().iter().zip(self.point.unit());
        let sizes = sizes.map(|(x, unit)| x.abs() + unit * self.point.largest());
        let rest = &self.gradient[..self.stride];
        rest.iter().zip(sizes).map(|(r, size)| r.abs() * size).sum()
    }

    /// Corrects the combination of held normals that a dependent one was found to be, by what is left of it; leaves it
    /// in `self.p`.
    fn refine_combination(&mut self, qp: &Qp, index: usize) {
        let k = self.set.len();
        self.p[..k].copy_from_slice(self.set.computed());
        let rest = &mut self.gradient[..self.stride];
        for _ in 0..2 {
            copy_normal(qp, index, rest);
            for (held, &r) in self.set.active().iter().zip(&self.p) {
                add_normal(qp, held.index, -r, rest);
            }
            self.set.project(&self.hessian, rest);
            axpy(&mut self.p[..k], 1.0, self.set.computed());
        }
    }

    /// Leaves out of the refined combination what would have a multiplier of the wrong sign: rounding, else its
    /// constraint would have been let go. If it is not, [`Dual::is_dependent`] sees it.
    fn drop_wrong(&mut self, side: f64) {
        for (r, held) in self.p.iter_mut().zip(self.set.active()) {
            // What gives contradicts nothing.
            if *r * side * held.side > 0.0 || self.set.compliance(held.index) > 0.0 {
                *r = 0.0;
            }
        }
        self.set.take_combination(&self.p[..self.set.len()]);
    }

    /// Writes the proof that a constraint, at one of its sides, contradicts those held, whose combination was computed
    /// last.
    pub(super) fn certify(&mut self, qp: &Qp, index: usize, side: f64, out: &mut Solution) {
        for (r, held) in self.set.computed().iter().zip(self.set.active()) {
            add_multiplier(qp, held.index, -side * r, out);
        }
        add_multiplier(qp, index, side, out);
    }
}
