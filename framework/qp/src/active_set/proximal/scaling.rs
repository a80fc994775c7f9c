//! Units in which a problem's numbers are near one.
//!
//! # Mathematics
//! With `x = D x'` and `A' = R A D`, `H' = c D H D`, `g' = c D g`. D makes the diagonal of H one where it is not zero;
//! a variable without curvature gets the unit in which its coefficients are those of others, in the geometric mean, or
//! its bounds are one; one that has nothing but a cost, the unit in which that is one. R makes the largest coefficient
//! of every row one. c makes the larger of H and a thousandth of g one. All are powers of two, so that nothing is
//! rounded, and the scaled problem hardly depends on the units of the problem.

use super::super::constraint::{ENDLESS, range};
use crate::{Qp, QpError, Solution};

/// Passes over rows and columns without curvature.
const PASSES: usize = 12;
/// A cost with gradients up to this many times its curvature is scaled by its curvature.
const STEEP: f64 = 1e3;

/// The curvature of a variable whose range is a smaller part of the unit in which it is one is no cost to speak of.
const NEGLIGIBLE: f64 = 1e-9;

/// What curvature adds to a slope within the range may be this part of it, and is no cost to speak of.
const STRAIGHT: f64 = 1e-12;

/// A coefficient that is a smaller part of the largest of its row, and of its variable, is rounding.
const ROUNDING: f64 = 1e-11;

/// A cost that is a smaller part of the largest one, in the unit of its variable's bounds.
const FAINT: f64 = 1e-6;

/// Exponents of two.
#[derive(Clone, Debug)]
pub(super) struct Scaling {
    variables: Vec<f64>,
    rows: Vec<f64>,
    cost: f64,
    /// Of every coefficient.
    is_rounding: Vec<bool>,
    /// Which variables are connected, and sums over each such set.
    labels: Vec<usize>,
    sums: Vec<(f64, f64)>,
}

/// The power of two that is nearest to the reciprocal of a number, within what can be squared.
fn reciprocal(of: f64) -> f64 {
    if of > 0.0 {
        f64::exp2(-of.log2().round().clamp(-300.0, 300.0))
    } else {
        1.0
    }
}

/// Lower and upper limit without those that are [endless](ENDLESS), unless they are one.
fn without_endless(lower: f64, upper: f64) -> [f64; 2] {
    if lower == upper {
        return [lower, upper];
    }
    let lower = if lower > -ENDLESS {
        lower
    } else {
        f64::NEG_INFINITY
    };
    let upper = if upper < ENDLESS {
        upper
    } else {
        f64::INFINITY
    };
    [lower, upper]
}

/// Whether a row limits anything: the coefficients of others say nothing.
fn has_limit(qp: &Qp, i: usize) -> bool {
    let limits = without_endless(qp.row_lower()[i], qp.row_upper()[i]);
    limits.iter().any(|limit| limit.is_finite())
}

/// Whether a variable has neither curvature nor a part in any row: it goes to a bound, or has none.
fn is_separate(qp: &Qp, j: usize) -> bool {
    let is_apart = |i| qp.row(i)[j] == 0.0 || !has_limit(qp, i);
    qp.h()[j * qp.n() + j] == 0.0 && (0..qp.m()).all(is_apart)
}

/// Whether it has no bounds either.
fn is_alone(qp: &Qp, j: usize) -> bool {
    let limits = without_endless(qp.lower()[j], qp.upper()[j]);
    limits.iter().all(|limit| limit.is_infinite()) && is_separate(qp, j)
}

/// The size of a fixed variable, of which nothing else is known if it is zero.
fn size(fixed: f64) -> f64 {
    if fixed == 0.0 { 1.0 } else { fixed.abs() }
}

/// The sum of the exponents of two of what is finite and not zero, and how many that are.
fn exponents(numbers: impl Iterator<Item = f64>) -> (f64, f64) {
    let (mut sum, mut count) = (0_i64, 0_i64);
    for number in numbers.filter(|number| number.is_finite() && *number != 0.0) {
        sum += ((number.to_bits() >> 52) & 0x7ff).cast_signed() - 1023;
        count += 1;
    }
    (sum as f64, count as f64)
}

/// The power of two that is nearest to the reciprocal of the geometric mean of what is not zero: with units of rows and
/// variables by turns, whatever is a product of such units is undone (Curtis and Reid, 1972).
fn mean(entries: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = exponents(entries);
    power(-sum / count.max(1.0))
}

/// A power of two within what can be squared.
fn power(exponent: f64) -> f64 {
    f64::exp2(exponent.round().clamp(-300.0, 300.0))
}

