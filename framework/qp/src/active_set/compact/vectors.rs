//! Inner loops over normals whose length the compiler knows.

use crate::active_set::kernels::{LANES, add_rows, dots, dots_of};

/// The normal of a constraint.
#[inline(always)]
pub(super) fn normal<const S: usize>(w: &[f64], index: usize) -> &[f64; S] {
    &w.as_chunks::<S>().0[index]
}

/// `aᵀ b`.
#[inline(always)]
pub(super) fn product<const S: usize>(a: &[f64; S], b: &[f64]) -> f64 {
    let mut sums = [0.0; LANES];
    let (a, b) = (a.as_chunks::<LANES>().0, b[..S].as_chunks::<LANES>().0);
    for (a, b) in a.iter().zip(b) {
        for l in 0..LANES {
            sums[l] += a[l] * b[l];
        }
    }
    (sums[0] + sums[2]) + (sums[1] + sums[3])
}

/// `y −= α x`.
#[inline(always)]
pub(super) fn subtract<const S: usize>(y: &mut [f64], alpha: f64, x: &[f64; S]) {
    for (y, x) in y[..S].iter_mut().zip(x) {
        *y -= alpha * x;
    }
}

/// Products of `w` with the normals of a list, four at a time.
#[inline(always)]
pub(super) fn multiply<'a, T, const S: usize>(
    list: &[T],
    normal: impl Fn(&T) -> &'a [f64; S],
    w: &[f64; S],
    out: &mut [f64],
) {
    let (fours, rest) = list.as_chunks::<LANES>();
    let (outs, out_rest) = out[..list.len()].as_chunks_mut::<LANES>();
    for (four, out) in fours.iter().zip(outs) {
        *out = dots_of(four.each_ref().map(|of| &normal(of)[..]), w);
    }
    for (of, out) in rest.iter().zip(out_rest) {
        *out = product(normal(of), w);
    }
}

/// `h = Qᵀ w`, of as many columns as `h` is long.
#[inline(always)]
pub(super) fn project<const S: usize>(q: &[f64], w: &[f64], h: &mut [f64]) {
    let (fours, rest) = h.as_chunks_mut::<LANES>();
    let whole = fours.len() * LANES;
    for (four, q) in fours.iter_mut().zip(q.chunks_exact(LANES * S)) {
        *four = dots(q, S, &w[..S]);
    }
    for (h, q) in rest.iter_mut().zip(&q.as_chunks::<S>().0[whole..]) {
        *h = product(q, w);
    }
}

/// `y −= Q h`, of as many columns as `h` is long.
#[inline(always)]
pub(super) fn subtract_columns<const S: usize>(y: &mut [f64], h: &[f64], q: &[f64]) {
    let (fours, rest) = h.as_chunks::<LANES>();
    let whole = fours.len() * LANES;
    for (four, q) in fours.iter().zip(q.chunks_exact(LANES * S)) {
        add_rows(&mut y[..S], four.map(|h| -h), q, S);
    }
    for (h, q) in rest.iter().zip(&q.as_chunks::<S>().0[whole..]) {
        subtract(y, *h, q);
    }
}
