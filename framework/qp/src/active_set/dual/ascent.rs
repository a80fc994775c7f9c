//! The dual iteration: from the constraints held so far to those of the optimum.

use std::array::from_fn;

use super::{
    super::{
        constraint::{Active, count, is_empty, limits},
        kernels::LANES,
        limits::Limits,
        working_set::WorkingSet,
    },
    Dual, End,
    homotopy::Path,
};
use crate::{Qp, Solution};

/// Violated constraints are held together in one round for so many variables, and in the first in any case. More would
/// hold what has to be let go again.
const JOINT_VARIABLES: usize = 10;
/// In the first of these, how far away a constraint is, relative to the farthest, to be held with it, and in the
/// others. Constraints that are nearer are often satisfied once those are held, and would have to be let go one by one.
const FAR: [f64; 2] = [0.3, 0.8];
/// Rounds in which all constraints with a multiplier of the wrong sign are let go together, if none is known.
const GUESS_ROUNDS: u32 = 6;
/// Iterations after which larger violations, too, are taken for rounding.
const LONG: u32 = 200;
/// A violation below this, relative to the numbers that are added up, may be the rounding of an `x` that is not
/// refined.
const ROUNDING: f64 = 1e-8;
/// The same where constraints give, and with it the factor by which the tolerance grows: multipliers are large there.
const ROUNDING_OF_SOFT: (f64, f64) = (1e-6, 16.0);
/// So many constraints that were held in vain one after the other are a sign of rounding.
const FUTILE: u32 = 2;
/// How far the constraints held may be from their limits, as a share, at a point that is not refined.
const OFF: f64 = 1e-7;
/// How far at one that was corrected, which is a sign that the factors are not good enough.
const LOST: f64 = 1e-5;
/// A part of a combination of normals, all of unit length in the metric of H, below this of the largest is rounding.
const ROUNDED_RATE: f64 = 1e-11;
/// Iterations with every point refined, after which they must be going in circles: so many and two for each constraint,
/// and at most the second number.
const REFINED_ROUNDS: (usize, usize) = (10, 100);

impl Dual {
    /// The dual iteration.
    pub(super) fn ascend(
        &mut self,
        qp: &Qp,
        limits: &mut Limits<'_>,
        is_first: bool,
        out: &mut Solution,
    ) -> End {
        let mut is_beginning = is_first;
        let mut joint_rounds = if is_first {
            (qp.n() / JOINT_VARIABLES).max(1)
        } else {
            0
        };
        let mut far = FAR[0];
        let mut tolerance = limits.tolerance;
        let (rounding, growth) = if self.set.is_soft() {
            ROUNDING_OF_SOFT
        } else {
            (ROUNDING, 2.0)
        };
        loop {
            if limits.are_used_up(self.iterations) {
                return End::Budget;
            }
            self.iterations += 1;
            self.set.find_targets();
            let mut is_evaluated = false;
            if is_beginning && !self.set.is_soft() {
                is_beginning = false;
                if self.knows_multipliers() {
                    let mut held = self.set.active().iter().zip(self.set.computed());
                    if held.any(|(held, target)| target * held.side < 0.0) {
                        match self.follow(qp, limits, out) {
                            Path::Arrived => is_evaluated = true,
                            Path::Left => continue,
                            Path::Ended(end) => return end,
                        }
                    }
                } else {
                    for _ in 0..GUESS_ROUNDS {
                        if !self.release_wrong() {
                            break;
                        }
                        self.iterations += 1;
                        self.set.find_targets();
                    }
                }
            }
            if self.set.is_soft() {
                if self.step_far(qp) {
                    if self.futile > FUTILE {
                        return End::Circles;
                    }
                    continue;
                }
            } else if let Some((alpha, j)) = blocking(&self.set) {
                self.set.approach_targets(alpha);
                self.release(j);
                continue;
            }
            self.set.accept_targets();
            if !is_evaluated {
                self.set.primal(&self.hessian, self.point.x_mut());
                self.evaluate(qp);
                if self.set.is_soft() && self.residual_of_held(qp) > OFF {
                    self.come_back(qp);
                    // `!(… <= …)`: a NaN is far away, too.
                    let is_back = self.residual_of_held(qp) <= LOST;
                    if !is_back {
                        return End::Circles;
                    }
                }
            }
            let worst = self.find_violated(qp, tolerance);
            if self.violated.is_empty() {
                return End::Optimal;
            }
            if worst < rounding || (worst < 1e3 * ROUNDING && self.iterations > LONG) {
                // May be rounding of x: constraints that are held and let go for that would never come to an end.
                // What is refined later is checked again.
                tolerance *= growth;
            }
            let farthest = self.measure_violated(qp);
            if joint_rounds > 0 && self.violated.len() > 1 {
                joint_rounds -= 1;
                let held_any = self.hold_far(qp, far * farthest);
                far = FAR[1];
                if held_any {
                    continue;
                }
            }
            if !self.hold_worst(qp, out) {
                return End::Infeasible;
            }
        }
    }

