//! Rows and bounds seen as one list of constraints: rows first, then one bound per variable.

use std::array::from_fn;

use super::kernels::{LANES, dot, largest};
use crate::{ConstraintId, Qp, RowId, Solution, VarId};

/// Largest violation at an optimum, relative to the limit and the sizes of the terms of the row's value.
const VIOLATION: f64 = 1e-10;
/// A violation that is none, however small the numbers that it is made of: rounding of the largest variable.
const NOTHING: f64 = 1e-13;
/// The same of a row without coefficients, which has no scale.
const EMPTY: f64 = 1e-9;
/// A part of the cost that is its rounding.
const CHEAP: f64 = 1e-12;

/// A finite limit from this on is taken for none where it would be weighed beside others: as other solvers do.
pub(super) const ENDLESS: f64 = 1e20;

/// A constraint held at one of its limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Active {
    /// Index of the row, or m + index of the variable.
    pub(super) index: usize,
    /// +1 at the upper limit, −1 at the lower one, 0 for an equality, whose multiplier may have any sign.
    pub(super) side: f64,
    /// Value of that limit.
    pub(super) limit: f64,
}

/// Index of a constraint that may exist.
#[inline(always)]
pub(super) fn index_of(qp: &Qp, constraint: ConstraintId) -> Option<usize> {
    match constraint {
        ConstraintId::Row(id) => position(qp.rows(), id, RowId::index),
        ConstraintId::Bound(id) => position(qp.vars(), id, VarId::index).map(|j| qp.m() + j),
    }
}

/// The identity of a constraint.
#[inline(always)]
pub(super) fn id_of(qp: &Qp, index: usize) -> ConstraintId {
    match index.checked_sub(qp.m()) {
        None => ConstraintId::Row(qp.rows()[index]),
        Some(j) => ConstraintId::Bound(qp.vars()[j]),
    }
}

/// Position of an identity among ascending ones, which mostly follow one another.
#[inline(always)]
fn position<Id: Copy + Ord>(all: &[Id], id: Id, number: fn(Id) -> usize) -> Option<usize> {
    let guess = number(id).checked_sub(number(*all.first()?))?;
    if all.get(guess) == Some(&id) {
        return Some(guess);
    }
    all.binary_search(&id).ok()
}

/// How large a variable between two bounds can be; infinite if it has not got both, or is fixed. Rounding that is
/// larger than a part of it is none, whatever the variable's unit seems to be.
#[inline(always)]
pub(super) fn range(lower: f64, upper: f64) -> f64 {
    let largest = larger(lower.abs(), upper.abs());
    if lower < upper {
        largest
    } else {
        f64::INFINITY
    }
}

/// Number of constraints.
pub(super) fn count(qp: &Qp) -> usize {
    qp.m() + qp.n()
}

/// Whether any lower limit is the upper one: all of them, four at a time, without deciding on the way.
#[inline(always)]
pub(super) fn any_equal(lower: &[f64], upper: &[f64]) -> bool {
    let ((lowers, lower_rest), (uppers, upper_rest)) =
        (lower.as_chunks::<LANES>(), upper.as_chunks::<LANES>());
    let mut are = [false; LANES];
    for (lower, upper) in lowers.iter().zip(uppers) {
        let equal: [bool; LANES] = from_fn(|l| lower[l] == upper[l]);
        are = from_fn(|l| are[l] | equal[l]);
    }
    are != [false; LANES] || lower_rest.iter().zip(upper_rest).any(|(l, u)| l == u)
}

/// Equality rows and fixed variables with their values.
pub(super) fn equalities(qp: &Qp) -> impl Iterator<Item = Active> {
    let rows = qp.row_lower().iter().zip(qp.row_upper());
    let limits = rows.chain(qp.lower().iter().zip(qp.upper()));
    let equal = |(_, (lower, upper)): &(usize, (&f64, &f64))| lower == upper;
    limits
        .enumerate()
        .filter(equal)
        .map(|(index, _)| equality(qp, index))
}

/// The constraint that holds a value at its limits, which are equal.
#[inline(always)]
pub(super) fn equality(qp: &Qp, index: usize) -> Active {
    Active {
        index,
        side: 0.0,
        limit: limits(qp, index).0,
    }
}

/// Lower and upper limit.
#[inline(always)]
pub(super) fn limits(qp: &Qp, index: usize) -> (f64, f64) {
    match index.checked_sub(qp.m()) {
        None => (qp.row_lower()[index], qp.row_upper()[index]),
        Some(j) => (qp.lower()[j], qp.upper()[j]),
    }
}

/// `aᵀ x`.
pub(super) fn value(qp: &Qp, index: usize, x: &[f64]) -> f64 {
    match index.checked_sub(qp.m()) {
        None => dot(qp.row(index), x),
        Some(j) => x[j],
    }
}

