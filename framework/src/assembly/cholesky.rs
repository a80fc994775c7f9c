//! Cholesky factorisation of the mass matrix, in place and without allocation.

/// `M = L Lᵀ` in storage that is reused every tick. Row-major, lower triangle valid.
#[derive(Clone, Debug)]
pub(crate) struct Cholesky {
    n: usize,
    l: Vec<f64>,
}

impl Cholesky {
    pub(crate) fn new(n: usize) -> Self {
        Self {
            n,
            l: vec![0.0; n * n],
        }
    }

    /// Factorises a symmetric matrix; false if it is not positive definite (or has a NaN).
    pub(crate) fn factorise(&mut self, m: &nalgebra::DMatrix<f64>) -> bool {
        let n = self.n;
        for i in 0..n {
            for j in 0..=i {
                let mut sum = m[(i, j)];
                for k in 0..j {
                    sum -= self.l[i * n + k] * self.l[j * n + k];
                }
                if i == j {
                    // `!(sum > 0)` and not `sum <= 0`: a NaN must fail too.
                    let positive = sum > 0.0;
                    if !positive {
                        return false;
                    }
                    self.l[i * n + i] = sum.sqrt();
                } else {
                    self.l[i * n + j] = sum / self.l[j * n + j];
                }
            }
        }
        true
    }

    /// Replaces the row-major `n × columns` matrix `x` (row stride `stride`) by `M⁻¹ x`.
    ///
    /// Works on whole rows, so that the inner loops run along contiguous memory.
    pub(crate) fn solve_rows(&self, x: &mut [f64], columns: usize, stride: usize) {
        let n = self.n;
        for i in 0..n {
            for k in 0..i {
                subtract_row(x, i, k, self.l[i * n + k], columns, stride);
            }
            scale_row(x, i, 1.0 / self.l[i * n + i], columns, stride);
        }
        for i in (0..n).rev() {
            for k in i + 1..n {
                subtract_row(x, i, k, self.l[k * n + i], columns, stride);
            }
            scale_row(x, i, 1.0 / self.l[i * n + i], columns, stride);
        }
    }
}

/// `x[i] −= factor · x[k]`.
fn subtract_row(x: &mut [f64], i: usize, k: usize, factor: f64, columns: usize, stride: usize) {
    if factor == 0.0 {
        return;
    }
    let (target, source) = if i < k {
        let (head, tail) = x.split_at_mut(k * stride);
        (
            &mut head[i * stride..i * stride + columns],
            &tail[..columns],
        )
    } else {
        let (head, tail) = x.split_at_mut(i * stride);
        (
            &mut tail[..columns],
            &head[k * stride..k * stride + columns],
        )
    };
    for (t, s) in target.iter_mut().zip(source) {
        *t -= factor * s;
    }
}

fn scale_row(x: &mut [f64], i: usize, factor: f64, columns: usize, stride: usize) {
    for t in &mut x[i * stride..i * stride + columns] {
        *t *= factor;
    }
}

#[cfg(test)]
mod tests {
    use super::Cholesky;
    use nalgebra::DMatrix;

    #[test]
    fn solves_several_right_hand_sides_in_rows() {
        let a = DMatrix::from_fn(5, 5, |i, j| ((3 * i + 7 * j) as f64).sin());
        let m = &a * a.transpose() + DMatrix::identity(5, 5);
        let mut cholesky = Cholesky::new(5);
        assert!(cholesky.factorise(&m));
        let (columns, stride) = (3, 4);
        let mut x: Vec<f64> = (0..5 * stride).map(|i| (i as f64).cos()).collect();
        let original = x.clone();
        cholesky.solve_rows(&mut x, columns, stride);
        for i in 0..5 {
            for c in 0..columns {
                let back: f64 = (0..5).map(|k| m[(i, k)] * x[k * stride + c]).sum();
                assert!((back - original[i * stride + c]).abs() < 1e-12);
            }
            assert_eq!(
                x[i * stride + 3],
                original[i * stride + 3],
                "beyond the columns"
            );
        }
    }

    #[test]
    fn refuses_indefinite_and_nan() {
        let mut cholesky = Cholesky::new(2);
        assert!(!cholesky.factorise(&DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 2.0, 1.0])));
        assert!(!cholesky.factorise(&DMatrix::from_element(2, 2, f64::NAN)));
    }
}