impl Scaling {
    pub(super) fn new(vars: usize, rows: usize) -> Self {
        Self {
            variables: vec![1.0; vars],
            rows: vec![1.0; rows],
            cost: 1.0,
            is_rounding: vec![false; vars * rows],
            labels: vec![0; vars],
            sums: vec![(0.0, 0.0); vars],
        }
    }

    /// Chooses the units.
    pub(super) fn choose(&mut self, qp: &Qp) {
        let (n, m) = (qp.n(), qp.m());
        for (j, d) in self.variables[..n].iter_mut().enumerate() {
            *d = reciprocal(qp.h()[j * n + j].sqrt());
        }
        self.is_rounding[..n * m].fill(false);
        self.balance(qp);
        if self.finds_rounding(qp) {
            self.balance(qp);
        }
        self.anchor(qp);
        self.confine(qp);
        for i in 0..m {
            let entries = qp.row(i).iter().zip(&self.variables);
            self.rows[i] = reciprocal(entries.fold(0.0, |a: f64, (x, d)| a.max((x * d).abs())));
        }
        let scaled = |values: f64, d: f64| (values * d).abs();
        // What a fixed variable costs moves nothing.
        let movable = (0..n).filter(|&j| qp.lower()[j] != qp.upper()[j] && !is_alone(qp, j));
        let steepest = movable.fold(0.0, |a: f64, j| a.max(scaled(qp.g()[j], self.variables[j])));
        let curved = (0..n).fold(0.0, |a: f64, j| {
            a.max(scaled(qp.h()[j * n + j], self.variables[j].powi(2)))
        });
        self.cost = if curved > 0.0 {
            reciprocal(curved.max(steepest / STEEP))
        } else {
            reciprocal(steepest)
        };
        self.see_costs(qp);
    }

    /// Units of rows and of variables without curvature, by turns, in which coefficients are near one.
    fn balance(&mut self, qp: &Qp) {
        let (n, m) = (qp.n(), qp.m());
        for _ in 0..PASSES {
            for i in 0..m {
                let entries = qp.row(i).iter().zip(&self.variables).enumerate();
                let known = entries.filter(|(j, _)| !self.is_rounding[i * n + j]);
                self.rows[i] = mean(known.map(|(_, (a, d))| a * d));
            }
            for j in (0..n).filter(|j| qp.h()[j * n + j] == 0.0) {
                let known = (0..m).filter(|i| has_limit(qp, *i) && !self.is_rounding[i * n + j]);
                self.variables[j] = mean(known.map(|i| qp.row(i)[j] * self.rows[i]));
            }
        }
    }

    /// Marks the coefficients that are rounding beside others of their row and of their variable, in the units found so
    /// far, as the cosine of a right angle is: they say nothing about units. Whether there are any.
    fn finds_rounding(&mut self, qp: &Qp) -> bool {
        let (n, m) = (qp.n(), qp.m());
        let (rows, variables) = (&self.rows, &self.variables);
        let size = |i: usize, j: usize| (qp.row(i)[j] * rows[i] * variables[j]).abs();
        let mut finds = false;
        for i in 0..m {
            let in_row = (0..n).fold(0.0, |most: f64, j| most.max(size(i, j)));
            for j in (0..n).filter(|&j| qp.row(i)[j] != 0.0) {
                let is_faint = |most: f64| size(i, j) < ROUNDING * most;
                if is_faint(in_row) && (0..m).any(|k| is_faint(size(k, j))) {
                    self.is_rounding[i * n + j] = true;
                    finds = true;
                }
            }
        }
        finds
    }

    /// What has a cost, and nothing else but bounds, has the unit in which its cost is one, if in that of its bounds
    /// hardly anything is left of it: limits may be the rounding of zero. Without bounds it falls for ever, whatever
    /// its cost is.
    fn see_costs(&mut self, qp: &Qp) {
        for j in (0..qp.n()).filter(|&j| is_separate(qp, j)) {
            let (d, g) = (self.variables[j], self.cost * qp.g()[j].abs());
            let (lower, upper) = (qp.lower()[j], qp.upper()[j]);
            if is_alone(qp, j) {
                self.variables[j] = reciprocal(g);
            } else if g * d < FAINT && g > 0.0 && lower < upper {
                let [lower, upper] = without_endless(lower, upper);
                let most = 1.0 / reciprocal(range(lower, upper));
                self.variables[j] = reciprocal(g).min(most).max(d);
            }
        }
    }

