//! Inner loops over rows that lie in one piece. The order of all sums is fixed by the code: results do not depend on
//! how wide the machine's vectors are.

/// `y += a x` over the length of y.
pub(super) fn add_row(y: &mut [f64], a: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += a * x;
    }
}

/// `y += Σ a_k x_k` over the length of y; the rows `x_k` must not be shorter.
#[allow(
    clippy::inline_always,
    reason = "rows are short: coefficients that go through memory take longer than the sum"
)]
#[inline(always)]
pub(super) fn add_two_rows(y: &mut [f64], a: [f64; 2], x: [&[f64]; 2]) {
    let n = y.len();
    let [p, q] = x.map(|x| &x[..n]);
    for ((y, p), q) in y.iter_mut().zip(p).zip(q) {
        *y = *y + a[0] * p + a[1] * q;
    }
}

/// Like [`add_two_rows`], of four rows.
#[allow(
    clippy::inline_always,
    reason = "rows are short: coefficients that go through memory take longer than the sum"
)]
#[inline(always)]
pub(super) fn add_four_rows(y: &mut [f64], a: [f64; 4], x: [&[f64]; 4]) {
    let n = y.len();
    let [p, q, r, s] = x.map(|x| &x[..n]);
    for ((((y, p), q), r), s) in y.iter_mut().zip(p).zip(q).zip(r).zip(s) {
        *y = *y + a[0] * p + a[1] * q + a[2] * r + a[3] * s;
    }
}

/// Like [`add_two_rows`], of six rows.
#[allow(
    clippy::inline_always,
    reason = "rows are short: coefficients that go through memory take longer than the sum"
)]
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
