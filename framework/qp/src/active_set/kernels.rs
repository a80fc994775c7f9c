//! Inner loops over lanes: four or eight sums side by side, in an order that the code fixes, so that results do not
//! depend on how wide the machine's vectors are.
//!
//! Four rows at a time go through one pass over a vector: it is read once for the four, and the long chains of
//! dependent additions and stores, which a row alone would wait for, overlap.

use std::hint::black_box;

/// Vectors and strides of the workspaces are whole multiples of this, padded with zeros: the loops have no remainder.
pub(super) const LANES: usize = 4;
/// Up to this stride zeros are not looked for: loops over all of a stride that the compiler knows are faster.
pub(super) const SMALL: usize = 16;

/// Length with the padding.
#[inline(always)]
pub(super) fn padded(n: usize) -> usize {
    n.next_multiple_of(LANES)
}

/// `aᵀb` over the shorter length.
#[inline(always)]
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().min(b.len());
    let (a8, a_rest) = a[..n].as_chunks::<8>();
    let (b8, b_rest) = b[..n].as_chunks::<8>();
    let mut sums = [0.0; 8];
    for (a, b) in a8.iter().zip(b8) {
        for l in 0..8 {
            sums[l] += a[l] * b[l];
        }
    }
    let (a4, a_rest) = a_rest.as_chunks::<4>();
    let (b4, b_rest) = b_rest.as_chunks::<4>();
    for (a, b) in a4.iter().zip(b4) {
        for l in 0..4 {
            sums[l] += a[l] * b[l];
        }
    }
    let mut sum =
        ((sums[0] + sums[4]) + (sums[2] + sums[6])) + ((sums[1] + sums[5]) + (sums[3] + sums[7]));
    for (a, b) in a_rest.iter().zip(b_rest) {
        sum += a * b;
    }
    sum
}

/// Sum of the squares after the k-th component.
#[inline]
pub(super) fn squares_after(k: usize, a: &[f64]) -> f64 {
    if a.len() > SMALL {
        return dot(&a[k + 1..], &a[k + 1..]);
    }
    let mut sums = [0.0; LANES];
    for (i, a) in a.as_chunks::<LANES>().0.iter().enumerate() {
        for l in 0..LANES {
            let a = if LANES * i + l > k { a[l] } else { 0.0 };
            sums[l] += a * a;
        }
    }
    (sums[0] + sums[2]) + (sums[1] + sums[3])
}

/// `|a|ᵀb` over the shorter length.
#[inline]
pub(super) fn dot_magnitudes(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().min(b.len());
    let (a8, a_rest) = a[..n].as_chunks::<8>();
    let (b8, b_rest) = b[..n].as_chunks::<8>();
    let mut sums = [0.0; 8];
    for (a, b) in a8.iter().zip(b8) {
        for l in 0..8 {
            sums[l] += a[l].abs() * b[l];
        }
    }
    let mut sum =
        ((sums[0] + sums[4]) + (sums[2] + sums[6])) + ((sums[1] + sums[5]) + (sums[3] + sums[7]));
    for (a, b) in a_rest.iter().zip(b_rest) {
        sum += a.abs() * b;
    }
    sum
}

/// `rᵀ x` of four rows that are `stride` apart, each as long as `x`; the first begins with `rows`.
#[expect(clippy::inline_always, reason = "the length is to be known")]
#[inline(always)]
pub(super) fn dots(rows: &[f64], stride: usize, x: &[f64]) -> [f64; 4] {
    let n = x.len();
    let row = |i: usize| &rows[i * stride..i * stride + n];
    dots_of([row(0), row(1), row(2), row(3)], x)
}

