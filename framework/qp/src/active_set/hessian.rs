//! `H̃ = Uᵀ U`: the factor that turns the problem into one of least distance.
//!
//! # Mathematics
//! With `z = U x` the cost is `½ ‖z + U⁻ᵀ g‖²` up to a constant. H only has to be positive definite where the
//! equality rows leave freedom. If a pivot is as good as zero, `Σ σ_i a_iᵀ a_i` over these rows is added, with
//! `−σ_i b_i a_i` in the linear term: on the feasible set this changes neither cost nor solution nor multipliers, and the
//! accelerations of an explicit formulation, which may have no cost of their own, become definite through their dynamics.

use std::ops::Range;

use super::kernels::{LANES, add_rows, axpy, dot, dots, padded};
use crate::Qp;

/// A pivot below this part of its diagonal entry is rounding: Cholesky's own error is of the order n ε.
const WEAK: f64 = 1e-13;
/// A pivot below this part of its diagonal entry may be what rounding left of a zero.
const SUSPECT: f64 = 1e-9;

/// The factor and what was added to H to get it.
///
/// Rows go in blocks of four. Of a block, only the columns between its first and last entry other than zero are ever
/// touched: the cost of a whole-body problem falls apart into accelerations, inputs and forces.
#[derive(Clone, Debug, Default)]
pub(super) struct Hessian {
    n: usize,
    /// n with padding.
    stride: usize,
    /// Row-major. Valid from the diagonal on; what is left of it has no meaning.
    u: Vec<f64>,
    /// Per block of rows, the columns of H with entries.
    columns: Vec<(usize, usize)>,
    /// Per block of rows, where the entries of U end, in whole lanes.
    ends: Vec<usize>,
    /// Inverses of the blocks on the diagonal of U, zero in the padding: with them the entries of a block do not wait for
    /// one another.
    inverses: Vec<[[f64; LANES]; LANES]>,
    /// Diagonal of what is factorised.
    diagonal: Vec<f64>,
    /// Whether a pivot is so small that it may be what rounding left of a zero.
    has_small_pivot: bool,
    /// `−Σ σ_i b_i a_i`, if equality rows were added.
    shift: Vec<f64>,
    is_shifted: bool,
}

impl Hessian {
    pub(super) fn new(n: usize) -> Self {
        let stride = padded(n);
        Self {
            u: vec![0.0; stride * stride],
            columns: vec![(0, 0); stride / LANES],
            ends: vec![0; stride / LANES],
            inverses: vec![[[0.0; LANES]; LANES]; stride / LANES],
            diagonal: vec![0.0; n],
            shift: vec![0.0; n],
            ..Self::default()
        }
    }

    /// Factorises; false if H is not definite, or has no finite factor.
    pub(super) fn factorise(&mut self, qp: &Qp) -> bool {
        self.n = qp.n();
        self.stride = padded(self.n);
        self.is_shifted = false;
        self.load(qp);
        if self.eliminate() {
            return true;
        }
        if !has_equalities(qp) {
            return false;
        }
        self.load(qp);
        self.add_equalities(qp);
        self.eliminate()
    }

    /// Whether a pivot is so small that it may be what rounding left of a zero.
    pub(super) fn is_suspect(&self) -> bool {
        self.has_small_pivot
    }

    /// Adds to a linear term what belongs to the added equality rows.
    pub(super) fn shift(&self, g: &mut [f64]) {
        if self.is_shifted {
            axpy(g, 1.0, &self.shift);
        }
    }

