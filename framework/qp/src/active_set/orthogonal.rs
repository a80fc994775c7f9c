//! An orthogonal matrix as the product of the reflections and rotations that made it.
//!
//! # Mathematics
//! `Qᵀ = T_r ⋯ T_2 T_1`, each `T` a Householder reflection `1 − τ v vᵀ` or a Givens rotation of two neighbours.
//! Applying the product to one vector costs about as much as a product with the matrix, but a new constraint appends
//! one reflection and a dropped one a few rotations, where a matrix would have to be rotated as a whole. Every factor
//! is orthogonal to the last digit, and so is their product.
//!
//! Four reflections that follow one another are drawn together, `T_1 T_2 T_3 T_4 = 1 − V S Vᵀ` with an upper triangle
//! S (the compact form of R. Schreiber, C. Van Loan, *A storage-efficient WY representation for products of Householder
//! transformations*, SIAM J. Sci. Stat. Comput. 10 (1989)): a vector is read twice for the four instead of eight times.

use std::ops::Range;

use super::{
    kernels::{LANES, SMALL, add_rows, axpy, dot, dots, padded},
    simd::{Simd, with_simd},
    triangle::rotation,
};

/// Which part of the components a reflection touches, in whole lanes, and where its vectors begin in the store.
#[derive(Clone, Copy, Debug)]
struct Span {
    from: usize,
    to: usize,
    at: usize,
}

impl Span {
    /// All components instead, of a vector so short that zeros are not worth looking for.
    #[expect(clippy::inline_always, reason = "the stride is to be known")]
    #[inline(always)]
    fn of(self, stride: usize) -> Self {
        if stride <= SMALL {
            Self {
                from: 0,
                to: stride,
                ..self
            }
        } else {
            self
        }
    }

    /// Whether it has components in common with a range, which then grows to hold it.
    fn grow(&self, range: &mut Range<usize>) -> bool {
        let meets = range.start < self.to && self.from < range.end;
        if meets {
            *range = range.start.min(self.from)..range.end.max(self.to);
        }
        meets
    }
}

#[derive(Clone, Copy, Debug)]
enum Factor {
    Reflect {
        span: Span,
        tau: f64,
    },
    /// Four reflections; the index of their triangle.
    Panel {
        span: Span,
        triangle: usize,
    },
    /// Rotations `[c s; −s c]` of the components `first` and `first + 1`, then of `first + 1` and `first + 2`, and so
    /// on.
    Rotate {
        first: usize,
        at: usize,
        count: usize,
    },
}

/// The product.
#[derive(Clone, Debug, Default)]
pub(super) struct Orthogonal {
    simd: Simd,
    n: usize,
    /// n with padding.
    stride: usize,
    factors: Vec<Factor>,
    vectors: Vec<f64>,
    used: usize,
    /// Rows of S.
    triangles: Vec<[[f64; 4]; 4]>,
    /// c and s.
    rotations: Vec<(f64, f64)>,
}

impl Orthogonal {
    /// Room for `reflections` in `n` dimensions and as many rotations as `rotations`, and for n runs of them per
    /// reflection.
    pub(super) fn new(n: usize, reflections: usize, rotations: usize, simd: Simd) -> Self {
        Self {
            simd,
            n,
            stride: padded(n),
            factors: Vec::with_capacity(5 * reflections),
            vectors: vec![0.0; padded(n) * reflections],
            used: 0,
            triangles: Vec::with_capacity(reflections / 4),
            rotations: Vec::with_capacity(rotations),
        }
    }

    /// Back to the identity, for vectors of `n` components.
    pub(super) fn reset(&mut self, n: usize) {
        self.n = n;
        self.stride = padded(n);
        self.factors.clear();
        self.triangles.clear();
        self.rotations.clear();
        self.used = 0;
    }

    /// Whether another reflection and `rotations` more rotations in n runs fit.
    pub(super) fn has_room(&self, rotations: usize) -> bool {
        self.used + self.stride <= self.vectors.len()
            && self.factors.len() + 1 + self.n <= self.factors.capacity()
            && self.triangles.len() < self.triangles.capacity()
            && self.rotations.len() + rotations <= self.rotations.capacity()
    }

