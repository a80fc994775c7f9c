//! A symmetric indefinite system, factorised once and solved for many right-hand sides, in storage made once.
//!
//! # Mathematics
//! ```text
//! [ D   Aᵀ ] [ x ]   [ r ]
//! [ A  −C  ] [ y ] = [ s ]
//! ```
//! is scaled from both sides until the largest number of each row is about one (D. Ruiz, *A scaling algorithm to
//! equilibrate both rows and columns norms in matrices*, 2001), and factorised by Gaussian elimination with row
//! pivoting. Rows of A may depend on one another, as those of a foot with four points that must not move: their `−C` is
//! `−δ` in the factors, and what that changes is taken back by iterative refinement against the system itself.

use crate::problem::dot;

/// δ, of the scaled system.
const SOFTENED: f64 = 1e-10;
/// Sweeps of the scaling.
const SCALINGS: usize = 6;
/// Sweeps of refinement at most; a sweep that changes less than this share of the solution is the last.
const REFINEMENTS: usize = 4;
const ACCURATE: f64 = 1e-12;

/// The system, its factors, and room for a solution.
#[derive(Clone, Debug)]
pub(super) struct Factor {
    size: usize,
    /// The system as it is, row-major.
    system: Vec<f64>,
    factors: Vec<f64>,
    pivots: Vec<usize>,
    scale: Vec<f64>,
    residual: Vec<f64>,
    solution: Vec<f64>,
}

impl Factor {
    /// Room for so many unknowns.
    pub(super) fn new(capacity: usize) -> Self {
        let numbers = capacity * capacity;
        Self {
            size: 0,
            system: vec![0.0; numbers],
            factors: vec![0.0; numbers],
            pivots: vec![0; capacity],
            scale: vec![0.0; capacity],
            residual: vec![0.0; capacity],
            solution: vec![0.0; capacity],
        }
    }

    /// A system of so many unknowns, all zero; false if there is no room.
    pub(super) fn reset(&mut self, size: usize) -> bool {
        if size > self.pivots.len() {
            return false;
        }
        self.size = size;
        self.system[..size * size].fill(0.0);
        true
    }

    /// Writes a number, and its mirror image.
    pub(super) fn set(&mut self, i: usize, j: usize, value: f64) {
        self.system[i * self.size + j] = value;
        self.system[j * self.size + i] = value;
    }

    /// Factorises; `first` unknowns are x, the others y. False if that cannot be done.
    pub(super) fn factorise(&mut self, first: usize) -> bool {
        let n = self.size;
        self.equilibrate();
        let (scale, factors) = (&self.scale[..n], &mut self.factors[..n * n]);
        for (i, row) in factors.chunks_exact_mut(n.max(1)).enumerate() {
            let system = &self.system[i * n..(i + 1) * n];
            for ((out, a), s) in row.iter_mut().zip(system).zip(scale) {
                *out = a * scale[i] * s;
            }
            if i >= first && row[i] == 0.0 {
                row[i] = -SOFTENED;
            }
        }
        for step in 0..n {
            let size = |row: usize| factors[row * n + step].abs();
            let mut best = step;
            for row in step + 1..n {
                if size(row) > size(best) {
                    best = row;
                }
            }
            // Not `size == 0`: a NaN must fail too.
            let regular = size(best) > f64::MIN_POSITIVE;
            if !regular {
                return false;
            }
            self.pivots[step] = best;
            let (above, below) = factors.split_at_mut((step + 1) * n);
            let pivot_row = &mut above[step * n..];
            if best > step {
                let at = (best - step - 1) * n;
                pivot_row.swap_with_slice(&mut below[at..at + n]);
            }
            let reciprocal = 1.0 / pivot_row[step];
            for row in below.chunks_exact_mut(n) {
                if row[step] == 0.0 {
                    continue;
                }
                let factor = row[step] * reciprocal;
                row[step] = factor;
                for (a, pivot) in row[step + 1..].iter_mut().zip(&pivot_row[step + 1..]) {
                    *a -= factor * pivot;
                }
            }
        }
        factors.iter().all(|a| a.is_finite())
    }