/// `|a|ᵀ |x|`.
pub(super) fn sum_of_sizes(qp: &Qp, index: usize, x: &[f64]) -> f64 {
    match index.checked_sub(qp.m()) {
        None => {
            let terms = qp.row(index).iter().zip(x);
            terms.map(|(a, x)| (a * x).abs()).sum()
        }
        Some(j) => x[j].abs(),
    }
}

/// Moves what is outside of its bounds by more than [`VIOLATION`] onto them: the unit of a variable may be so large
/// that rounding is. What is outside by less stays, so that rows with large multipliers stay where they are.
#[inline(always)]
pub(super) fn keep_bounds(qp: &Qp, solution: &mut Solution) {
    let bounds = qp.lower().iter().zip(qp.upper());
    for (x, (lower, upper)) in solution.x.iter_mut().zip(bounds) {
        let limit = if *x < *lower { *lower } else { *upper };
        let is_outside = *x < *lower || *x > *upper;
        if is_outside && (*x - limit).abs() > VIOLATION * (limit.abs() + x.abs()) {
            *x = limit;
        }
    }
}

/// Moves what a bound holds onto it, where its multiplier is larger than what rows push with, and what it is off by
/// costs more than [`CHEAP`] of the linear cost: off by rounding it costs that multiplier, and rows cost less. The
/// gradient may change by no more than such a part of the multiplier.
#[inline(always)]
pub(super) fn settle_on_bounds(qp: &Qp, solution: &mut Solution) {
    let Solution { x, y, z, .. } = solution;
    let terms = qp.g().iter().zip(x.iter());
    let cheap = CHEAP * terms.map(|(g, x)| (g * x).abs()).sum::<f64>();
    for (j, (x, z)) in x.iter_mut().zip(z.iter()).enumerate().take(qp.n()) {
        if *z == 0.0 {
            continue;
        }
        let limit = if *z > 0.0 {
            qp.upper()[j]
        } else {
            qp.lower()[j]
        };
        let distance = (*x - limit).abs();
        if z.abs() * distance > cheap && distance <= VIOLATION * (limit.abs() + x.abs()).max(1.0) {
            let rows = (0..qp.m()).map(|i| (qp.row(i)[j] * y[i]).abs());
            let bends = qp.h()[j * qp.n() + j] * distance > CHEAP * z.abs();
            if !bends && rows.sum::<f64>() <= z.abs() {
                *x = limit;
            }
        }
    }
}

/// Whether a point in units near one satisfies every row and bound to [`VIOLATION`].
pub(super) fn all_hold(qp: &Qp, x: &[f64]) -> bool {
    let rounding = NOTHING * largest(x).max(1.0);
    let ranges = || {
        qp.lower()
            .iter()
            .zip(qp.upper())
            .map(|(l, u)| range(*l, *u))
    };
    // A variable carries no more of the largest one's rounding than a part of its range.
    let rounding_of = |index: usize| match index.checked_sub(qp.m()) {
        None => {
            let terms = qp.row(index).iter().zip(ranges());
            let sum: f64 = terms
                .filter(|(a, _)| **a != 0.0)
                .map(|(a, range)| a.abs() * (VIOLATION * range))
                .sum();
            rounding.min(sum)
        }
        Some(j) => rounding.min(VIOLATION * range(qp.lower()[j], qp.upper()[j])),
    };
    (0..count(qp)).all(|index| {
        let (lower, upper) = limits(qp, index);
        let value = value(qp, index, x);
        let (excess, limit) = if value > upper {
            (value - upper, upper)
        } else {
            (lower - value, lower)
        };
        // `!(… > …)`: infinite where there is no limit. A NaN does not hold.
        excess <= VIOLATION * limit.abs()
            || excess <= VIOLATION * (limit.abs() + sum_of_sizes(qp, index, x)) + rounding_of(index)
            || (excess <= EMPTY && is_empty(qp, index))
    })
}

/// A constraint that nothing satisfies: its lower limit is above its upper one by more than rounding, or it has no
/// coefficients, and limits that zero is not between.
#[inline(always)]
pub(super) fn impossible(qp: &Qp) -> Option<Active> {
    let (rows, bounds) = ((qp.row_lower(), qp.row_upper()), (qp.lower(), qp.upper()));
    let crossing = |lower: f64, upper: f64| lower - upper;
    let away_from_zero = |lower: f64, upper: f64| larger(lower, -upper);
    let is_any_crossed = largest_of(rows, crossing) > 0.0 || largest_of(bounds, crossing) > 0.0;
    let is_any_away = largest_of(rows, away_from_zero) > EMPTY;
    let crossed = || (0..count(qp)).find_map(|index| crossed(qp, index));
    let first = if is_any_crossed { crossed() } else { None };
    if first.is_some() || !is_any_away {
        return first;
    }
    let mut away = rows.0.iter().zip(rows.1).enumerate();
    away.find_map(|(index, (lower, upper))| {
        let is_away = away_from_zero(*lower, *upper) > EMPTY;
        (is_away && is_empty(qp, index)).then(|| beyond_zero(index, *lower, *upper))
    })
}