    /// Appends the reflection that maps the components of `w` from `start` on to one, `r e_start`, and applies it to
    /// `w` and to `other`. `rest` is the sum of the squares beyond `start`. Call only if there is room, with a `w` that
    /// is not zero there.
    pub(super) fn reflect(&mut self, start: usize, rest: f64, w: &mut [f64], other: &mut [f64]) {
        if rest == 0.0 {
            return;
        }
        let first = w[start];
        let norm = (first * first + rest).sqrt();
        let r = if first > 0.0 { -norm } else { norm };
        let v0 = first - r;
        let at = self.used;
        self.used += self.stride;
        let v = &mut self.vectors[at..self.used];
        v[..start].fill(0.0);
        v[start..].copy_from_slice(&w[start..]);
        v[start] = v0;
        w[start] = r;
        w[start + 1..].fill(0.0);
        let to = if self.stride <= SMALL {
            self.stride
        } else {
            padded(v.iter().rposition(|v| *v != 0.0).unwrap_or(start) + 1)
        };
        let span = Span {
            from: start - start % LANES,
            to,
            at,
        };
        // ‖v‖² = 2 r (r − first) = −2 r v0.
        let tau = -1.0 / (r * v0);
        with_simd!(self.simd, mirror(&self.vectors, span, tau, other));
        self.factors.push(Factor::Reflect { span, tau });
        self.draw_together();
    }

    /// Replaces the last factors by a panel if they are four reflections.
    fn draw_together(&mut self) {
        let &[
            ..,
            Factor::Reflect { span: a, tau: t0 },
            Factor::Reflect { span: b, tau: t1 },
            Factor::Reflect { span: c, tau: t2 },
            Factor::Reflect { span: d, tau: t3 },
        ] = &self.factors[..]
        else {
            return;
        };
        let span = Span {
            from: a.from.min(b.from).min(c.from).min(d.from),
            to: a.to.max(b.to).max(c.to).max(d.to),
            at: a.at,
        };
        let (v, stride) = (self.panel(span), self.stride);
        let products = |j| dots(v, stride, &v[j * stride..j * stride + span.to - span.from]);
        let (g1, g2, g3) = (products(1), products(2), products(3));
        let mut s = [[0.0; 4]; 4];
        s[0][0] = t0;
        s[1][1] = t1;
        s[2][2] = t2;
        s[3][3] = t3;
        for (j, g) in [(1, g1), (2, g2), (3, g3)] {
            for i in 0..j {
                let sum: f64 = (i..j).map(|l| s[i][l] * g[l]).sum();
                s[i][j] = -s[j][j] * sum;
            }
        }
        let triangle = self.triangles.len();
        self.triangles.push(s);
        self.factors.truncate(self.factors.len() - 4);
        self.factors.push(Factor::Panel { span, triangle });
    }

    /// The vectors of a panel, from the first component that is touched.
    fn panel(&self, span: Span) -> &[f64] {
        &self.vectors[span.at + span.from..]
    }

    /// Begins a run of rotations, whose first acts on `first` and its neighbour.
    pub(super) fn begin_rotations(&mut self, first: usize) {
        let at = self.rotations.len();
        self.factors.push(Factor::Rotate {
            first,
            at,
            count: 0,
        });
    }

    /// Appends a rotation to the run: the one that makes the second of the neighbours `(a, b)` zero; returns
    /// `(c, s, r)` with `c a + s b = r`.
    pub(super) fn rotate(&mut self, a: f64, b: f64) -> (f64, f64, f64) {
        let (c, s, r) = rotation(a, b);
        if let Some(Factor::Rotate { count, .. }) = self.factors.last_mut() {
            *count += 1;
            self.rotations.push((c, s));
        }
        (c, s, r)
    }

    /// `w ← Qᵀ w`, for a w that is zero outside of a range of whole lanes. Where it is zero, nothing is reflected.
    pub(super) fn transposed(&self, range: Range<usize>, w: &mut [f64]) {
        with_simd!(
            self.simd,
            match self.stride {
                8 => self.transposed_with(8, range, w),
                12 => self.transposed_with(12, range, w),
                16 => self.transposed_with(16, range, w),
                stride => self.transposed_with(stride, range, w),
            }
        );
    }

    #[expect(clippy::inline_always, reason = "the stride is to be known")]
    #[inline(always)]
    fn transposed_with(&self, stride: usize, mut range: Range<usize>, w: &mut [f64]) {
        let w = &mut w[..stride];
        for factor in &self.factors {
            match *factor {
                Factor::Reflect { span, tau } => {
                    let span = span.of(stride);
                    if span.grow(&mut range) {
                        mirror(&self.vectors, span, tau, w);
                    }
                }
                Factor::Panel { span, triangle } => {
                    let span = span.of(stride);
                    if !span.grow(&mut range) {
                        continue;
                    }
                    let v = self.panel(span);
                    let w = &mut w[span.from..span.to];
                    let y = dots(v, stride, w);
                    let s = &self.triangles[triangle];
                    let alpha = [
                        -(s[0][0] * y[0]),
                        -(s[0][1] * y[0] + s[1][1] * y[1]),
                        -((s[0][2] * y[0] + s[1][2] * y[1]) + s[2][2] * y[2]),
                        -((s[0][3] * y[0] + s[1][3] * y[1]) + (s[2][3] * y[2] + s[3][3] * y[3])),
                    ];
                    add_rows(w, alpha, v, stride);
                }
                Factor::Rotate { first, at, count } => {
                    let span = Span {
                        from: first,
                        to: first + count + 1,
                        at,
                    };
                    if !span.grow(&mut range) {
                        continue;
                    }
                    let w = &mut w[span.from..span.to];
                    // What the next rotation needs stays in a register.
                    let mut carried = w[0];
                    for (i, &(c, s)) in self.rotations[at..at + count].iter().enumerate() {
                        let next = w[i + 1];
                        w[i] = c * carried + s * next;
                        carried = c * next - s * carried;
                    }
                    w[count] = carried;
                }
            }
        }
    }

