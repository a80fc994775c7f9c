//! An orthogonal matrix as the product of the reflections and rotations that made it.
//!
//! # Mathematics
//! `Qᵀ = T_r ⋯ T_2 T_1`, each `T` a Householder reflection `1 − τ v vᵀ` that acts on the components from `start` on, or
//! a Givens rotation of two neighbours. Applying the product to one vector costs about as much as a product with
//! the matrix, but a new constraint appends one reflection and a dropped one a few rotations, where a matrix would
//! have to be rotated as a whole. Every factor is orthogonal to the last digit, and so is their product.

use super::kernels::{axpy, dot};

#[derive(Clone, Copy, Debug)]
enum Factor {
    /// `tau` and where `v` begins in the store; acts from `start` on.
    Reflect { start: usize, at: usize, tau: f64 },
    /// `[c s; −s c]` on the components `i` and `i + 1`.
    Rotate { i: usize, c: f64, s: f64 },
}

/// The product.
#[derive(Clone, Debug, Default)]
pub(super) struct Orthogonal {
    n: usize,
    factors: Vec<Factor>,
    vectors: Vec<f64>,
    used: usize,
}

impl Orthogonal {
    /// Room for `reflections` in `n` dimensions and as many rotations as `rotations`.
    pub(super) fn new(n: usize, reflections: usize, rotations: usize) -> Self {
        Self {
            n,
            factors: Vec::with_capacity(reflections + rotations),
            vectors: vec![0.0; n * reflections],
            used: 0,
        }
    }

    /// Back to the identity, for vectors of `n` components.
    pub(super) fn reset(&mut self, n: usize) {
        self.n = n;
        self.factors.clear();
        self.used = 0;
    }

    /// Whether another reflection and `rotations` more rotations fit.
    pub(super) fn has_room(&self, rotations: usize) -> bool {
        self.used + self.n <= self.vectors.len()
            && self.factors.len() + 1 + rotations <= self.factors.capacity()
    }

    /// Appends the reflection that maps the components of `w` from `start` on to one, `r e_start`, and applies it.
    /// Call only if there is room, with a `w` that is not zero there.
    pub(super) fn reflect(&mut self, start: usize, w: &mut [f64]) {
        let tail = &mut w[start..self.n];
        let rest = dot(&tail[1..], &tail[1..]);
        if rest == 0.0 {
            return;
        }
        let first = tail[0];
        let norm = (first * first + rest).sqrt();
        let r = if first > 0.0 { -norm } else { norm };
        let v0 = first - r;
        let v = &mut self.vectors[self.used..self.used + tail.len()];
        v[0] = v0;
        v[1..].copy_from_slice(&tail[1..]);
        tail[0] = r;
        tail[1..].fill(0.0);
        // ‖v‖² = 2 r (r − first) = −2 r v0.
        let tau = -1.0 / (r * v0);
        self.factors.push(Factor::Reflect {
            start,
            at: self.used,
            tau,
        });
        self.used += v.len();
    }

    /// Appends the rotation that makes the second of the neighbours `(a, b)` at `i` zero; returns `(c, s, r)` with
    /// `c a + s b = r`.
    pub(super) fn rotate(&mut self, i: usize, a: f64, b: f64) -> (f64, f64, f64) {
        let r = (a * a + b * b).sqrt();
        let (c, s) = if r > 0.0 { (a / r, b / r) } else { (1.0, 0.0) };
        self.factors.push(Factor::Rotate { i, c, s });
        (c, s, r)
    }

    /// How many factors there are.
    pub(super) fn len(&self) -> usize {
        self.factors.len()
    }

    /// `w ← Qᵀ w`, the factors from the given one on.
    pub(super) fn transposed_from(&self, from: usize, w: &mut [f64]) {
        for factor in &self.factors[from..] {
            match *factor {
                Factor::Reflect { start, at, tau } => self.mirror(start, at, tau, w),
                Factor::Rotate { i, c, s } => {
                    (w[i], w[i + 1]) = (c * w[i] + s * w[i + 1], c * w[i + 1] - s * w[i]);
                }
            }
        }
    }

    /// `w ← Qᵀ w`.
    pub(super) fn transposed(&self, w: &mut [f64]) {
        self.transposed_from(0, w);
    }

    /// `z ← Q z`.
    pub(super) fn apply(&self, z: &mut [f64]) {
        for factor in self.factors.iter().rev() {
            match *factor {
                Factor::Reflect { start, at, tau } => self.mirror(start, at, tau, z),
                Factor::Rotate { i, c, s } => {
                    (z[i], z[i + 1]) = (c * z[i] - s * z[i + 1], c * z[i + 1] + s * z[i]);
                }
            }
        }
    }

    fn mirror(&self, start: usize, at: usize, tau: f64, w: &mut [f64]) {
        let v = &self.vectors[at..at + self.n - start];
        let w = &mut w[start..self.n];
        let scale = tau * dot(v, w);
        if scale != 0.0 {
            axpy(w, -scale, v);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Orthogonal;

    #[test]
    fn is_orthogonal_and_inverted_by_its_transpose() {
        let n = 6;
        let mut q = Orthogonal::new(n, 4, 10);
        q.reset(n);
        let vector = |seed: usize| (0..n).map(|i| ((7 * i + 13 * seed) as f64).sin()).collect();
        for start in 0..4 {
            let mut w: Vec<f64> = vector(start);
            let norm = |w: &[f64]| w.iter().map(|w| w * w).sum::<f64>().sqrt();
            let before = norm(&w[start..]);
            q.reflect(start, &mut w);
            assert!((w[start].abs() - before).abs() < 1e-14);
            assert!(w[start + 1..].iter().all(|w| *w == 0.0));
            let (c, s, r) = q.rotate(start, 3.0, 4.0);
            assert!((c * 3.0 + s * 4.0 - r).abs() < 1e-14 && (c * 4.0 - s * 3.0).abs() < 1e-14);
        }
        assert!(!q.has_room(100));
        let original: Vec<f64> = vector(9);
        let mut w = original.clone();
        q.transposed(&mut w);
        let norm = |w: &[f64]| w.iter().map(|w| w * w).sum::<f64>();
        assert!((norm(&w) - norm(&original)).abs() < 1e-14);
        q.apply(&mut w);
        for (w, o) in w.iter().zip(&original) {
            assert!((w - o).abs() < 1e-14);
        }
    }
}