/// `rᵀ x` of four rows, each as long as `x`.
#[expect(clippy::inline_always, reason = "the length is to be known")]
#[inline(always)]
pub(super) fn dots_of(rows: [&[f64]; 4], x: &[f64]) -> [f64; 4] {
    let n = x.len();
    let [a, b, c, d] = rows.map(|row| row[..n].as_chunks::<LANES>());
    let (x, x_rest) = x.as_chunks::<LANES>();
    let (mut s0, mut s1, mut s2, mut s3) = ([0.0; 4], [0.0; 4], [0.0; 4], [0.0; 4]);
    for ((((x, a), b), c), d) in x.iter().zip(a.0).zip(b.0).zip(c.0).zip(d.0) {
        for l in 0..LANES {
            s0[l] += a[l] * x[l];
            s1[l] += b[l] * x[l];
            s2[l] += c[l] * x[l];
            s3[l] += d[l] * x[l];
        }
    }
    // Through memory, as far as `black_box` is heeded: a compiler that sees products and sums together vectorises
    // across the rows, which takes as many shuffles as products. The bits do not depend on it.
    let mut out = black_box([s0, s1, s2, s3]).map(|s| (s[0] + s[2]) + (s[1] + s[3]));
    for (i, x) in x_rest.iter().enumerate() {
        out[0] += a.1[i] * x;
        out[1] += b.1[i] * x;
        out[2] += c.1[i] * x;
        out[3] += d.1[i] * x;
    }
    out
}

/// `y += α x` over the shorter length.
#[inline(always)]
pub(super) fn axpy(y: &mut [f64], alpha: f64, x: &[f64]) {
    let n = y.len().min(x.len());
    // Sixteen at a time, as in `add_rows`.
    let ((y16, y), (x16, x)) = (y[..n].as_chunks_mut::<16>(), x[..n].as_chunks::<16>());
    for (y, x) in y16.iter_mut().zip(x16) {
        scale_and_add(y, alpha, x);
    }
    let ((y8, y), (x8, x)) = (y.as_chunks_mut::<8>(), x.as_chunks::<8>());
    if let ([y], [x]) = (y8, x8) {
        scale_and_add(y, alpha, x);
    }
    let ((y4, y), (x4, x)) = (y.as_chunks_mut::<LANES>(), x.as_chunks::<LANES>());
    if let ([y], [x]) = (y4, x4) {
        scale_and_add(y, alpha, x);
    }
    for (y, x) in y.iter_mut().zip(x) {
        *y += alpha * x;
    }
}

#[inline(always)]
fn scale_and_add<const L: usize>(y: &mut [f64; L], alpha: f64, x: &[f64; L]) {
    for l in 0..L {
        y[l] += alpha * x[l];
    }
}

/// `y += Σ α_i r_i` over four rows that are `stride` apart, each as long as `y`, a whole number of lanes; the first
/// begins with `rows`.
#[expect(
    clippy::inline_always,
    reason = "as a call, α goes through memory, and its loads stall"
)]
#[inline(always)]
pub(super) fn add_rows(y: &mut [f64], alpha: [f64; 4], rows: &[f64], stride: usize) {
    let n = y.len();
    let row = |i: usize| &rows[i * stride..i * stride + n];
    add_four(y, alpha, [row(0), row(1), row(2), row(3)]);
}

/// `y += Σ α_i r_i` over four rows, each as long as `y`, a whole number of lanes.
#[expect(clippy::inline_always, reason = "as for `add_rows`")]
#[inline(always)]
pub(super) fn add_four(y: &mut [f64], alpha: [f64; 4], rows: [&[f64]; 4]) {
    let n = y.len();
    let [a, b, c, d] = rows.map(|row| &row[..n]);
    // Sixteen at a time, a stride so long that the compiler vectorises along the rows and not across them.
    let (y16, y) = y.as_chunks_mut::<16>();
    let ((a16, a), (b16, b)) = (a.as_chunks(), b.as_chunks());
    let ((c16, c), (d16, d)) = (c.as_chunks(), d.as_chunks());
    for ((((y, a), b), c), d) in y16.iter_mut().zip(a16).zip(b16).zip(c16).zip(d16) {
        add_lanes::<16>(y, alpha, a, b, c, d);
    }
    let (y8, y) = y.as_chunks_mut::<8>();
    let ((a8, a), (b8, b)) = (a.as_chunks(), b.as_chunks());
    let ((c8, c), (d8, d)) = (c.as_chunks(), d.as_chunks());
    if let ([y], [a], [b], [c], [d]) = (y8, a8, b8, c8, d8) {
        add_lanes::<8>(y, alpha, a, b, c, d);
    }
    let (y4, _) = y.as_chunks_mut::<LANES>();
    let ((a4, _), (b4, _)) = (a.as_chunks(), b.as_chunks());
    let ((c4, _), (d4, _)) = (c.as_chunks(), d.as_chunks());
    if let ([y], [a], [b], [c], [d]) = (y4, a4, b4, c4, d4) {
        add_lanes::<LANES>(y, alpha, a, b, c, d);
    }
}