    /// `z ← Q z`.
    pub(super) fn apply(&self, z: &mut [f64]) {
        with_simd!(
            self.simd,
            match self.stride {
                8 => self.apply_with(8, z),
                12 => self.apply_with(12, z),
                16 => self.apply_with(16, z),
                stride => self.apply_with(stride, z),
            }
        );
    }

    #[expect(clippy::inline_always, reason = "the stride is to be known")]
    #[inline(always)]
    fn apply_with(&self, stride: usize, z: &mut [f64]) {
        let z = &mut z[..stride];
        for factor in self.factors.iter().rev() {
            match *factor {
                Factor::Reflect { span, tau } => mirror(&self.vectors, span.of(stride), tau, z),
                Factor::Panel { span, triangle } => {
                    let span = span.of(stride);
                    let v = self.panel(span);
                    let z = &mut z[span.from..span.to];
                    let y = dots(v, stride, z);
                    let alpha = self.triangles[triangle]
                        .map(|s| -((s[0] * y[0] + s[1] * y[1]) + (s[2] * y[2] + s[3] * y[3])));
                    add_rows(z, alpha, v, stride);
                }
                Factor::Rotate { first, at, count } => {
                    let z = &mut z[first..=first + count];
                    let mut carried = z[count];
                    for (i, &(c, s)) in self.rotations[at..at + count].iter().enumerate().rev() {
                        let before = z[i];
                        z[i + 1] = c * carried + s * before;
                        carried = c * before - s * carried;
                    }
                    z[0] = carried;
                }
            }
        }
    }
}

/// `w ← (1 − τ v vᵀ) w`.
#[expect(clippy::inline_always, reason = "the stride is to be known")]
#[inline(always)]
fn mirror(vectors: &[f64], span: Span, tau: f64, w: &mut [f64]) {
    let v = &vectors[span.at + span.from..span.at + span.to];
    let w = &mut w[span.from..span.to];
    let scale = tau * dot(v, w);
    if scale != 0.0 {
        axpy(w, -scale, v);
    }
}

#[cfg(test)]
mod tests {
    use super::{Orthogonal, Simd};

    #[test]
    fn is_orthogonal_and_inverted_by_its_transpose() {
        let n = 12;
        let mut q = Orthogonal::new(n, 8, 10, Simd::detect());
        q.reset(n);
        let vector = |seed: usize| (0..n).map(|i| ((7 * i + 13 * seed) as f64).sin()).collect();
        let norm = |w: &[f64]| w.iter().map(|w| w * w).sum::<f64>().sqrt();
        let mut sum: Vec<f64> = vector(8);
        let mut reflected = sum.clone();
        for start in 0..8 {
            let mut w: Vec<f64> = vector(start);
            let before = norm(&w[start..]);
            let rest = norm(&w[start + 1..]).powi(2);
            q.reflect(start, rest, &mut w, &mut reflected);
            assert!((w[start].abs() - before).abs() < 1e-14);
            assert!(w[start + 1..].iter().all(|w| *w == 0.0));
        }
        // Drawn together they do what each did.
        q.transposed(0..n, &mut sum);
        for (a, b) in sum.iter().zip(&reflected) {
            assert!((a - b).abs() < 1e-14, "{sum:?} {reflected:?}");
        }
        q.begin_rotations(3);
        for _ in 0..4 {
            let (c, s, r) = q.rotate(3.0, 4.0);
            assert!((c * 3.0 + s * 4.0 - r).abs() < 1e-14 && (c * 4.0 - s * 3.0).abs() < 1e-14);
        }
        assert!(!q.has_room(100));
        let original: Vec<f64> = vector(9);
        let mut w = original.clone();
        q.transposed(0..n, &mut w);
        assert!((norm(&w) - norm(&original)).abs() < 1e-14);
        q.apply(&mut w);
        for (w, o) in w.iter().zip(&original) {
            assert!((w - o).abs() < 1e-14);
        }
    }
}