    /// The dual iteration with every point and its multipliers refined, which takes several times as long per iteration
    /// and decides by numbers that are exact.
    pub(super) fn ascend_refined(
        &mut self,
        qp: &Qp,
        limits: &mut Limits<'_>,
        forgiven: f64,
        out: &mut Solution,
    ) -> End {
        let tolerance = limits.tolerance.max(forgiven);
        let (some, most) = REFINED_ROUNDS;
        for _ in 0..most.min(2 * count(qp) + some) {
            if limits.are_used_up(self.iterations) {
                return End::Budget;
            }
            self.iterations += 1;
            self.before.clear();
            self.before.extend_from_slice(&self.set.multipliers);
            self.set.find_targets();
            self.set.accept_targets();
            self.set.primal(&self.hessian, self.point.x_mut());
            self.evaluate(qp);
            self.refine(qp, 0.0);
            if let Some((alpha, j)) = self.blocking_refined(qp, forgiven) {
                for (m, before) in self.set.multipliers.iter_mut().zip(&self.before) {
                    *m = before + alpha * (*m - before);
                }
                self.release(j);
                continue;
            }
            self.find_violated(qp, tolerance);
            if self.violated.is_empty() {
                return End::Optimal;
            }
            self.measure_violated(qp);
            if !self.hold_worst(qp, out) {
                return End::Infeasible;
            }
        }
        self.passed = f64::INFINITY;
        End::Circles
    }

    /// The first multiplier that becomes wrong on the way from those before to the refined ones, and after which part
    /// of it.
    fn blocking_refined(&self, qp: &Qp, forgiven: f64) -> Option<(f64, usize)> {
        let steps = self.set.multipliers.iter().zip(&self.before);
        let wrong = steps
            .enumerate()
            .filter(|(j, _)| self.is_wrong(qp, *j, forgiven));
        let parts = wrong.map(|(j, (target, before))| {
            let side = self.set.active()[j].side;
            let before = (before * side).max(0.0);
            (before / (before - target * side), j)
        });
        parts.reduce(|first, next| if next.0 < first.0 { next } else { first })
    }

    /// Whether the constraints held come with the multipliers that they had.
    fn knows_multipliers(&self) -> bool {
        let mut held = self.set.active().iter().zip(&self.set.multipliers);
        held.all(|(held, m)| held.side == 0.0 || *m != 0.0)
    }

    /// Lets all constraints go whose multiplier would have the wrong sign; whether there were any.
    fn release_wrong(&mut self) -> bool {
        let mut any = false;
        for j in (0..self.set.len()).rev() {
            let side = self.set.active()[j].side;
            if self.set.computed()[j] * side < 0.0 {
                self.release(j);
                any = true;
            }
        }
        any
    }

    /// Collects what the point violates by more than a tolerance, relative to the numbers that are added up, and notes
    /// whether it passes; returns the largest relative violation.
    pub(super) fn find_violated(&mut self, qp: &Qp, tolerance: f64) -> f64 {
        self.violated.clear();
        self.find_outside(qp);
        self.passed = if self.outside.is_empty() {
            0.0
        } else {
            tolerance
        };
        let mut worst = 0.0_f64;
        for &index in &self.outside {
            let (value, (lower, upper)) = (self.point.value(index), limits(qp, index));
            let (excess, side, limit) = if value > upper {
                (value - upper, 1.0, upper)
            } else {
                (lower - value, -1.0, lower)
            };
            let relative = excess / (limit.abs() + self.point.magnitude(qp, index));
            if relative > tolerance {
                worst = worst.max(relative);
                self.violated.push((excess, Active { index, side, limit }));
            }
        }
        if !self.violated.is_empty() {
            self.passed = f64::INFINITY;
        }
        worst
    }