#[expect(clippy::inline_always, reason = "as for `add_rows`")]
#[inline(always)]
fn add_lanes<const L: usize>(
    y: &mut [f64; L],
    alpha: [f64; 4],
    a: &[f64; L],
    b: &[f64; L],
    c: &[f64; L],
    d: &[f64; L],
) {
    let [f0, f1, f2, f3] = alpha;
    for l in 0..L {
        y[l] += (f0 * a[l] + f1 * b[l]) + (f2 * c[l] + f3 * d[l]);
    }
}

/// Largest magnitude of the products `a_i b_i`, over the shorter length.
#[inline(always)]
pub(super) fn largest_product(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().min(b.len());
    let (a4, a_rest) = a[..n].as_chunks::<LANES>();
    let (b4, b_rest) = b[..n].as_chunks::<LANES>();
    let larger = |x: f64, y: f64| if y > x { y } else { x };
    let mut lanes = [0.0; LANES];
    for (a, b) in a4.iter().zip(b4) {
        for l in 0..LANES {
            lanes[l] = larger(lanes[l], (a[l] * b[l]).abs());
        }
    }
    let rest = a_rest.iter().zip(b_rest).map(|(a, b)| (a * b).abs());
    rest.chain(lanes).fold(0.0, larger)
}

/// `a *= α`.
pub(super) fn scale(a: &mut [f64], alpha: f64) {
    for a in a {
        *a *= alpha;
    }
}

/// Largest magnitude.
pub(super) fn largest(a: &[f64]) -> f64 {
    a.iter().fold(0.0, |largest: f64, a| largest.max(a.abs()))
}

#[cfg(test)]
mod tests {
    use super::{LANES, add_rows, axpy, dot, dots};

    #[test]
    fn every_length_sums_every_product() {
        for n in 0..40 {
            let a: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
            let b: Vec<f64> = (0..n + 3).map(|i| (i as f64).cos()).collect();
            let plain: f64 = a.iter().zip(&b).map(|(a, b)| a * b).sum();
            assert!((dot(&a, &b) - plain).abs() < 1e-14 * (1.0 + n as f64));
            let mut y = b.clone();
            axpy(&mut y, 2.0, &a);
            for i in 0..n + 3 {
                let added = a.get(i).map_or(0.0, |a| 2.0 * a);
                assert_eq!(y[i], b[i] + added);
            }
        }
    }

    #[test]
    fn four_rows_at_once_are_four_rows() {
        // Rows are padded to whole lanes.
        for n in (0..=40).step_by(LANES) {
            let row = |p: usize| (0..n).map(move |i| ((7 * i + 3 * p) as f64).sin());
            let rows: Vec<f64> = (0..4).flat_map(|p| row(p).chain([9.0])).collect();
            let x: Vec<f64> = row(5).collect();
            let alpha = [1.0, -2.0, 0.5, 3.0];
            let (mut y, mut expected) = (x.clone(), x.clone());
            add_rows(&mut y, alpha, &rows, n + 1);
            for (p, sum) in dots(&rows, n + 1, &x).into_iter().enumerate() {
                assert!((sum - dot(&rows[p * (n + 1)..], &x)).abs() < 1e-14 * (1.0 + n as f64));
                axpy(&mut expected, alpha[p], &rows[p * (n + 1)..]);
            }
            for (y, expected) in y.iter().zip(&expected) {
                assert!((y - expected).abs() < 1e-14 * (1.0 + expected.abs()));
            }
        }
    }
}