    fn load(&mut self, qp: &Qp) {
        let (n, stride) = (self.n, self.stride);
        let blocks = self.columns.iter_mut().zip(&mut self.ends);
        let rows = self.u.chunks_exact_mut(LANES * stride);
        let sources = qp.h().chunks(LANES * n);
        for (b, ((rows, source), (columns, end))) in rows.zip(sources).zip(blocks).enumerate() {
            let first = b * LANES;
            let used = source.chunks_exact(n).map(|h| used(&h[first..]));
            let used = first + used.max().unwrap_or(0);
            *columns = (first, used);
            *end = padded(used).max(first + LANES);
            for row in rows.chunks_exact_mut(stride) {
                row[used..*end].fill(0.0);
            }
            for (row, h) in rows.chunks_exact_mut(stride).zip(source.chunks_exact(n)) {
                row[first..used].copy_from_slice(&h[first..used]);
            }
            for row in rows.chunks_exact_mut(stride).skip(source.len() / n) {
                row[first..*end].fill(0.0);
            }
        }
        // H is symmetric.
        for b in 1..stride / LANES {
            let reaches = |above: &(usize, usize)| above.1 > b * LANES;
            let above = self.columns[..b].iter().position(reaches);
            self.columns[b].0 = above.unwrap_or(b) * LANES;
        }
    }

    fn add_equalities(&mut self, qp: &Qp) {
        let n = self.n;
        self.shift[..n].fill(0.0);
        self.is_shifted = true;
        for i in (0..qp.m()).filter(|&i| qp.row_lower()[i] == qp.row_upper()[i]) {
            let (a, b) = (qp.row(i), qp.row_lower()[i]);
            // Of the size of a unit diagonal after Jacobi scaling.
            let mut size = 0.0;
            for (j, a) in a.iter().enumerate() {
                let h = qp.h()[j * n + j];
                size += a * a / if h > 0.0 { h } else { 1.0 };
            }
            if size <= 0.0 {
                continue;
            }
            let sigma = 1.0 / size;
            axpy(&mut self.shift[..n], -sigma * b, a);
            for (b, rows) in self.u.chunks_exact_mut(LANES * self.stride).enumerate() {
                let first = b * LANES;
                let Some(a) = a.get(first..).filter(|a| !a.is_empty()) else {
                    break;
                };
                if a.iter().take(LANES).all(|a| *a == 0.0) {
                    continue;
                }
                for (q, row) in rows.chunks_exact_mut(self.stride).enumerate() {
                    row[self.ends[b]..].fill(0.0);
                    if let Some(a_q) = a.get(q) {
                        axpy(&mut row[first..], sigma * a_q, a);
                    }
                }
                self.ends[b] = self.stride;
            }
        }
    }

    /// Right-looking Cholesky by blocks of four rows; false at the first weak pivot.
    fn eliminate(&mut self) -> bool {
        let (n, stride) = (self.n, self.stride);
        for (k, d) in self.diagonal[..n].iter_mut().enumerate() {
            *d = self.u[k * stride + k];
        }
        self.has_small_pivot = false;
        for first in (0..n).step_by(LANES) {
            if !self.eliminate_within(first) {
                return false;
            }
            let end = self.ends[first / LANES];
            let next = first + LANES;
            let (above, below) = self.u.split_at_mut(next * stride);
            let rows = &above[first * stride..];
            for (b, targets) in below.chunks_exact_mut(LANES * stride).enumerate() {
                let at = next + b * LANES;
                if at >= end {
                    break;
                }
                let factors: [_; LANES] = [
                    block(rows, at),
                    block(rows, stride + at),
                    block(rows, 2 * stride + at),
                    block(rows, 3 * stride + at),
                ];
                if factors.as_flattened().iter().all(|f| *f == 0.0) {
                    continue;
                }
                let filled = &mut self.ends[at / LANES];
                for (q, target) in targets.chunks_exact_mut(stride).enumerate() {
                    if *filled < end {
                        target[*filled..end].fill(0.0);
                    }
                    let [f0, f1, f2, f3] = factors;
                    let alpha = [-f0[q], -f1[q], -f2[q], -f3[q]];
                    add_rows(&mut target[at..end], alpha, &rows[at..], stride);
                }
                *filled = (*filled).max(end);
            }
        }
        true
    }

