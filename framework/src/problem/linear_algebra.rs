//! The factorisation of the mass matrix, and inner loops over rows that lie in one piece: in place and without
//! allocation. The order of all sums is fixed by the code: results do not depend on how wide the machine's vectors are.
//!
//! # Mathematics
//! `M = Lᵀ D L` with L unit lower triangular, from the last row to the first: the leaves of the tree go first, so that
//! L is zero where M is (R. Featherstone, *Rigid Body Dynamics Algorithms*, section 6.5, table 6.3). Row `i` of L has
//! entries in the columns of `i` and of its ancestors only, and nothing else is ever touched.

#![allow(
    clippy::inline_always,
    reason = "rows are short: coefficients that go through memory take longer than the sum"
)]

use std::ops::Range;

/// `Lᵀ D L` of a matrix with a tree's sparsity, in storage that is reused every tick. Row-major, strict lower triangle
/// valid.
#[derive(Clone, Debug)]
pub(crate) struct TreeCholesky {
    pub(super) n: usize,
    pub(super) l: Vec<f64>,
    /// `D⁻¹`.
    pub(super) reciprocal: Vec<f64>,
    /// Nearest first.
    pub(super) ancestors: Vec<Vec<usize>>,
    /// Whose ancestor each one is.
    pub(super) descendants: Vec<Vec<usize>>,
}

impl TreeCholesky {
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
            // All that come before lie in one piece.
            let is_chain = ancestors.len() == k;
            for (depth, &i) in ancestors.iter().enumerate() {
                let factor = row[i] * reciprocal;
                let target = &mut above[i * n..(i + 1) * n];
                if is_chain {
                    add_row(&mut target[..=i], -factor, row);
                    continue;
                }
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

/// `y += a x` over the length of y.
pub(super) fn add_row(y: &mut [f64], a: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += a * x;
    }
}

/// `y += Σ a_k x_k` over the length of y; the rows `x_k` must not be shorter.
#[inline(always)]
pub(super) fn add_two_rows(y: &mut [f64], a: [f64; 2], x: [&[f64]; 2]) {
    let n = y.len();
    let [p, q] = x.map(|x| &x[..n]);
    for ((y, p), q) in y.iter_mut().zip(p).zip(q) {
        *y = *y + a[0] * p + a[1] * q;
    }
}

/// Like [`add_two_rows`], of four rows.
#[inline(always)]
pub(super) fn add_four_rows(y: &mut [f64], a: [f64; 4], x: [&[f64]; 4]) {
    let n = y.len();
    let [p, q, r, s] = x.map(|x| &x[..n]);
    for ((((y, p), q), r), s) in y.iter_mut().zip(p).zip(q).zip(r).zip(s) {
        *y = *y + a[0] * p + a[1] * q + a[2] * r + a[3] * s;
    }
}

/// Like [`add_two_rows`], of six rows.
#[inline(always)]
pub(super) fn add_six_rows(y: &mut [f64], a: [f64; 6], x: [&[f64]; 6]) {
    let n = y.len();
    let [p, q, r, s, t, u] = x.map(|x| &x[..n]);
    let rows = p.iter().zip(q).zip(r).zip(s).zip(t).zip(u);
    for (y, (((((p, q), r), s), t), u)) in y.iter_mut().zip(rows) {
        let (first, second) = (a[0] * p + a[1] * q, a[2] * r + a[3] * s);
        *y += (first + second) + (a[4] * t + a[5] * u);
    }
}

/// `y += Σ_k a_k x_k` over the length of y for the rows `x_k` of a matrix with a row stride.
pub(super) fn add_matrix_rows(y: &mut [f64], coefficients: &[f64], matrix: &[f64], stride: usize) {
    let row = |k: usize| &matrix[k * stride..(k + 1) * stride];
    // Six first: a floating base.
    let (sixes, rest) = coefficients.as_chunks::<6>();
    let (pairs, last) = rest.as_chunks::<2>();
    let mut k = 0;
    for &a in sixes {
        if a != [0.0; 6] {
            add_six_rows(y, a, std::array::from_fn(|i| row(k + i)));
        }
        k += 6;
    }
    for &a in pairs {
        if a != [0.0; 2] {
            add_two_rows(y, a, [row(k), row(k + 1)]);
        }
        k += 2;
    }
    for &a in last {
        if a != 0.0 {
            add_row(y, a, row(k));
        }
        k += 1;
    }
}

/// The row of the largest size, the first of several.
pub(super) fn largest(rows: Range<usize>, size: impl Fn(usize) -> f64) -> usize {
    let larger = |best, row| if size(row) > size(best) { row } else { best };
    rows.clone().fold(rows.start, larger)
}

/// `aᵀ b` over the shorter length.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().min(b.len());
    let (a, b) = (a[..n].as_chunks::<4>(), b[..n].as_chunks::<4>());
    let mut sums = [0.0; 4];
    for (a, b) in a.0.iter().zip(b.0) {
        for l in 0..4 {
            sums[l] += a[l] * b[l];
        }
    }
    let mut sum = (sums[0] + sums[2]) + (sums[1] + sums[3]);
    for (a, b) in a.1.iter().zip(b.1) {
        sum += a * b;
    }
    sum
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
