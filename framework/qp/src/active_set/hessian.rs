//! `H̃ = Uᵀ U`: the factor that turns the problem into one of least distance.
//!
//! # Mathematics
//! With `z = U x` the cost is `½ ‖z + U⁻ᵀ g‖²` up to a constant. H only has to be positive definite where the
//! equality rows leave freedom. If a pivot is as good as zero, `Σ σ_i a_iᵀ a_i` over these rows is added, with
//! `−σ_i b_i a_i` in the linear term: on the feasible set this changes neither cost nor solution nor multipliers, and
//! the accelerations of an explicit formulation, which may have no cost of their own, become definite through their
//! dynamics.

use std::ops::Range;

use super::{
    constraint::any_equal,
    kernels::{LANES, SMALL, add_rows, axpy, dot, dots, padded},
    simd::{Simd, Vectors, with_simd},
};
use crate::Qp;

/// A pivot below this part of its diagonal entry is rounding: Cholesky's own error is of the order n ε.
const WEAK: f64 = 1e-13;

/// The factor and what was added to H to get it.
///
/// Rows go in blocks of four. Of a block, only the columns between its first and last entry other than zero are ever
/// touched: the cost of a whole-body problem falls apart into accelerations, inputs and forces.
#[derive(Clone, Debug, Default)]
pub(super) struct Hessian {
    simd: Simd,
    n: usize,
    /// n with padding.
    stride: usize,
    /// Row-major. Valid from the diagonal on; what is left of it has no meaning. One on the diagonal of the padding.
    u: Vec<f64>,
    /// Per block of rows, the columns of H with entries.
    columns: Vec<(usize, usize)>,
    /// Per block of rows, where the entries of U end, in whole lanes.
    ends: Vec<usize>,
    /// Inverses of the blocks on the diagonal of U: with them the entries of a block do not wait for
    /// one another.
    inverses: Vec<[[f64; LANES]; LANES]>,
    /// Diagonal of what is factorised.
    diagonal: Vec<f64>,
    /// `−Σ σ_i b_i a_i`, if equality rows were added.
    shift: Vec<f64>,
    is_shifted: bool,
    /// Whether zeros are not looked for.
    is_full: bool,
}

impl Hessian {
    pub(super) fn new(n: usize, simd: Simd) -> Self {
        let stride = padded(n);
        Self {
            simd,
            u: vec![0.0; stride * stride],
            columns: vec![(0, 0); stride / LANES],
            ends: vec![0; stride / LANES],
            inverses: vec![[[0.0; LANES]; LANES]; stride / LANES],
            diagonal: vec![0.0; stride],
            shift: vec![0.0; n],
            ..Self::default()
        }
    }

    /// Factorises; false if H is not definite, or has no finite factor.
    pub(super) fn factorise(&mut self, qp: &Qp) -> bool {
        // What is rare, machines without vectors, has code for any size.
        match self.simd.wide() {
            Some(wide) => with_simd!(wide, self.factorise_with::<true>(qp)),
            None => self.factorise_with::<false>(qp),
        }
    }

    /// `SIZED` says that there is code for the usual sizes.
    #[inline(always)]
    fn factorise_with<const SIZED: bool>(&mut self, qp: &Qp) -> bool {
        self.n = qp.n();
        self.stride = padded(self.n);
        self.is_shifted = false;
        loop {
            self.load(qp);
            if self.is_shifted {
                self.add_equalities(qp);
            }
            if self.eliminate::<SIZED>() {
                return true;
            }
            if self.is_shifted || !any_equal(qp.row_lower(), qp.row_upper()) {
                return false;
            }
            self.is_shifted = true;
        }
    }

    /// Whether equality rows were added.
    pub(super) fn is_shifted(&self) -> bool {
        self.is_shifted
    }

    /// Adds to a linear term what belongs to the added equality rows.
    pub(super) fn shift(&self, g: &mut [f64]) {
        if self.is_shifted {
            axpy(g, 1.0, &self.shift);
        }
    }

    /// Where the entries of a block of rows of U end.
    #[expect(clippy::inline_always, reason = "the stride is to be known")]
    #[inline(always)]
    fn end<const FULL: bool>(&self, block: usize, stride: usize) -> usize {
        if FULL { stride } else { self.ends[block] }
    }