    /// The rows of U of one block.
    fn eliminate_within(&mut self, first: usize) -> bool {
        let stride = self.stride;
        let rows = &mut self.u[first * stride..(first + LANES) * stride];
        let mut u = [
            block(rows, first),
            block(rows, stride + first),
            block(rows, 2 * stride + first),
            block(rows, 3 * stride + first),
        ];
        let mut reciprocal = [0.0; LANES];
        for p in 0..LANES.min(self.n - first) {
            let diagonal = self.diagonal[first + p];
            // `!(pivot > …)`: a NaN is weak, too.
            let strong = u[p][p] > WEAK * diagonal;
            if !strong {
                return false;
            }
            self.has_small_pivot |= u[p][p] < SUSPECT * diagonal;
            reciprocal[p] = 1.0 / u[p][p].sqrt();
            for u in &mut u[p][p..] {
                *u *= reciprocal[p];
            }
            for i in p + 1..LANES {
                for q in i..LANES {
                    u[i][q] -= u[p][i] * u[p][q];
                }
            }
        }
        if !reciprocal.iter().all(|r| r.is_finite()) {
            return false;
        }
        let inverse = inverse_of_triangle(&u, reciprocal);
        self.inverses[first / LANES] = inverse;
        let end = self.ends[first / LANES];
        let (r0, rest) = rows.split_at_mut(stride);
        let (r1, rest) = rest.split_at_mut(stride);
        let (r2, r3) = rest.split_at_mut(stride);
        let (a, b) = (
            right_of(r0, u[0], first, end),
            right_of(r1, u[1], first, end),
        );
        let (c, d) = (
            right_of(r2, u[2], first, end),
            right_of(r3, u[3], first, end),
        );
        for (((a, b), c), d) in a.iter_mut().zip(b).zip(c).zip(d) {
            for l in 0..LANES {
                let w = transposed_product(&inverse, [a[l], b[l], c[l], d[l]]);
                [a[l], b[l], c[l], d[l]] = w;
            }
        }
        true
    }

    /// Replaces `a` by `w = U⁻ᵀ a`; returns which components of w may differ from zero, in whole lanes.
    pub(super) fn solve_transposed(&self, a: &mut [f64]) -> Range<usize> {
        let stride = self.stride;
        let mut range = stride..0;
        for (b, &end) in self.ends[..stride / LANES].iter().enumerate() {
            let first = b * LANES;
            let next = first + LANES;
            let (head, tail) = a.split_at_mut(next);
            let w = &mut head[first..];
            if w.iter().all(|w| *w == 0.0) {
                continue;
            }
            range = range.start.min(first)..range.end.max(end);
            let block = transposed_product(&self.inverses[b], [w[0], w[1], w[2], w[3]]);
            w.copy_from_slice(&block);
            let rows = &self.u[first * stride..];
            let alpha = [-block[0], -block[1], -block[2], -block[3]];
            add_rows(&mut tail[..end - next], alpha, &rows[next..], stride);
        }
        range
    }

    /// Replaces `z` by `x = U⁻¹ z`.
    pub(super) fn solve(&self, z: &mut [f64]) {
        let stride = self.stride;
        for (b, &end) in self.ends[..stride / LANES].iter().enumerate().rev() {
            let first = b * LANES;
            let next = first + LANES;
            let (head, tail) = z.split_at_mut(next);
            let rows = &self.u[first * stride..];
            let known = dots(&rows[next..], stride, &tail[..end - next]);
            let x = &mut head[first..];
            let [b0, b1, b2, b3] = [
                x[0] - known[0],
                x[1] - known[1],
                x[2] - known[2],
                x[3] - known[3],
            ];
            let [i0, i1, i2, i3] = &self.inverses[b];
            x[0] = (i0[0] * b0 + i0[1] * b1) + (i0[2] * b2 + i0[3] * b3);
            x[1] = i1[1] * b1 + (i1[2] * b2 + i1[3] * b3);
            x[2] = i2[2] * b2 + i2[3] * b3;
            x[3] = i3[3] * b3;
        }
    }

