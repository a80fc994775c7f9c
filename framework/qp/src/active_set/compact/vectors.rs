//! Inner loops over normals, of a length that the compiler knows where their callers do.

use crate::active_set::kernels::{LANES, add_rows, dots, dots_of};

/// The normal of a constraint.
#[inline(always)]
pub(super) fn normal(w: &[f64], stride: usize, index: usize) -> &[f64] {
    &w[index * stride..][..stride]
}

/// `aᵀ b`.
#[inline(always)]
pub(super) fn product(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; LANES];
    let (a, b) = (
        a.as_chunks::<LANES>().0,
        b[..a.len()].as_chunks::<LANES>().0,
    );
    for (a, b) in a.iter().zip(b) {
        for l in 0..LANES {
            sums[l] += a[l] * b[l];
        }
    }
    (sums[0] + sums[2]) + (sums[1] + sums[3])
}

/// `y −= α x`.
#[inline(always)]
pub(super) fn subtract(y: &mut [f64], alpha: f64, x: &[f64]) {
    for (y, x) in y[..x.len()].iter_mut().zip(x) {
        *y -= alpha * x;
    }
}

/// Products of `w` with the normals of a list, four at a time.
#[inline(always)]
pub(super) fn multiply<'a, T>(
    list: &[T],
    normal: impl Fn(&T) -> &'a [f64],
    w: &[f64],
    out: &mut [f64],
) {
    let (fours, rest) = list.as_chunks::<LANES>();
    let (outs, out_rest) = out[..list.len()].as_chunks_mut::<LANES>();
    for (four, out) in fours.iter().zip(outs) {
        *out = dots_of(four.each_ref().map(&normal), w);
    }
    for (of, out) in rest.iter().zip(out_rest) {
        *out = product(normal(of), w);
    }
}

/// `h = Qᵀ w`, of as many columns as `h` is long.
#[inline(always)]
pub(super) fn project(q: &[f64], w: &[f64], h: &mut [f64]) {
    let stride = w.len();
    let (fours, rest) = h.as_chunks_mut::<LANES>();
    let whole = fours.len() * LANES;
    for (four, q) in fours.iter_mut().zip(q.chunks_exact(LANES * stride)) {
        *four = dots(q, stride, w);
    }
    let last = q[whole * stride..].chunks_exact(stride);
    for (h, q) in rest.iter_mut().zip(last) {
        *h = product(q, w);
    }
}

/// `y −= Q h`, of as many columns as `h` is long.
#[inline(always)]
pub(super) fn subtract_columns(y: &mut [f64], h: &[f64], q: &[f64]) {
    let stride = y.len();
    let (fours, rest) = h.as_chunks::<LANES>();
    let whole = fours.len() * LANES;
    for (four, q) in fours.iter().zip(q.chunks_exact(LANES * stride)) {
        add_rows(y, four.map(|h| -h), q, stride);
    }
    for (h, q) in rest.iter().zip(q[whole * stride..].chunks_exact(stride)) {
        subtract(y, *h, q);
    }
}
