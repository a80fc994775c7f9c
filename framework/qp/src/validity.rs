//! Whether a problem makes sense at all.

#![allow(
    clippy::inline_always,
    reason = "what is inlined has the vector instructions of where it is called"
)]

use std::array::from_fn;

use crate::{Defect, Qp};

/// How much two entries of H that should be equal may differ, relative to `√(h_ii h_jj)`.
const ASYMMETRY: f64 = 1e-9;

impl Qp {
    /// The first entry that makes the problem meaningless: a number that is not finite, limits that are no interval, an
    /// H that is not symmetric or has a negative diagonal entry. Crossed limits are not meaningless but infeasible.
    pub fn defect(&self) -> Option<Defect> {
        self.first_defect()
    }

    /// The same, inlined.
    #[inline(always)]
    pub(crate) fn first_defect(&self) -> Option<Defect> {
        // Not `or_else`, whose closures would not be inlined.
        let mut defect = self.hessian_defect();
        if defect.is_none() {
            defect = self.gradient_defect();
        }
        if defect.is_none() {
            defect = self.row_defect();
        }
        if defect.is_none() {
            defect = self.limit_defect();
        }
        defect
    }

    #[inline(always)]
    fn hessian_defect(&self) -> Option<Defect> {
        let (n, h) = (self.n(), self.h());
        let is_sound = match n {
            // Loops of a length that the compiler knows.
            8 => is_nearly_symmetric(h, 8),
            12 => is_nearly_symmetric(h, 12),
            16 => is_nearly_symmetric(h, 16),
            n => is_nearly_symmetric(h, n),
        };
        if is_sound {
            return None;
        }
        if let Some(at) = first_not_finite(h) {
            return Some(Defect::Hessian {
                row: at / n,
                column: at % n,
            });
        }
        let negative = (0..n).find(|j| h[j * n + j] < 0.0);
        negative
            .map(|variable| Defect::Indefinite { variable })
            .or_else(|| self.asymmetry())
    }

    fn asymmetry(&self) -> Option<Defect> {
        let (n, h) = (self.n(), self.h());
        let root = |j: usize| h[j * n + j].sqrt();
        let differs = |row: usize, column: usize| {
            let difference = (h[row * n + column] - h[column * n + row]).abs();
            difference > ASYMMETRY * root(row) * root(column)
        };
        let pairs = (0..n).flat_map(|row| (0..row).map(move |column| (row, column)));
        let mut asymmetric = pairs.filter(|&(row, column)| differs(row, column));
        asymmetric
            .next()
            .map(|(row, column)| Defect::Asymmetric { row, column })
    }

    #[inline(always)]
    fn gradient_defect(&self) -> Option<Defect> {
        first_not_finite(self.g()).map(|variable| Defect::Gradient { variable })
    }

    #[inline(always)]
    fn row_defect(&self) -> Option<Defect> {
        let n = self.n();
        first_not_finite(self.a()).map(|at| Defect::Coefficient {
            row: at / n,
            variable: at % n,
        })
    }

    #[inline(always)]
    fn limit_defect(&self) -> Option<Defect> {
        if let Some(row) = first_not_interval(self.row_lower(), self.row_upper()) {
            return Some(Defect::RowLimit { row });
        }
        let bound = first_not_interval(self.lower(), self.upper());
        bound.map(|variable| Defect::Bound { variable })
    }
}

