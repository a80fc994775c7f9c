//! Factorisation of the mass matrix, in place and without allocation.
//!
//! # Mathematics
//! `M = Lᵀ D L` with L unit lower triangular, from the last row to the first: the leaves of the tree go first, so that
//! L is zero where M is (R. Featherstone, *Rigid Body Dynamics Algorithms*, section 6.5, table 6.3). Row `i` of L has
//! entries in the columns of `i` and of its ancestors only, and nothing else is ever touched.

use super::kernels::{add_four_rows, add_row, add_two_rows};

/// `Lᵀ D L` of a matrix with a tree's sparsity, in storage that is reused every tick. Row-major, strict lower triangle
/// valid.
#[derive(Clone, Debug)]
pub(crate) struct TreeCholesky {
    n: usize,
    l: Vec<f64>,
    /// `D⁻¹`.
    reciprocal: Vec<f64>,
    /// Nearest first.
    ancestors: Vec<Vec<usize>>,
    /// Whose ancestor each one is.
    descendants: Vec<Vec<usize>>,
}

impl TreeCholesky {
    /// For a matrix whose entry `(i, j)`, `j < i`, is zero unless `j` is an ancestor of `i`.
    pub(crate) fn new(ancestors: Vec<Vec<usize>>) -> Self {
        let n = ancestors.len();
        let carries = |i: usize| (i + 1..n).filter(|&d| ancestors[d].contains(&i)).collect();
        Self {
            n,
            l: vec![0.0; n * n],
            reciprocal: vec![0.0; n],
            descendants: (0..n).map(carries).collect(),
            ancestors,
        }
    }

    /// Factorises a symmetric matrix given by its entries `(i, j)`, `j ≤ i`; false if it is not positive definite (or
    /// has a NaN).
    pub(crate) fn factorise(&mut self, m: impl Fn(usize, usize) -> f64) -> bool {
        let n = self.n;
        for (i, ancestors) in self.ancestors.iter().enumerate() {
            self.l[i * n + i] = m(i, i);
            for &j in ancestors {
                self.l[i * n + j] = m(i, j);
            }
        }
        for (k, ancestors) in self.ancestors.iter().enumerate().rev() {
            let (above, row) = self.l.split_at_mut(k * n);
            let row = &mut row[..n];
            let pivot = row[k];
            // `!(pivot > 0)` and not `pivot <= 0`: a NaN must fail too.
            let positive = pivot > 0.0;
            if !positive {
                return false;
            }
            let reciprocal = 1.0 / pivot;
            self.reciprocal[k] = reciprocal;
            for (depth, &i) in ancestors.iter().enumerate() {
                let factor = row[i] * reciprocal;
                let target = &mut above[i * n..(i + 1) * n];
                for &j in &ancestors[depth..] {
                    target[j] -= factor * row[j];
                }
            }
            for &i in ancestors {
                row[i] *= reciprocal;
            }
        }
        true
    }

    /// Replaces the row-major matrix `x` of row stride `stride` by `M⁻¹ x`.
    ///
    /// Works on whole rows, so that the inner loops run along contiguous memory.
    pub(crate) fn solve_rows(&self, x: &mut [f64], stride: usize) {
        let n = self.n;
        for (i, descendants) in self.descendants.iter().enumerate().rev() {
            let (row, below) = x[i * stride..].split_at_mut(stride);
            let source = |d: usize| &below[(d - i - 1) * stride..(d - i) * stride];
            subtract(row, descendants, |d| self.l[d * n + i], source);
        }
        for (i, ancestors) in self.ancestors.iter().enumerate() {
            let (above, row) = x.split_at_mut(i * stride);
            let row = &mut row[..stride];
            for x in row.iter_mut() {
                *x *= self.reciprocal[i];
            }
            let source = |j: usize| &above[j * stride..(j + 1) * stride];
            let l = &self.l[i * n..(i + 1) * n];
            subtract(row, ancestors, |j| l[j], source);
        }
    }
}

/// `row −= Σ_i a_i x_i` over a list of rows.
fn subtract<'x>(
    row: &mut [f64],
    list: &[usize],
    a: impl Fn(usize) -> f64,
    x: impl Fn(usize) -> &'x [f64],
) {
    let (fours, rest) = list.as_chunks::<4>();
    let (twos, last) = rest.as_chunks::<2>();
    for i in fours {
        add_four_rows(row, i.map(|i| -a(i)), i.map(&x));
    }
    for i in twos {
        add_two_rows(row, i.map(|i| -a(i)), i.map(&x));
    }
    for &i in last {
        add_row(row, -a(i), x(i));
    }
}

#[cfg(test)]
mod tests {
    use super::TreeCholesky;
    use nalgebra::DMatrix;

    fn chain(n: usize) -> Vec<Vec<usize>> {
        (0..n).map(|i| (0..i).rev().collect()).collect()
    }

    fn check(ancestors: Vec<Vec<usize>>, m: &DMatrix<f64>) {
        let n = m.nrows();
        let mut cholesky = TreeCholesky::new(ancestors);
        assert!(cholesky.factorise(|i, j| m[(i, j)]));
        let stride = 4;
        let mut x: Vec<f64> = (0..n * stride).map(|i| (i as f64).cos()).collect();
        let original = x.clone();
        cholesky.solve_rows(&mut x, stride);
        for i in 0..n {
            for c in 0..stride {
                let back: f64 = (0..n).map(|k| m[(i, k)] * x[k * stride + c]).sum();
                assert!((back - original[i * stride + c]).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn solves_several_right_hand_sides_in_rows() {
        let a = DMatrix::from_fn(5, 5, |i, j| ((3 * i + 7 * j) as f64).sin());
        check(chain(5), &(&a * a.transpose() + DMatrix::identity(5, 5)));
    }

    #[test]
    fn solves_with_the_sparsity_of_a_tree() {
        // 0 carries 1 and 2, 1 carries 3, 2 carries 4.
        let ancestors = vec![vec![], vec![0], vec![0], vec![1, 0], vec![2, 0]];
        let mut m = DMatrix::identity(5, 5) * 4.0;
        for (i, list) in ancestors.iter().enumerate() {
            for &j in list {
                m[(i, j)] = ((i + 3 * j) as f64).sin();
                m[(j, i)] = m[(i, j)];
            }
        }
        check(ancestors, &m);
    }

    #[test]
    fn refuses_indefinite_and_nan() {
        let mut cholesky = TreeCholesky::new(chain(2));
        assert!(!cholesky.factorise(|i, j| if i == j { 1.0 } else { 2.0 }));
        assert!(!cholesky.factorise(|_, _| f64::NAN));
    }
}
