//! The point that is looked at: its variables, and what the constraints' values there are made of.

use super::{
    constraint,
    kernels::{LANES, dot, dot_magnitudes, dots_of, largest_product, padded},
};
use crate::{Capacity, Qp};

/// Largest variable, in its unit, from which on the pull of the cost is not looked at, to save the time.
const SMALL: f64 = 1e-8;
/// Part of that pull, the largest `|g_j|/√h_jj`, that the rounding of smaller variables is relative to.
const PULL: f64 = 1e-6;

/// The part of the largest variable that is left where large numbers cancel, as long as the last digits do not count.
const LEFT: f64 = 1e-3;
/// Rounding of the largest variable, beside the accepted violation.
const ROUNDED: f64 = 1e-2;

/// Variables and the values of all constraints.
#[derive(Clone, Debug, Default)]
pub(super) struct Point {
    n: usize,
    m: usize,
    /// Padded.
    x: Vec<f64>,
    /// `A x`.
    values: Vec<f64>,
    /// `1/√h_jj`, the unit of each variable, or the range between its bounds if that is less.
    unit: Vec<f64>,
    /// `√h_jj`.
    per_unit: Vec<f64>,
    /// The largest variable, each in its unit.
    largest: f64,
    /// The size of the numbers whose rounding a variable carries.
    sizes: Vec<f64>,
    /// What of the largest variable's rounding a variable may carry at most.
    ranges: Vec<f64>,
    /// No more than this counts as the largest.
    most: f64,
}

impl Point {
    pub(super) fn new(capacity: Capacity) -> Self {
        let Capacity { vars: n, rows: m } = capacity;
        Self {
            x: vec![0.0; padded(n)],
            values: vec![0.0; m],
            unit: vec![0.0; n],
            per_unit: vec![0.0; n],
            sizes: vec![0.0; n],
            ranges: vec![0.0; n],
            most: f64::INFINITY,
            ..Self::default()
        }
    }

    /// From here on what is left where large numbers cancel counts as rounding of a variable only if that is of its own
    /// size, or nothing in its unit: the last violations are found, whatever the size of other variables. False if
    /// nothing changes by that.
    pub(super) fn be_strict(&mut self) -> bool {
        if self.most == 1.0 {
            return false;
        }
        self.most = 1.0;
        if self.largest <= self.most {
            return false;
        }
        self.weigh();
        true
    }

    /// `|a|ᵀ` times the variables, and what rounding of the largest leaves of them: what a dependent constraint's
    /// violation is compared with, which no other choice could make smaller.
    pub(super) fn magnitude_with_rounding(&self, qp: &Qp, index: usize) -> f64 {
        let of =
            |j: usize, a: f64| a.abs() * (self.x[j].abs() + ROUNDED * self.unit[j] * self.largest);
        match index.checked_sub(self.m) {
            None => qp
                .row(index)
                .iter()
                .enumerate()
                .map(|(j, a)| of(j, *a))
                .sum(),
            Some(j) => of(j, 1.0),
        }
    }

    /// For the variables and constraints of a problem.
    #[inline(always)]
    pub(super) fn reset(&mut self, qp: &Qp) {
        (self.n, self.m) = (qp.n(), qp.m());
        self.most = f64::INFINITY;
        let per_unit = &mut self.per_unit[..self.n];
        for (j, per_unit) in per_unit.iter_mut().enumerate() {
            let h = qp.h()[j * self.n + j];
            *per_unit = if h > 0.0 { h } else { 1.0 };
        }
        let bounds = qp.lower().iter().zip(qp.upper());
        for (range, (lower, upper)) in self.ranges.iter_mut().zip(bounds) {
            *range = constraint::range(*lower, *upper);
        }
        let ranges = self.ranges.iter();
        for ((unit, range), per_unit) in self.unit.iter_mut().zip(ranges).zip(per_unit) {
            *per_unit = per_unit.sqrt();
            let curved = 1.0 / *per_unit;
            *unit = if *range < curved { *range } else { curved };
        }
    }

    /// The variables, padded.
    #[inline(always)]
    pub(super) fn x(&self) -> &[f64] {
        &self.x[..padded(self.n)]
    }

    /// The variables to fill, padded; [`Point::evaluate`] comes next.
    #[inline(always)]
    pub(super) fn x_mut(&mut self) -> &mut [f64] {
        &mut self.x[..padded(self.n)]
    }

    /// Unit of each variable.
    #[inline(always)]
    pub(super) fn unit(&self) -> &[f64] {
        &self.unit[..self.n]
    }

    /// The largest variable, each in its unit.
    #[inline(always)]
    pub(super) fn largest(&self) -> f64 {
        self.largest
    }

    /// Computes the values of all constraints.
    #[inline(always)]
    pub(super) fn evaluate(&mut self, qp: &Qp) {
        match self.n {
            // Loops of a length that the compiler knows.
            8 => self.multiply_rows(qp, 8),
            12 => self.multiply_rows(qp, 12),
            16 => self.multiply_rows(qp, 16),
            n => self.multiply_rows(qp, n),
        }
        let x = &self.x[..self.n];
        self.largest = largest_product(x, &self.per_unit);
        if self.largest < SMALL {
            // Constraints may hold everything at zero: what pulls at them is left to compare with.
            let pull = largest_product(qp.g(), &self.unit);
            self.largest = self.largest.max(PULL * pull);
        }
        self.weigh();
    }

    #[expect(
        clippy::inline_always,
        reason = "the number of variables is to be known"
    )]
    #[inline(always)]
    fn multiply_rows(&mut self, qp: &Qp, n: usize) {
        let x = &self.x[..n];
        let blocks = qp.a().chunks(LANES * n);
        for (rows, values) in blocks.zip(self.values[..self.m].chunks_mut(LANES)) {
            if values.len() == LANES {
                let row = |i: usize| &rows[i * n..(i + 1) * n];
                values.copy_from_slice(&dots_of([row(0), row(1), row(2), row(3)], x));
            } else {
                for (row, value) in rows.chunks_exact(n).zip(values) {
                    *value = dot(row, x);
                }
            }
        }
    }

    /// Computes the sizes of the numbers whose rounding the variables carry.
    #[inline(always)]
    fn weigh(&mut self) {
        let (x, left) = (&self.x[..self.n], LEFT * self.largest.min(self.most));
        let kept = self.unit.iter().zip(&self.ranges);
        for (size, (x, (unit, range))) in self.sizes.iter_mut().zip(x.iter().zip(kept)) {
            let rounding = unit * left;
            *size = x.abs() + if rounding > *range { *range } else { rounding };
        }
    }

    /// `aᵀ x` of one constraint.
    #[inline(always)]
    pub(super) fn value(&self, index: usize) -> f64 {
        match index.checked_sub(self.m) {
            None => self.values[index],
            Some(j) => self.x[j],
        }
    }

    /// `aᵀ x` of all rows.
    #[inline(always)]
    pub(super) fn row_values(&self) -> &[f64] {
        &self.values[..self.m]
    }

    /// The size of the numbers whose rounding a value carries: `|a|ᵀ` times those of the variables.
    #[inline(always)]
    pub(super) fn magnitude(&self, qp: &Qp, index: usize) -> f64 {
        match index.checked_sub(self.m) {
            None => dot_magnitudes(qp.row(index), &self.sizes),
            Some(j) => self.sizes[j],
        }
    }
}