    /// `z = U x`.
    pub(super) fn multiply(&self, x: &[f64], z: &mut [f64]) {
        let (n, stride) = (self.n, self.stride);
        z.fill(0.0);
        for (k, (u, z)) in self.u.chunks_exact(stride).zip(z).take(n).enumerate() {
            let end = self.ends[k / LANES].min(n);
            *z = dot(&u[k..end], &x[k..end]);
        }
    }

    /// `H x`, of H itself.
    pub(super) fn product(&self, qp: &Qp, x: &[f64], hx: &mut [f64]) {
        let n = self.n;
        let blocks = qp.h().chunks(LANES * n).zip(hx[..n].chunks_mut(LANES));
        for (&(begin, end), (rows, hx)) in self.columns.iter().zip(blocks) {
            if begin >= end {
                hx.fill(0.0);
            } else if hx.len() == LANES {
                hx.copy_from_slice(&dots(&rows[begin..], n, &x[begin..end]));
            } else {
                for (row, hx) in rows.chunks_exact(n).zip(hx) {
                    *hx = dot(&row[begin..end], &x[begin..end]);
                }
            }
        }
    }
}

/// Length without the zeros at the end.
fn used(row: &[f64]) -> usize {
    let (lanes, rest) = row.as_chunks::<LANES>();
    if let Some(last) = rest.iter().rposition(|h| *h != 0.0) {
        return row.len() - rest.len() + last + 1;
    }
    let last = lanes.iter().rposition(|lane| *lane != [0.0; LANES]);
    last.map_or(0, |i| (i + 1) * LANES)
}

/// `B⁻¹` of an upper triangle B, given what its diagonal's inverse is.
fn inverse_of_triangle(
    u: &[[f64; LANES]; LANES],
    [r0, r1, r2, r3]: [f64; LANES],
) -> [[f64; LANES]; LANES] {
    let [[_, u01, u02, u03], [_, _, u12, u13], [_, _, _, u23], _] = *u;
    let (i01, i12, i23) = (-r0 * u01 * r1, -r1 * u12 * r2, -r2 * u23 * r3);
    let i02 = -(r0 * u02 + i01 * u12) * r2;
    let i13 = -(r1 * u13 + i12 * u23) * r3;
    let i03 = -((r0 * u03 + i01 * u13) + i02 * u23) * r3;
    [
        [r0, i01, i02, i03],
        [0.0, r1, i12, i13],
        [0.0, 0.0, r2, i23],
        [0.0, 0.0, 0.0, r3],
    ]
}

/// `B⁻ᵀ a`, given `B⁻¹`, an upper triangle.
#[inline]
fn transposed_product(inverse: &[[f64; LANES]; LANES], a: [f64; LANES]) -> [f64; LANES] {
    let [i0, i1, i2, i3] = inverse;
    [
        i0[0] * a[0],
        i0[1] * a[0] + i1[1] * a[1],
        (i0[2] * a[0] + i1[2] * a[1]) + i2[2] * a[2],
        (i0[3] * a[0] + i1[3] * a[1]) + (i2[3] * a[2] + i3[3] * a[3]),
    ]
}

/// Puts the diagonal block of a row of U in place, and hands out what is right of it.
fn right_of(row: &mut [f64], u: [f64; LANES], first: usize, end: usize) -> &mut [[f64; LANES]] {
    let (diagonal, right) = row[first..end].split_at_mut(LANES);
    diagonal.copy_from_slice(&u);
    right.as_chunks_mut().0
}

/// Four numbers that follow one another.
fn block(a: &[f64], at: usize) -> [f64; LANES] {
    [a[at], a[at + 1], a[at + 2], a[at + 3]]
}

fn has_equalities(qp: &Qp) -> bool {
    qp.row_lower()
        .iter()
        .zip(qp.row_upper())
        .any(|(l, u)| l == u)
}
