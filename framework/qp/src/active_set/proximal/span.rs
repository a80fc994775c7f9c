//! An orthonormal basis of what vectors span, up to their rounding.
//!
//! # Mathematics
//! Gram–Schmidt in its modified form, with the vector of which most is left taken next, and twice, which leaves the
//! basis orthogonal to rounding (L. Giraud, J. Langou, M. Rozložník, *The loss of orthogonality in the Gram–Schmidt
//! orthogonalization process*, Computers & Mathematics with Applications 50 (2005)). Strong vectors come before weak
//! ones, so that what a weak one adds to the span is measured against everything that is known better.

use super::super::kernels::{axpy, dot, scale};

/// What is left of a vector of length one is rounding below this, for each variable.
const NOTHING: f64 = 4e-15;

#[derive(Clone, Debug)]
pub(super) struct Span {
    n: usize,
    count: usize,
    rank: usize,
    /// First the basis, then what is left of the others: one vector of n numbers after the other.
    vectors: Vec<f64>,
}

impl Span {
    /// For up to so many vectors.
    pub(super) fn new(n: usize, vectors: usize) -> Self {
        Self {
            n,
            count: 0,
            rank: 0,
            vectors: vec![0.0; n * vectors],
        }
    }

    /// No vectors of n numbers.
    pub(super) fn clear(&mut self, n: usize) {
        (self.n, self.count, self.rank) = (n, 0, 0);
    }

    /// Room for a further vector, whose rounding is that of one of length one; nothing if there is none left.
    pub(super) fn push(&mut self) -> Option<&mut [f64]> {
        let at = self.count * self.n;
        let vector = self.vectors.get_mut(at..at + self.n)?;
        self.count += 1;
        Some(vector)
    }

    /// Makes the basis.
    pub(super) fn orthogonalise(&mut self) {
        let n = self.n;
        let least = NOTHING * n as f64;
        self.rank = 0;
        while self.rank < self.count.min(n) {
            let k = self.rank;
            let vectors = &mut self.vectors[..self.count * n];
            let rest = vectors.chunks_exact(n).enumerate().skip(k);
            let lengths = rest.map(|(i, v)| (i, dot(v, v)));
            let longest = lengths.max_by(|a, b| a.1.total_cmp(&b.1));
            let Some((i, square)) = longest.filter(|(_, square)| square.sqrt() > least) else {
                return;
            };
            if i != k {
                let (head, tail) = vectors.split_at_mut(i * n);
                head[k * n..(k + 1) * n].swap_with_slice(&mut tail[..n]);
            }
            let (basis, rest) = vectors.split_at_mut(k * n);
            let (next, rest) = rest.split_at_mut(n);
            scale(next, 1.0 / square.sqrt());
            for q in basis.chunks_exact(n) {
                let along = dot(q, next);
                axpy(next, -along, q);
            }
            let length = dot(next, next).sqrt();
            scale(next, 1.0 / length);
            for v in rest.chunks_exact_mut(n) {
                let along = dot(next, v);
                axpy(v, -along, next);
            }
            self.rank = k + 1;
        }
    }

    /// How many vectors it has.
    pub(super) fn rank(&self) -> usize {
        self.rank
    }

    /// The basis, one vector after the other.
    pub(super) fn basis(&self) -> impl Iterator<Item = &[f64]> {
        self.vectors[..self.rank * self.n].chunks_exact(self.n.max(1))
    }

    /// Takes away from a vector what is within the span.
    pub(super) fn project_out(&self, v: &mut [f64]) {
        for _ in 0..2 {
            for q in self.basis() {
                let along = dot(q, v);
                axpy(v, -along, q);
            }
        }
    }
}