    #[inline(always)]
    fn load(&mut self, qp: &Qp) {
        let (n, stride) = (self.n, self.stride);
        // Where the first row reaches the last column, elimination leaves few zeros.
        self.is_full = stride <= SMALL || qp.h()[n - 1] != 0.0;
        if self.is_full {
            self.load_all(qp);
            return;
        }
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
            for (k, row) in rows
                .chunks_exact_mut(stride)
                .enumerate()
                .skip(source.len() / n)
            {
                row[first..*end].fill(0.0);
                row[first + k] = 1.0;
            }
        }
        // H is symmetric.
        for b in 1..stride / LANES {
            let reaches = |above: &(usize, usize)| above.1 > b * LANES;
            let above = self.columns[..b].iter().position(reaches);
            self.columns[b].0 = above.unwrap_or(b) * LANES;
        }
    }

    /// Loads H of a problem so small that zeros are not worth looking for.
    #[inline(always)]
    fn load_all(&mut self, qp: &Qp) {
        match self.n {
            8 => self.load_all_with(8, qp),
            12 => self.load_all_with(12, qp),
            16 => self.load_all_with(16, qp),
            n => self.load_all_with(n, qp),
        }
    }

    #[expect(
        clippy::inline_always,
        reason = "the number of variables is to be known"
    )]
    #[inline(always)]
    fn load_all_with(&mut self, n: usize, qp: &Qp) {
        let stride = padded(n);
        let rows = self.u.chunks_exact_mut(stride);
        for (row, h) in rows.zip(qp.h().chunks_exact(n)) {
            row[..n].copy_from_slice(h);
            row[n..].fill(0.0);
        }
        for k in n..stride {
            self.u[k * stride..(k + 1) * stride].fill(0.0);
            self.u[k * stride + k] = 1.0;
        }
        self.columns[..stride / LANES].fill((0, n));
        self.ends[..stride / LANES].fill(stride);
    }

    fn add_equalities(&mut self, qp: &Qp) {
        let n = self.n;
        self.shift[..n].fill(0.0);
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
    #[inline(always)]
    fn eliminate<const SIZED: bool>(&mut self) -> bool {
        // Loops of a length that the compiler knows take half the time.
        match (self.stride, self.is_full) {
            (8, true) if SIZED => self.eliminate_with::<true>(8),
            (12, true) if SIZED => self.eliminate_with::<true>(12),
            (16, true) if SIZED => self.eliminate_with::<true>(16),
            (32, true) if SIZED => self.eliminate_with::<true>(32),
            (stride, true) => self.eliminate_with::<true>(stride),
            (stride, false) => self.eliminate_with::<false>(stride),
        }
    }

    #[expect(clippy::inline_always, reason = "the stride is to be known")]
    #[inline(always)]
    fn eliminate_with<const FULL: bool>(&mut self, stride: usize) -> bool {
        let diagonal = self.diagonal[..stride].iter_mut();
        for (k, (d, row)) in diagonal.zip(self.u.chunks_exact(stride)).enumerate() {
            *d = row[k];
        }
        for first in (0..stride).step_by(LANES) {
            let (end, next) = (self.end::<FULL>(first / LANES, stride), first + LANES);
            let (above, below) = self.u[..stride * stride].split_at_mut(next * stride);
            let rows = &mut above[first * stride..];
            let Some(pivots) =
                eliminate_within(rows, stride, first..end, &self.diagonal[first..next])
            else {
                return false;
            };
            let reciprocal = pivots.map(|pivot| 1.0 / pivot);
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
                if !FULL {
                    if factors.as_flattened().iter().all(|f| *f == 0.0) {
                        continue;
                    }
                    let filled = &mut self.ends[at / LANES];
                    for target in targets.chunks_exact_mut(stride) {
                        if *filled < end {
                            target[*filled..end].fill(0.0);
                        }
                    }
                    *filled = (*filled).max(end);
                }
                for (q, target) in targets.chunks_exact_mut(stride).enumerate() {
                    let [f0, f1, f2, f3] = factors;
                    let [r0, r1, r2, r3] = reciprocal;
                    let alpha = [-f0[q] * r0, -f1[q] * r1, -f2[q] * r2, -f3[q] * r3];
                    add_rows(&mut target[at..end], alpha, &rows[at..], stride);
                }
            }
            let Some(inverse) = divide_by_roots(rows, stride, first..end, pivots) else {
                return false;
            };
            self.inverses[first / LANES] = inverse;
        }
        true
    }

    /// Replaces `a` by `w = U⁻ᵀ a`; returns which components of w may differ from zero, in whole lanes.
    pub(super) fn solve_transposed(&self, a: &mut [f64]) -> Range<usize> {
        match self.simd.wide() {
            Some(wide) => with_simd!(
                wide,
                match self.stride {
                    8 => self.solve_transposed_of(8, 0, a),
                    12 => self.solve_transposed_of(12, 0, a),
                    16 => self.solve_transposed_of(16, 0, a),
                    32 => self.solve_transposed_of(32, 0, a),
                    stride => self.solve_transposed_of(stride, 0, a),
                }
            ),
            None => self.solve_transposed_of(self.stride, 0, a),
        }
    }

    /// The same, where the stride is known, and the first component that may differ from zero.
    #[expect(clippy::inline_always, reason = "the stride is to be known")]
    #[inline(always)]
    pub(super) fn solve_transposed_of(
        &self,
        stride: usize,
        first: usize,
        a: &mut [f64],
    ) -> Range<usize> {
        // Small ones are full, always.
        if stride <= SMALL || self.is_full {
            self.solve_transposed_with::<true>(stride, first, a)
        } else {
            self.solve_transposed_with::<false>(stride, first, a)
        }
    }

    /// The same for several columns at once, whose first components that may differ from zero ascend; rows of `x` are
    /// that many numbers, padded.
    #[inline(always)]
    pub(super) fn solve_transposed_columns(&self, x: &mut [f64], starts: &[usize]) {
        let (stride, width) = (self.stride, padded(starts.len()));
        for (b, inverse) in self.inverses[..stride / LANES].iter().enumerate() {
            let first = b * LANES;
            let next = first + LANES;
            let (head, tail) = x.split_at_mut(next * width);
            let block = &mut head[first * width..];
            let used = padded(starts.partition_point(|start| *start < next));
            let (two, rest) = block.split_at_mut(2 * width);
            let ((r0, r1), (r2, r3)) = (two.split_at_mut(width), rest.split_at_mut(width));
            for (((r0, r1), r2), r3) in r0[..used].iter_mut().zip(r1).zip(r2).zip(r3) {
                [*r0, *r1, *r2, *r3] = transposed_product(inverse, [*r0, *r1, *r2, *r3]);
            }
            let u = &self.u[first * stride..];
            // Beyond that there is what was there before.
            let end = if self.is_full { stride } else { self.ends[b] };
            let rows = tail.chunks_exact_mut(width);
            for (k, row) in (next..end).zip(rows) {
                let alpha = [0, 1, 2, 3].map(|r| -u[r * stride + k]);
                add_rows(&mut row[..used], alpha, block, width);
            }
        }
    }

    #[expect(clippy::inline_always, reason = "the stride is to be known")]
    #[inline(always)]
    fn solve_transposed_with<const FULL: bool>(
        &self,
        stride: usize,
        begin: usize,
        a: &mut [f64],
    ) -> Range<usize> {
        let (u, a) = (&self.u[..stride * stride], &mut a[..stride]);
        let inverses = &self.inverses[..stride / LANES];
        let mut range = stride..0;
        for (b, inverse) in inverses.iter().enumerate() {
            let (first, end) = (b * LANES, self.end::<FULL>(b, stride));
            let next = first + LANES;
            if stride <= SMALL && next <= begin {
                continue;
            }
            let (head, tail) = a.split_at_mut(next);
            let w = &mut head[first..];
            if !FULL && w.iter().all(|w| *w == 0.0) {
                continue;
            }
            range = range.start.min(first)..range.end.max(end);
            let block = transposed_product(inverse, [w[0], w[1], w[2], w[3]]);
            w.copy_from_slice(&block);
            let rows = &u[first * stride..];
            let alpha = [-block[0], -block[1], -block[2], -block[3]];
            add_rows(&mut tail[..end - next], alpha, &rows[next..], stride);
        }
        if range.is_empty() { 0..0 } else { range }
    }

    /// Replaces `z` by `x = U⁻¹ z`.
    pub(super) fn solve(&self, z: &mut [f64]) {
        match self.simd.wide() {
            Some(wide) => with_simd!(
                wide,
                match self.stride {
                    8 => self.solve_of(8, z),
                    12 => self.solve_of(12, z),
                    16 => self.solve_of(16, z),
                    32 => self.solve_of(32, z),
                    stride => self.solve_of(stride, z),
                }
            ),
            None => self.solve_of(self.stride, z),
        }
    }

    /// The same, where the stride is known.
    #[expect(clippy::inline_always, reason = "the stride is to be known")]
    #[inline(always)]
    pub(super) fn solve_of(&self, stride: usize, z: &mut [f64]) {
        // Small ones are full, always.
        if stride <= SMALL || self.is_full {
            self.solve_with::<true>(stride, z);
        } else {
            self.solve_with::<false>(stride, z);
        }
    }

    #[expect(clippy::inline_always, reason = "the stride is to be known")]
    #[inline(always)]
    fn solve_with<const FULL: bool>(&self, stride: usize, z: &mut [f64]) {
        let (u, z) = (&self.u[..stride * stride], &mut z[..stride]);
        let inverses = &self.inverses[..stride / LANES];
        for (b, [i0, i1, i2, i3]) in inverses.iter().enumerate().rev() {
            let (first, end) = (b * LANES, self.end::<FULL>(b, stride));
            let next = first + LANES;
            let (head, tail) = z.split_at_mut(next);
            let rows = &u[first * stride..];
            let known = dots(&rows[next..], stride, &tail[..end - next]);
            let x = &mut head[first..];
            let [b0, b1, b2, b3] = [
                x[0] - known[0],
                x[1] - known[1],
                x[2] - known[2],
                x[3] - known[3],
            ];
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
        with_simd!(
            self.simd,
            match self.n {
                8 => self.product_with(8, qp, x, hx),
                12 => self.product_with(12, qp, x, hx),
                16 => self.product_with(16, qp, x, hx),
                n => self.product_with(n, qp, x, hx),
            }
        );
    }

    #[expect(
        clippy::inline_always,
        reason = "the number of variables is to be known"
    )]
    #[inline(always)]
    pub(super) fn product_with(&self, n: usize, qp: &Qp, x: &[f64], hx: &mut [f64]) {
        let x = &x[..n];
        let blocks = qp.h().chunks(LANES * n).zip(hx[..n].chunks_mut(LANES));
        for (&columns, (rows, hx)) in self.columns.iter().zip(blocks) {
            let (begin, end) = if self.is_full { (0, n) } else { columns };
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

/// Gaussian elimination within a block of rows, from its diagonal to `columns.end`; returns the pivots, nothing if one
/// is weak. Rows are not yet divided by the roots of their pivots, so that a pivot waits for a division and no root.
#[expect(clippy::inline_always, reason = "the stride is to be known")]
#[inline(always)]
fn eliminate_within(
    rows: &mut [f64],
    stride: usize,
    columns: Range<usize>,
    diagonal: &[f64],
) -> Option<[f64; LANES]> {
    let first = columns.start;
    let [p0, a1, a2, a3] = block(rows, first);
    let [_, b1, b2, b3] = block(rows, stride + first);
    let [_, _, c2, c3] = block(rows, 2 * stride + first);
    let [_, _, _, d3] = block(rows, 3 * stride + first);
    let r0 = 1.0 / p0;
    let (f01, f02, f03) = (a1 * r0, a2 * r0, a3 * r0);
    let (p1, b2, b3) = (b1 - f01 * a1, b2 - f01 * a2, b3 - f01 * a3);
    let (c2, c3, d3) = (c2 - f02 * a2, c3 - f02 * a3, d3 - f03 * a3);
    let r1 = 1.0 / p1;
    let (f12, f13) = (b2 * r1, b3 * r1);
    let (p2, c3, d3) = (c2 - f12 * b2, c3 - f12 * b3, d3 - f13 * b3);
    let f23 = c3 / p2;
    let p3 = d3 - f23 * c3;
    let values = [p0, p1, p2, p3];
    // `pivot > …`: a NaN is weak, too.
    let mut pairs = values.iter().zip(diagonal);
    if !pairs.all(|(pivot, diagonal)| *pivot > WEAK * diagonal) {
        return None;
    }
    let [a, b, c, d] = four_rows(rows, stride, columns);
    b[0] = [0.0, p1, b2, b3];
    c[0] = [0.0, 0.0, p2, c3];
    d[0] = [0.0, 0.0, 0.0, p3];
    let right = a[1..]
        .iter()
        .zip(&mut b[1..])
        .zip(&mut c[1..])
        .zip(&mut d[1..]);
    for (((a, b), c), d) in right {
        for l in 0..LANES {
            b[l] -= f01 * a[l];
            c[l] = (c[l] - f02 * a[l]) - f12 * b[l];
            d[l] = ((d[l] - f03 * a[l]) - f13 * b[l]) - f23 * c[l];
        }
    }
    Some(values)
}
/// Length without the zeros at the end.
#[inline(always)]
fn used(row: &[f64]) -> usize {
    let (lanes, rest) = row.as_chunks::<LANES>();
    if let Some(last) = rest.iter().rposition(|h| *h != 0.0) {
        return row.len() - rest.len() + last + 1;
    }
    let last = lanes.iter().rposition(|lane| *lane != [0.0; LANES]);
    last.map_or(0, |i| (i + 1) * LANES)
}

/// `B⁻¹` of an upper triangle B, given what its diagonal's inverse is.
#[inline(always)]
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
#[inline(always)]
fn transposed_product(inverse: &[[f64; LANES]; LANES], a: [f64; LANES]) -> [f64; LANES] {
    let [i0, i1, i2, i3] = inverse;
    [
        i0[0] * a[0],
        i0[1] * a[0] + i1[1] * a[1],
        (i0[2] * a[0] + i1[2] * a[1]) + i2[2] * a[2],
        (i0[3] * a[0] + i1[3] * a[1]) + (i2[3] * a[2] + i3[3] * a[3]),
    ]
}

/// Some columns of a block of rows.
#[expect(clippy::inline_always, reason = "the stride is to be known")]
#[inline(always)]
fn four_rows(rows: &mut [f64], stride: usize, columns: Range<usize>) -> [&mut [[f64; LANES]]; 4] {
    let (a, rest) = rows[..LANES * stride].split_at_mut(stride);
    let (b, rest) = rest.split_at_mut(stride);
    let (c, d) = rest.split_at_mut(stride);
    let (from, to) = (columns.start, columns.end);
    [
        a[from..to].as_chunks_mut().0,
        b[from..to].as_chunks_mut().0,
        c[from..to].as_chunks_mut().0,
        d[from..to].as_chunks_mut().0,
    ]
}

/// The rows of U of a block that is eliminated, given its pivots, and the inverse of its diagonal block; nothing if
/// that is not finite.
#[expect(clippy::inline_always, reason = "the stride is to be known")]
#[inline(always)]
fn divide_by_roots(
    rows: &mut [f64],
    stride: usize,
    columns: Range<usize>,
    pivots: [f64; LANES],
) -> Option<[[f64; LANES]; LANES]> {
    // Side by side: none waits for another.
    let reciprocals = pivots.map(|pivot| 1.0 / pivot.sqrt());
    if !reciprocals.iter().all(|r| r.is_finite()) {
        return None;
    }
    let rows = four_rows(rows, stride, columns);
    let mut triangle = [[0.0; LANES]; LANES];
    for ((row, r), diagonal) in rows.into_iter().zip(reciprocals).zip(&mut triangle) {
        for u in &mut *row {
            *u = u.map(|u| u * r);
        }
        *diagonal = row[0];
    }
    Some(inverse_of_triangle(&triangle, reciprocals))
}

/// Four numbers that follow one another.
#[inline(always)]
fn block(a: &[f64], at: usize) -> [f64; LANES] {
    [a[at], a[at + 1], a[at + 2], a[at + 3]]
}

#[cfg(test)]
mod tests {
    use super::{Hessian, padded};
    use crate::{Qp, active_set::simd::Simd};

    /// A definite H with entries beside the diagonal where two variables belong together.
    fn problem(n: usize, together: impl Fn(usize, usize) -> bool) -> Qp {
        let entry = |i: usize, j: usize| match (i == j, together(i, j)) {
            (true, _) => n as f64,
            (false, true) => ((i + j) as f64).sin(),
            (false, false) => 0.0,
        };
        let h: Vec<f64> = (0..n * n).map(|ij| entry(ij / n, ij % n)).collect();
        let free = (vec![f64::NEG_INFINITY; n], vec![f64::INFINITY; n]);
        let qp = Qp::dense(&h, &vec![0.0; n], &[], (&[], &[]), (&free.0, &free.1));
        qp.expect("the shapes fit")
    }

    /// Also where the factor before had entries that this one has not.
    #[test]
    fn columns_are_solved_as_each_alone() {
        for n in [9, 17, 24, 31] {
            let dense = problem(n, |_, _| true);
            let in_two = problem(n, |i, j| (i < n / 2) == (j < n / 2));
            let mut hessian = Hessian::new(n, Simd::detect());
            for qp in [&dense, &in_two] {
                assert!(hessian.factorise(qp), "H is definite");
                let (stride, starts) = (padded(n), [0, 1, n / 2, n - 1]);
                let entry = |i: usize, k: usize| {
                    if i < starts[k] || i >= n {
                        0.0
                    } else {
                        ((3 * i + k) as f64).cos()
                    }
                };
                let mut columns: Vec<f64> =
                    (0..stride * 4).map(|ik| entry(ik / 4, ik % 4)).collect();
                hessian.solve_transposed_columns(&mut columns, &starts);
                for k in 0..4 {
                    let mut alone: Vec<f64> = (0..stride).map(|i| entry(i, k)).collect();
                    hessian.solve_transposed(&mut alone);
                    for (i, alone) in alone.iter().enumerate() {
                        assert!((columns[4 * i + k] - alone).abs() < 1e-13, "{n}: {i} {k}");
                    }
                }
            }
        }
    }
}
