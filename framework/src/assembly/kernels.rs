//! Inner loops over rows that lie in one piece. The order of all sums is fixed by the code: results do not depend on how
//! wide the machine's vectors are.

/// `y += Σ a_k x_k` over the length of y; the rows `x_k` must not be shorter.
pub(super) fn add_rows<const K: usize>(y: &mut [f64], a: [f64; K], x: [&[f64]; K]) {
    let n = y.len();
    let x = x.map(|x| &x[..n]);
    for (j, y) in y.iter_mut().enumerate() {
        let mut sum = *y;
        for k in 0..K {
            sum += a[k] * x[k][j];
        }
        *y = sum;
    }
}

/// `y += Σ_k a_k x_k` over the length of y for the rows `x_k` of a matrix with a row stride.
pub(super) fn add_matrix_rows(y: &mut [f64], coefficients: &[f64], matrix: &[f64], stride: usize) {
    let (fours, rest) = coefficients.as_chunks::<4>();
    let mut rows = matrix.chunks_exact(stride);
    let mut next = || rows.next().unwrap_or_default();
    for &a in fours {
        if a != [0.0; 4] {
            add_rows(y, a, [next(), next(), next(), next()]);
        } else {
            for _ in 0..4 {
                next();
            }
        }
    }
    for &a in rest {
        let row = next();
        if a != 0.0 {
            add_rows(y, [a], [row]);
        }
    }
}

/// `aᵀ b` over the shorter length.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
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
