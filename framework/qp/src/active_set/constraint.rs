//! Rows and bounds seen as one list of constraints: rows first, then one bound per variable.

use super::kernels::dot;
use crate::Qp;

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

/// Number of constraints.
pub(super) fn count(qp: &Qp) -> usize {
    qp.m() + qp.n()
}

/// Equality rows and fixed variables with their values.
pub(super) fn equalities(qp: &Qp) -> impl Iterator<Item = (usize, f64)> {
    let rows = qp.row_lower().iter().zip(qp.row_upper());
    let limits = rows.chain(qp.lower().iter().zip(qp.upper()));
    let equal = |(_, (lower, upper)): &(usize, (&f64, &f64))| lower == upper;
    limits
        .enumerate()
        .filter(equal)
        .map(|(index, (&limit, _))| (index, limit))
}

/// Lower and upper limit.
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

/// The size of the numbers whose rounding a value carries: `|a|ᵀ |x|`, and a thousandth of `|a|ᵀ` times the largest
/// variable, which is what is left where large numbers cancel. `unit` holds the variables' units, in which they compare,
/// and `largest` the largest variable in these.
pub(super) fn magnitude(qp: &Qp, index: usize, x: &[f64], unit: &[f64], largest: f64) -> f64 {
    let of = |x: f64, unit: f64| x.abs() + 1e-3 * unit * largest;
    match index.checked_sub(qp.m()) {
        None => {
            let terms = qp.row(index).iter().zip(x.iter().zip(unit));
            terms.map(|(a, (&x, &unit))| a.abs() * of(x, unit)).sum()
        }
        Some(j) => of(x[j], unit[j]),
    }
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
pub(super) fn add_normal(qp: &Qp, index: usize, alpha: f64, out: &mut [f64]) {
    match index.checked_sub(qp.m()) {
        None => super::kernels::axpy(out, alpha, qp.row(index)),
        Some(j) => out[j] += alpha,
    }
}