#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

/// The largest of what is computed from limits: four at a time, and nothing is decided on the way.
#[inline(always)]
fn largest_of((lower, upper): (&[f64], &[f64]), of: impl Fn(f64, f64) -> f64) -> f64 {
    let ((lowers, lower_rest), (uppers, upper_rest)) =
        (lower.as_chunks::<LANES>(), upper.as_chunks::<LANES>());
    let mut lanes = [f64::NEG_INFINITY; LANES];
    for (lower, upper) in lowers.iter().zip(uppers) {
        for l in 0..LANES {
            lanes[l] = larger(lanes[l], of(lower[l], upper[l]));
        }
    }
    let rest = lower_rest.iter().zip(upper_rest);
    let rest = rest.map(|(lower, upper)| of(*lower, *upper));
    lanes
        .into_iter()
        .chain(rest)
        .fold(f64::NEG_INFINITY, larger)
}

/// A constraint whose limits are crossed by more than rounding.
fn crossed(qp: &Qp, index: usize) -> Option<Active> {
    let (lower, upper) = limits(qp, index);
    let is_crossed = lower > upper
        && lower - upper > VIOLATION * (lower.abs() + upper.abs())
        && larger(lower.abs(), upper.abs()) > NOTHING;
    // Both limits; the multiplier names one.
    is_crossed.then_some(Active {
        index,
        side: 1.0,
        limit: upper,
    })
}

/// A row without coefficients that zero does not satisfy.
fn beyond_zero(index: usize, lower: f64, upper: f64) -> Active {
    let (side, limit) = if upper < 0.0 {
        (1.0, upper)
    } else {
        (-1.0, lower)
    };
    Active { index, side, limit }
}

/// Whether a row has no coefficients.
pub(super) fn is_empty(qp: &Qp, index: usize) -> bool {
    index < qp.m() && qp.row(index).iter().all(|a| *a == 0.0)
}

/// Largest entry of a normal, the variables in their units.
pub(super) fn largest_normal(qp: &Qp, index: usize, unit: &[f64]) -> f64 {
    match index.checked_sub(qp.m()) {
        None => {
            let entries = qp.row(index).iter().zip(unit);
            entries.fold(0.0, |largest, (a, unit)| largest.max((a * unit).abs()))
        }
        Some(j) => unit[j],
    }
}

/// Copies `a`, with zeros in the padding.
pub(super) fn copy_normal(qp: &Qp, index: usize, out: &mut [f64]) {
    match index.checked_sub(qp.m()) {
        None => {
            out[..qp.n()].copy_from_slice(qp.row(index));
            out[qp.n()..].fill(0.0);
        }
        Some(j) => {
            out.fill(0.0);
            out[j] = 1.0;
        }
    }
}

/// `out += α a`.
#[inline(always)]
pub(super) fn add_normal(qp: &Qp, index: usize, alpha: f64, out: &mut [f64]) {
    match index.checked_sub(qp.m()) {
        None => super::kernels::axpy(out, alpha, qp.row(index)),
        Some(j) => out[j] += alpha,
    }
}

#[cfg(test)]
mod tests {
    use super::{any_equal, position};
    use crate::RowId;

    #[test]
    fn identities_are_found_where_they_are_whatever_is_left_out() {
        let all: Vec<RowId> = (3..40).map(RowId::new).collect();
        for step in 1..6 {
            let some: Vec<RowId> = all.iter().copied().step_by(step).collect();
            for id in (0..45).map(RowId::new) {
                let found = position(&some, id, RowId::index);
                assert_eq!(found, some.binary_search(&id).ok(), "{step} {id:?}");
            }
        }
        assert_eq!(position(&[], RowId::new(0), RowId::index), None);
    }

    #[test]
    fn an_equality_is_seen_wherever_it_stands() {
        for n in 0..11 {
            let (lower, mut upper) = (vec![-1.0; n], vec![1.0; n]);
            assert!(!any_equal(&lower, &upper));
            for i in 0..n {
                upper[i] = -1.0;
                assert!(any_equal(&lower, &upper), "{i} of {n}");
                upper[i] = f64::NAN;
                assert!(!any_equal(&lower, &upper), "{i} of {n}");
                upper[i] = 1.0;
            }
        }
    }
}
