//! Inner loops. Eight sums side by side: results do not depend on how wide the machine's vectors are.

/// `aᵀb` over the shorter length.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().min(b.len());
    let (a, b) = (&a[..n], &b[..n]);
    let mut sums = [0.0; 8];
    let (a8, b8) = (a.chunks_exact(8), b.chunks_exact(8));
    let (a_rest, b_rest) = (a8.remainder(), b8.remainder());
    for (a, b) in a8.zip(b8) {
        for l in 0..8 {
            sums[l] += a[l] * b[l];
        }
    }
    let (a4, b4) = (a_rest.chunks_exact(4), b_rest.chunks_exact(4));
    let (a_rest, b_rest) = (a4.remainder(), b4.remainder());
    for (a, b) in a4.zip(b4) {
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

/// `y += α x` over the shorter length.
pub(super) fn axpy(y: &mut [f64], alpha: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += alpha * x;
    }
}

/// Largest magnitude.
pub(super) fn largest(a: &[f64]) -> f64 {
    a.iter().fold(0.0, |largest: f64, a| largest.max(a.abs()))
}

#[cfg(test)]
mod tests {
    use super::{axpy, dot};

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
}