    fn equilibrate(&mut self) {
        let n = self.size;
        self.scale[..n].fill(1.0);
        for _ in 0..SCALINGS {
            for i in 0..n {
                let row = &self.system[i * n..(i + 1) * n];
                let each = row.iter().zip(&self.scale);
                let largest = each.map(|(a, s)| (a * s).abs()).fold(0.0, f64::max);
                // In `residual`, until all rows are measured.
                self.residual[i] = largest * self.scale[i];
            }
            for (s, largest) in self.scale[..n].iter_mut().zip(&self.residual) {
                if *largest > 0.0 {
                    *s /= largest.sqrt();
                }
            }
        }
    }

    /// Replaces a right-hand side by the solution.
    pub(super) fn solve(&mut self, rhs: &mut [f64]) {
        let n = self.size;
        self.solution[..n].fill(0.0);
        for sweep in 0..=REFINEMENTS {
            self.residual[..n].copy_from_slice(&rhs[..n]);
            if sweep > 0 {
                for i in 0..n {
                    let row = &self.system[i * n..(i + 1) * n];
                    self.residual[i] -= dot(row, &self.solution[..n]);
                }
            }
            for (r, s) in self.residual[..n].iter_mut().zip(&self.scale) {
                *r *= s;
            }
            self.substitute();
            let mut change = 0.0_f64;
            let mut largest = 0.0_f64;
            for i in 0..n {
                let correction = self.residual[i];
                self.solution[i] += correction * self.scale[i];
                change = change.max(correction.abs());
                largest = largest.max((self.solution[i] / self.scale[i]).abs());
            }
            if change <= ACCURATE * largest {
                break;
            }
        }
        rhs[..n].copy_from_slice(&self.solution[..n]);
    }

    /// Replaces the residual by what the factors make of it.
    fn substitute(&mut self) {
        let n = self.size;
        let r = &mut self.residual[..n];
        for step in 0..n {
            r.swap(step, self.pivots[step]);
        }
        for i in 0..n {
            let row = &self.factors[i * n..i * n + i];
            r[i] -= dot(row, &r[..i]);
        }
        for i in (0..n).rev() {
            let row = &self.factors[i * n + i..(i + 1) * n];
            r[i] = (r[i] - dot(&row[1..], &r[i + 1..])) / row[0];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Factor;

    /// `min ½ |x|²` with `x₀ + x₁ = 2`, said so many times.
    fn nearest(times: usize) -> Vec<f64> {
        let mut factor = Factor::new(2 + times);
        assert!(factor.reset(2 + times));
        factor.set(0, 0, 1.0);
        factor.set(1, 1, 1.0);
        let mut rhs = vec![0.0; 2 + times];
        for (row, rhs) in rhs.iter_mut().enumerate().skip(2) {
            factor.set(row, 0, 1.0);
            factor.set(row, 1, 1.0);
            *rhs = 2.0;
        }
        assert!(factor.factorise(2));
        factor.solve(&mut rhs);
        rhs
    }

    #[test]
    fn rows_that_depend_on_one_another_do_no_harm() {
        for times in 1..4 {
            let solution = nearest(times);
            for x in &solution[..2] {
                assert!((x - 1.0).abs() < 1e-12, "{times}: {solution:?}");
            }
        }
    }

    #[test]
    fn stiff_and_weak_rows_go_together() {
        // Two rows of a cost, weights 1e6 and 1e-6: [x0 = 1], [x0 + x1 = 3].
        let mut factor = Factor::new(4);
        assert!(factor.reset(4));
        let compliance = |w: f64| -1.0 / (2.0 * w);
        factor.set(2, 0, 1.0);
        factor.set(2, 2, compliance(1e6));
        factor.set(3, 0, 1.0);
        factor.set(3, 1, 1.0);
        factor.set(3, 3, compliance(1e-6));
        let mut rhs = [0.0, 0.0, 1.0, 3.0];
        assert!(factor.factorise(2));
        factor.solve(&mut rhs);
        assert!((rhs[0] - 1.0).abs() < 1e-12 && (rhs[1] - 2.0).abs() < 1e-12);
    }

    #[test]
    fn what_cannot_be_solved_is_refused() {
        let mut factor = Factor::new(2);
        assert!(!factor.reset(3));
        assert!(factor.reset(2));
        factor.set(0, 0, 1.0);
        assert!(!factor.factorise(2), "nothing says what x1 is");
    }
}