/// Whether all entries are finite, none on the diagonal is negative, and the sum of differences is allowed beside
/// the smallest on the diagonal, for which no root is needed, and nothing to decide on the way; by blocks of four rows
/// and columns. False may be a mistake.
#[inline(always)]
fn is_nearly_symmetric(h: &[f64], n: usize) -> bool {
    let h = &h[..n * n];
    let block = |row: usize, column: usize| -> [[f64; 4]; 4] {
        from_fn(|i| {
            let left = &h[(row + i) * n + column..][..4];
            [left[0], left[1], left[2], left[3]]
        })
    };
    let mut differences = [0.0; 4];
    let (mut smallest, mut trace) = (f64::INFINITY, 0.0);
    for row in 0..n {
        let diagonal = h[row * n + row];
        trace += diagonal;
        smallest = if diagonal < smallest {
            diagonal
        } else {
            smallest
        };
    }
    let whole = n - n % 4;
    for row in (0..whole).step_by(4) {
        for column in (0..row).step_by(4) {
            let (left, above) = (block(row, column), block(column, row));
            for (i, left) in left.iter().enumerate() {
                for ((sum, left), above) in differences.iter_mut().zip(left).zip(&above) {
                    *sum += (left - above[i]).abs();
                }
            }
        }
        let own = block(row, row);
        for (i, left) in own.iter().enumerate() {
            for (j, above) in own.iter().enumerate().take(i) {
                differences[j] += (left[j] - above[i]).abs();
            }
        }
    }
    for row in whole..n {
        for (column, left) in h[row * n..row * n + row].iter().enumerate() {
            differences[column % 4] += (left - h[column * n + row]).abs();
        }
    }
    // A number that is not finite leaves neither sum.
    let differences = differences.into_iter().sum::<f64>();
    smallest >= 0.0 && differences <= ASYMMETRY * smallest && trace < f64::INFINITY
}

/// The first number that is not finite.
#[inline(always)]
pub(crate) fn first_not_finite(a: &[f64]) -> Option<usize> {
    // A number that is not finite never leaves a sum: eight side by side, and nothing to decide on the way. One that
    // overflows is looked at again.
    let (blocks, rest) = a.as_chunks::<8>();
    let mut sums = [0.0; 8];
    for block in blocks {
        for (sum, a) in sums.iter_mut().zip(block) {
            *sum += a;
        }
    }
    if sums.iter().chain(rest).sum::<f64>().is_finite() {
        return None;
    }
    a.iter().position(|a| !a.is_finite())
}

#[inline(always)]
fn first_not_interval(lower: &[f64], upper: &[f64]) -> Option<usize> {
    // `!(… < …)`: NaN is no limit.
    let is_interval = |lower: f64, upper: f64| lower < f64::INFINITY && upper > f64::NEG_INFINITY;
    let is_none = |(lower, upper): (&f64, &f64)| !is_interval(*lower, *upper);
    // All of them first, four at a time, without deciding on the way.
    let ((lowers, lower_rest), (uppers, upper_rest)) =
        (lower.as_chunks::<4>(), upper.as_chunks::<4>());
    let mut are = [true; 4];
    for (lower, upper) in lowers.iter().zip(uppers) {
        are = from_fn(|i| are[i] & is_interval(lower[i], upper[i]));
    }
    let any = are != [true; 4] || lower_rest.iter().zip(upper_rest).any(is_none);
    if any {
        lower.iter().zip(upper).position(is_none)
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use crate::{Defect, Qp};

    /// What is wrong with a problem that has this H and nothing else.
    fn defect(h: &[f64], n: usize) -> Option<Defect> {
        let free = (vec![f64::NEG_INFINITY; n], vec![f64::INFINITY; n]);
        let qp = Qp::dense(h, &vec![0.0; n], &[], (&[], &[]), (&free.0, &free.1));
        qp.expect("the shapes fit").defect()
    }

    /// Whichever block or rest it is in.
    #[test]
    fn every_entry_of_h_is_looked_at() {
        for n in 1..=18 {
            let mut h = vec![0.1; n * n];
            (0..n).for_each(|i| h[i * n + i] = 2.0);
            assert_eq!(defect(&h, n), None);
            for at in 0..n * n {
                let (row, column) = (at / n, at % n);
                let sound = h[at];
                h[at] = f64::NAN;
                assert_eq!(defect(&h, n), Some(Defect::Hessian { row, column }));
                h[at] = if row == column { -1.0 } else { 0.2 };
                let expected = if row == column {
                    Defect::Indefinite { variable: row }
                } else {
                    let (row, column) = (row.max(column), row.min(column));
                    Defect::Asymmetric { row, column }
                };
                assert_eq!(defect(&h, n), Some(expected), "{n}: {row} {column}");
                h[at] = sound;
            }
        }
    }
}
