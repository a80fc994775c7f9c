//! Whether a problem makes sense at all.

use crate::{Defect, Qp};

/// How much two entries of H that should be equal may differ, relative to `√(h_ii h_jj)`.
const ASYMMETRY: f64 = 1e-9;

impl Qp {
    /// The first entry that makes the problem meaningless: a number that is not finite, limits that are no interval, an H that
    /// is not symmetric or has a negative diagonal entry. Crossed limits are not meaningless but infeasible.
    pub fn defect(&self) -> Option<Defect> {
        self.hessian_defect()
            .or_else(|| self.gradient_defect())
            .or_else(|| self.row_defect())
            .or_else(|| self.limit_defect())
    }

    fn hessian_defect(&self) -> Option<Defect> {
        let (n, h) = (self.n(), self.h());
        if let Some(at) = first_not_finite(h) {
            return Some(Defect::Hessian {
                row: at / n,
                column: at % n,
            });
        }
        for row in 0..n {
            let diagonal = h[row * n + row];
            if diagonal < 0.0 {
                return Some(Defect::Indefinite { variable: row });
            }
            for column in 0..row {
                let difference = (h[row * n + column] - h[column * n + row]).abs();
                // Seldom: the square root is not worth its time where the entries are equal.
                if difference > 0.0
                    && difference > ASYMMETRY * diagonal.sqrt() * h[column * n + column].sqrt()
                {
                    return Some(Defect::Asymmetric { row, column });
                }
            }
        }
        None
    }

    fn gradient_defect(&self) -> Option<Defect> {
        first_not_finite(self.g()).map(|variable| Defect::Gradient { variable })
    }

    fn row_defect(&self) -> Option<Defect> {
        let n = self.n();
        first_not_finite(self.a()).map(|at| Defect::Coefficient {
            row: at / n,
            variable: at % n,
        })
    }

    fn limit_defect(&self) -> Option<Defect> {
        let row = first_not_interval(self.row_lower(), self.row_upper());
        let bound = || first_not_interval(self.lower(), self.upper());
        row.map(|row| Defect::RowLimit { row })
            .or_else(|| bound().map(|variable| Defect::Bound { variable }))
    }
}

fn first_not_finite(a: &[f64]) -> Option<usize> {
    // Zero times anything finite is zero: eight sums side by side, and nothing to decide on the way.
    let (blocks, rest) = a.as_chunks::<8>();
    let mut sums = [0.0; 8];
    for block in blocks {
        for (sum, a) in sums.iter_mut().zip(block) {
            *sum += a * 0.0;
        }
    }
    let rest = rest.iter().map(|a| a * 0.0);
    if sums.into_iter().chain(rest).sum::<f64>() == 0.0 {
        return None;
    }
    a.iter().position(|a| !a.is_finite())
}

fn first_not_interval(lower: &[f64], upper: &[f64]) -> Option<usize> {
    let mut limits = lower.iter().zip(upper);
    // `!(… < …)`: NaN is no limit.
    limits.position(|(&lower, &upper)| !(lower < f64::INFINITY && upper > f64::NEG_INFINITY))
}