    /// Where rows connect variables without curvature alone, nothing says what their common unit is against that of the
    /// rows: the one in which their limits are near one, in the geometric mean.
    fn anchor(&mut self, qp: &Qp) {
        let (n, m) = (qp.n(), qp.m());
        // What is connected has the label of its first variable; n is that of what curvature anchors.
        for (j, label) in self.labels[..n].iter_mut().enumerate() {
            *label = if qp.h()[j * n + j] == 0.0 { j } else { n };
        }
        let is_in = |i: usize, j: usize| qp.row(i)[j] != 0.0 && has_limit(qp, i);
        let label_of = |labels: &[usize], i: usize| {
            let connected = (0..n).filter(|&j| is_in(i, j)).map(|j| labels[j]);
            let is_anchored = connected.clone().any(|label| label == n);
            if is_anchored {
                Some(n)
            } else {
                connected.min()
            }
        };
        for _ in 0..=n {
            let mut changes = false;
            for i in 0..m {
                let Some(label) = label_of(&self.labels, i) else {
                    continue;
                };
                for j in (0..n).filter(|&j| is_in(i, j)) {
                    changes |= self.labels[j] != label;
                    self.labels[j] = label;
                }
            }
            if !changes {
                break;
            }
        }
        self.sums[..n].fill((0.0, 0.0));
        for j in (0..n).filter(|&j| self.labels[j] < n) {
            let d = self.variables[j];
            let limits = without_endless(qp.lower()[j], qp.upper()[j]);
            let (sum, count) = exponents(limits.into_iter().map(|limit| limit / d));
            let total = &mut self.sums[self.labels[j]];
            *total = (total.0 + sum, total.1 + count);
        }
        for i in 0..m {
            let Some(label) = label_of(&self.labels, i).filter(|&label| label < n) else {
                continue;
            };
            let r = self.rows[i];
            let limits = without_endless(qp.row_lower()[i], qp.row_upper()[i]);
            let (sum, count) = exponents(limits.into_iter().map(|limit| limit * r));
            let total = &mut self.sums[label];
            *total = (total.0 + sum, total.1 + count);
        }
        for j in (0..n).filter(|&j| self.labels[j] < n) {
            let (sum, count) = self.sums[self.labels[j]];
            self.variables[j] *= power(sum / count.max(1.0));
        }
    }

    /// No unit is much larger than its variable can be: what is left of the range would be rounding.
    fn confine(&mut self, qp: &Qp) {
        let n = qp.n();
        let bounds = qp.lower().iter().zip(qp.upper());
        for (j, (d, (lower, upper))) in self.variables.iter_mut().zip(bounds).enumerate() {
            let [lower, upper] = without_endless(*lower, *upper);
            let h = qp.h()[j * n + j];
            let range = if lower == upper && h == 0.0 {
                // What it is: nothing else gives it a unit but coefficients, which may be rounding.
                size(lower)
            } else {
                range(lower, upper)
            };
            let is_linear = h * range <= STRAIGHT * qp.g()[j].abs();
            let least = if is_linear { 1.0 } else { NEGLIGIBLE };
            if range < least * *d {
                *d = 1.0 / reciprocal(range);
            }
        }
    }

    /// Writes the scaled problem, which has the same identities.
    pub(super) fn apply(&self, qp: &Qp, scaled: &mut Qp) -> Result<(), QpError> {
        let n = qp.n();
        scaled.copy_from(qp)?;
        let (d, c) = (&self.variables[..n], self.cost);
        let (h, g) = scaled.cost_mut();
        for (row, (g, d_i)) in h.chunks_exact_mut(n).zip(g.iter_mut().zip(d)) {
            for (h, d_j) in row.iter_mut().zip(d) {
                *h *= c * d_i * d_j;
            }
            *g *= c * d_i;
        }
        for i in 0..qp.m() {
            let r = self.rows[i];
            for (a, d) in scaled.row_mut(i).iter_mut().zip(d) {
                *a *= r * d;
            }
        }
        let (lower, upper) = scaled.row_limits_mut();
        for ((lower, upper), r) in lower.iter_mut().zip(upper).zip(&self.rows) {
            [*lower, *upper] = without_endless(*lower, *upper).map(|limit| limit * r);
        }
        let (lower, upper) = scaled.bounds_mut();
        for ((lower, upper), d) in lower.iter_mut().zip(upper).zip(d) {
            [*lower, *upper] = without_endless(*lower, *upper).map(|limit| limit / d);
        }
        Ok(())
    }

    /// Turns a solution of the scaled problem into one of the original.
    pub(super) fn undo(&self, n: usize, m: usize, solution: &mut Solution) {
        let numbers = solution.x[..n].iter_mut().zip(&mut solution.z[..n]);
        for ((x, z), d) in numbers.zip(&self.variables) {
            *x *= d;
            *z /= d * self.cost;
        }
        for (y, r) in solution.y[..m].iter_mut().zip(&self.rows) {
            *y *= r / self.cost;
        }
    }
}