    /// Collects the constraints that are to be checked and whose value is outside of the limits.
    fn find_outside(&mut self, qp: &Qp) {
        self.outside.clear();
        let rows = (0, self.point.row_values(), qp.row_lower(), qp.row_upper());
        let bounds = (qp.m(), self.point.x(), qp.lower(), qp.upper());
        for (first, values, lower, upper) in [rows, bounds] {
            let mut look = |index: usize, is_within: bool| {
                if !is_within && !self.settled[index] {
                    self.outside.push(index);
                }
            };
            let (values, values_rest) = values[..lower.len()].as_chunks::<LANES>();
            let ((lower, lower_rest), (upper, upper_rest)) =
                (lower.as_chunks::<LANES>(), upper.as_chunks::<LANES>());
            // Most are within, and are passed four at a time.
            for (c, ((v, l), u)) in values.iter().zip(lower).zip(upper).enumerate() {
                let are_within: [bool; LANES] = from_fn(|i| is_within(v[i], l[i], u[i]));
                if are_within != [true; LANES] {
                    for (i, is_within) in are_within.into_iter().enumerate() {
                        look(first + c * LANES + i, is_within);
                    }
                }
            }
            let first = first + values.len() * LANES;
            let rest = values_rest.iter().zip(lower_rest).zip(upper_rest);
            for (i, ((v, l), u)) in rest.enumerate() {
                look(first + i, is_within(*v, *l, *u));
            }
        }
    }

    /// Turns the excesses of what is violated into distances in the metric of H; returns the largest.
    fn measure_violated(&mut self, qp: &Qp) -> f64 {
        if self.violated.len() == 1 {
            return f64::INFINITY;
        }
        let mut farthest = 0.0_f64;
        for (excess, constraint) in &mut self.violated {
            *excess *= self
                .set
                .reciprocal_length(qp, &self.hessian, constraint.index);
            farthest = farthest.max(*excess);
        }
        farthest
    }

    /// Holds the violated constraints that are so far away and independent; whether there are any.
    fn hold_far(&mut self, qp: &Qp, far: f64) -> bool {
        let mut any = false;
        for i in 0..self.violated.len() {
            let (distance, constraint) = self.violated[i];
            if distance < far {
                continue;
            }
            if self.push(qp, constraint, 0.0) {
                self.settled[constraint.index] = true;
                any = true;
            }
        }
        any
    }

    /// Holds the violated constraint that is farthest away; false if that is impossible.
    pub(super) fn hold_worst(&mut self, qp: &Qp, out: &mut Solution) -> bool {
        let mut worst: Option<(f64, Active)> = None;
        for &(distance, constraint) in &self.violated {
            if worst.is_none_or(|(d, _)| distance > d) {
                worst = Some((distance, constraint));
            }
        }
        let Some((_, constraint)) = worst else {
            return true;
        };
        if is_empty(qp, constraint.index) {
            // Nothing can be done about it, and little is wrong with it: else it would be impossible.
            self.settled[constraint.index] = true;
            return true;
        }
        let mut multiplier = 0.0;
        while !self.push(qp, constraint, multiplier) {
            self.set.combine();
            let parts = || self.set.computed().iter().zip(self.set.lengths());
            let largest = parts().fold(0.0, |a: f64, (r, length)| a.max((r * length).abs()));
            let held = self.set.active().iter().zip(&self.set.multipliers);
            let mut first: Option<(f64, f64, usize)> = None;
            for (j, ((held, &multiplier), (&r, length))) in held.zip(parts()).enumerate() {
                // Along the ray this multiplier changes by −side · r per unit.
                let rate = held.side * constraint.side * r;
                if rate * length > ROUNDED_RATE * largest {
                    let step = (multiplier * held.side).max(0.0) / rate;
                    let rate = rate * length;
                    if first.is_none_or(|(s, q, _)| step < s || (step == s && rate > q)) {
                        first = Some((step, rate, j));
                    }
                }
            }
            let Some((step, _, j)) = first else {
                if self.contradicts(qp, constraint) {
                    self.certify(qp, constraint.index, constraint.side, out);
                    return false;
                }
                // Implied by those held up to rounding, which is what the violation is.
                self.settled[constraint.index] = true;
                self.implied.push(constraint);
                return true;
            };
            multiplier += step * constraint.side;
            self.set.follow_ray(step * constraint.side);
            self.release(j);
            self.iterations += 1;
        }
        self.settled[constraint.index] = true;
        true
    }
}

/// Whether a value is within its limits; a NaN is not.
#[expect(
    clippy::needless_bitwise_bool,
    reason = "lazy operators are branches, which cannot be foreseen here"
)]
fn is_within(value: f64, lower: f64, upper: f64) -> bool {
    (lower <= value) & (value <= upper)
}

/// The first multiplier that changes its sign on the way to the targets, and after which part of the way.
fn blocking(set: &WorkingSet) -> Option<(f64, usize)> {
    let mut first: Option<(f64, usize)> = None;
    let multipliers = set.multipliers.iter().zip(set.computed());
    for (j, (held, (m, t))) in set.active().iter().zip(multipliers).enumerate() {
        let (m, t) = ((m * held.side).max(0.0), t * held.side);
        if t < 0.0 {
            let alpha = m / (m - t);
            if first.is_none_or(|(a, _)| alpha < a) {
                first = Some((alpha, j));
            }
        }
    }
    first
}
