//! An upper triangle that grows and shrinks by columns: `Wᵀ W = Rᵀ R`.

use super::{
    kernels::{LANES, add_rows, axpy, dot, dots, padded},
    simd::{Simd, with_simd},
};

/// R, in storage made once.
#[derive(Clone, Debug, Default)]
pub(super) struct Triangle {
    /// From one row of the storage to the next.
    stride: usize,
    /// Row k holds column k of R: k + 1 entries.
    r: Vec<f64>,
    /// `1/R_kk`, of so many columns as there are.
    reciprocal: Vec<f64>,
}

impl Triangle {
    /// For at most `n` columns.
    pub(super) fn new(n: usize) -> Self {
        Self {
            stride: padded(n),
            r: vec![0.0; padded(n) * n],
            reciprocal: Vec::with_capacity(n),
        }
    }

    /// Columns.
    pub(super) fn len(&self) -> usize {
        self.reciprocal.len()
    }

    /// No columns, of at most `n`.
    pub(super) fn reset(&mut self, n: usize) {
        self.stride = padded(n);
        self.reciprocal.clear();
    }

    /// Appends a column; its last entry is on the diagonal.
    #[inline(always)]
    pub(super) fn append(&mut self, column: &[f64]) {
        let k = self.reciprocal.len();
        let at = k * self.stride;
        self.r[at..=at + k].copy_from_slice(&column[..=k]);
        self.reciprocal.push(1.0 / column[k]);
    }

    /// Takes the j-th column out. What is left is made triangular again by rotations of neighbouring rows, each the
    /// one that makes the second of a pair `(a, b)` zero: `rotation` gives `(c, s, r)` with `c a + s b = r`. They act
    /// on `other` as well.
    pub(super) fn remove(
        &mut self,
        j: usize,
        other: &mut [f64],
        mut rotation: impl FnMut(f64, f64) -> (f64, f64, f64),
    ) {
        let n = self.stride;
        self.reciprocal.pop();
        let k = self.reciprocal.len();
        for i in j..k {
            let from = (i + 1) * n;
            self.r.copy_within(from..from + i + 2, i * n);
        }
        for i in j..k {
            let at = i * n + i;
            let (c, s, r) = rotation(self.r[at], self.r[at + 1]);
            self.r[at] = r;
            self.reciprocal[i] = 1.0 / r;
            for row in self.r[(i + 1) * n..k * n].chunks_exact_mut(n) {
                (row[i], row[i + 1]) = (c * row[i] + s * row[i + 1], c * row[i + 1] - s * row[i]);
            }
            let v = &mut *other;
            (v[i], v[i + 1]) = (c * v[i] + s * v[i + 1], c * v[i + 1] - s * v[i]);
        }
    }

    /// [`Triangle::solve`] in vectors, as a call of its own.
    pub(super) fn solve_in(&self, simd: Simd, t: &mut [f64]) {
        with_simd!(simd, self.solve(t));
    }

    /// [`Triangle::solve_transposed`] in vectors, as a call of its own.
    pub(super) fn solve_transposed_in(&self, simd: Simd, known: usize, z: &mut [f64]) {
        with_simd!(simd, self.solve_transposed(known, z));
    }

    /// `t ← R⁻¹ t`.
    #[inline(always)]
    pub(super) fn solve(&self, t: &mut [f64]) {
        let (r, stride) = (&self.r, self.stride);
        let k = self.reciprocal.len();
        let whole = k - k % LANES;
        for i in (whole..k).rev() {
            let (head, tail) = t.split_at_mut(i);
            tail[0] *= self.reciprocal[i];
            axpy(head, -tail[0], &r[i * stride..i * stride + i]);
        }
        for first in (0..whole).step_by(LANES).rev() {
            let (head, t) = t.split_at_mut(first);
            let at = first * stride;
            let [_, r1, r2, r3] = [0, 1, 2, 3].map(|i| &r[at + i * stride + first..][..LANES]);
            let by = &self.reciprocal[first..first + LANES];
            let t = &mut t[..LANES];
            t[3] *= by[3];
            t[2] = (t[2] - r3[2] * t[3]) * by[2];
            t[1] = ((t[1] - r3[1] * t[3]) - r2[1] * t[2]) * by[1];
            t[0] = (((t[0] - r3[0] * t[3]) - r2[0] * t[2]) - r1[0] * t[1]) * by[0];
            let alpha = [-t[0], -t[1], -t[2], -t[3]];
            add_rows(head, alpha, &r[at..], stride);
        }
    }

    /// Solves `Rᵀ z = b`: replaces `z`, which holds b from `known` on and the solution before that.
    #[inline(always)]
    pub(super) fn solve_transposed(&self, known: usize, z: &mut [f64]) {
        let (rows, stride, k) = (&self.r, self.stride, self.reciprocal.len());
        let mut i = known;
        while i < k {
            let at = i * stride;
            let (head, tail) = z.split_at_mut(i);
            if i.is_multiple_of(LANES) && i + LANES <= k {
                let sums = dots(&rows[at..], stride, head);
                let [_, r1, r2, r3] = [0, 1, 2, 3].map(|p| &rows[at + p * stride + i..][..LANES]);
                let by = &self.reciprocal[i..i + LANES];
                let z = &mut tail[..LANES];
                z[0] = (z[0] - sums[0]) * by[0];
                z[1] = (z[1] - (sums[1] + r1[0] * z[0])) * by[1];
                z[2] = (z[2] - (sums[2] + (r2[0] * z[0] + r2[1] * z[1]))) * by[2];
                z[3] = (z[3] - (sums[3] + ((r3[0] * z[0] + r3[1] * z[1]) + r3[2] * z[2]))) * by[3];
                i += LANES;
            } else {
                tail[0] = (tail[0] - dot(&rows[at..at + i], head)) * self.reciprocal[i];
                i += 1;
            }
        }
    }

    /// `y += Σ_k α_k R_k`, of its columns.
    pub(super) fn add_columns(&self, alpha: impl Iterator<Item = f64>, y: &mut [f64]) {
        for (i, alpha) in alpha.enumerate() {
            let at = i * self.stride;
            axpy(&mut y[..=i], alpha, &self.r[at..=at + i]);
        }
    }
}

/// The rotation that makes the second of `(a, b)` zero: `(c, s, r)` with `c a + s b = r`.
pub(super) fn rotation(a: f64, b: f64) -> (f64, f64, f64) {
    let r = (a * a + b * b).sqrt();
    let (c, s) = if r > 0.0 { (a / r, b / r) } else { (1.0, 0.0) };
    (c, s, r)
}
