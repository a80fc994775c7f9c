//! The face of the feasible set on which some constraints hold, and where the cost falls on it.
//!
//! # Mathematics
//! The columns of Z are an orthonormal basis of the directions that leave the constraints held where they are, and
//! `M = Zᵀ H Z` is the cost's curvature along them. A further constraint with `a_Z = Zᵀ a` turns the basis by a
//! reflection P with `P a_Z = α e₁`: `Z ← Z P`, `M ← P M P`, and the first direction is dropped.
//!
//! The factorisation `M = Lᵀ L` with pivoting stops where what is left is rounding: there the cost is flat. With the
//! gradient `r = Zᵀ (H x + g)` the step to the minimiser solves `M p = −r` on the curved part. If r has a rest on the
//! flat one, the cost falls for ever along the direction whose curvature is zero and whose slope is that rest: a ray.

use super::super::kernels::{axpy, dot};

/// Curvature below this part of the largest, for each direction of the face, is rounding.
const FLAT: f64 = 4e-15;
/// A negative pivot, or an entry beside a pivot of zero, beyond this part of the largest curvature is no rounding.
const INDEFINITE: f64 = 1e-9;
/// Corrections of a ray by the curvature that rounding left along it.
const REFINEMENTS: u32 = 2;
/// Sine of the angle to the constraints held below which a constraint depends on them.
const DEPENDENT: f64 = 1e-9;

#[derive(Clone, Debug)]
pub(super) struct Face {
    n: usize,
    /// Directions.
    count: usize,
    /// The basis, one vector of n numbers after the other.
    z: Vec<f64>,
    /// `ZᵀHZ`, count × count with a stride of n.
    m: Vec<f64>,
    factor: Vec<f64>,
    pivots: Vec<usize>,
    /// How many of them have curvature, if the factor is that of M.
    rank: Option<usize>,
    /// `Zᵀ a`, gradients and steps.
    reduced: Vec<f64>,
    work: Vec<f64>,
    /// The direction found last.
    direction: Vec<f64>,
    /// Largest entry of H.
    curvature: f64,
}

impl Face {
    pub(super) fn new(n: usize) -> Self {
        Self {
            n,
            count: 0,
            z: vec![0.0; n * n],
            m: vec![0.0; n * n],
            factor: vec![0.0; n * n],
            pivots: vec![0; n],
            rank: None,
            reduced: vec![0.0; n],
            work: vec![0.0; n],
            direction: vec![0.0; n],
            curvature: 0.0,
        }
    }

    /// All of the space.
    pub(super) fn reset(&mut self, n: usize, h: &[f64]) {
        (self.n, self.count) = (n, n);
        self.rank = None;
        self.z[..n * n].fill(0.0);
        for j in 0..n {
            self.z[j * n + j] = 1.0;
        }
        self.m[..n * n].copy_from_slice(h);
        self.curvature = (0..n).fold(0.0, |a, j| a.max(h[j * n + j]));
    }

    /// Largest diagonal entry of H.
    pub(super) fn curvature(&self) -> f64 {
        self.curvature
    }

    /// The direction that [`Face::ray`] or [`Face::step`] found.
    pub(super) fn direction(&self) -> &[f64] {
        &self.direction[..self.n]
    }

    /// The direction, to be chosen.
    pub(super) fn direction_mut(&mut self) -> &mut [f64] {
        &mut self.direction[..self.n]
    }

    /// Leaves the directions along which a constraint stays where it is; false if those before do so already.
    pub(super) fn confine(&mut self, normal: &[f64]) -> bool {
        let (n, count) = (self.n, self.count);
        if count == 0 {
            return false;
        }
        let v = &mut self.reduced[..count];
        for (v, z) in v.iter_mut().zip(self.z.chunks_exact(n)) {
            *v = dot(z, normal);
        }
        let size = dot(v, v).sqrt();
        if size <= DEPENDENT * dot(normal, normal).sqrt() {
            return false;
        }
        // P = 1 − 2 v vᵀ / vᵀv.
        v[0] += if v[0] < 0.0 { -size } else { size };
        let scale = 2.0 / dot(v, v);
        let w = &mut self.work[..n];
        w.fill(0.0);
        for (v, z) in v.iter().zip(self.z.chunks_exact(n)) {
            axpy(w, *v, z);
        }
        for (v, z) in v.iter().zip(self.z.chunks_exact_mut(n)) {
            axpy(z, -scale * v, w);
        }
        // M ← M − v qᵀ − q vᵀ with q = s (M v − ½ s (vᵀ M v) v).
        let w = &mut self.work[..count];
        for (w, row) in w.iter_mut().zip(self.m.chunks_exact(n)) {
            *w = dot(&row[..count], v);
        }
        let half = 0.5 * scale * dot(v, w);
        for (w, v) in w.iter_mut().zip(&*v) {
            *w = scale * (*w - half * v);
        }
        for (i, row) in self.m.chunks_exact_mut(n).take(count).enumerate() {
            let row = &mut row[..count];
            axpy(row, -v[i], w);
            axpy(row, -w[i], v);
        }
        // Without the first.
        let last = count - 1;
        self.z.copy_within(n..count * n, 0);
        for i in 0..last {
            let from = (i + 1) * n + 1;
            self.m.copy_within(from..from + last, i * n);
        }
        self.count = last;
        self.rank = None;
        true
    }

    /// Whether there is a direction without curvature along which the cost may fall, given its gradient:
    /// [`Face::direction`].
    pub(super) fn ray(&mut self, gradient: &[f64]) -> bool {
        let (n, count) = (self.n, self.count);
        let rank = self.eliminate(gradient);
        let w = &mut self.work[..count];
        if w[rank..].iter().all(|w| *w == 0.0) {
            return false;
        }
        // The curved part follows the flat one so that the curvature is zero: L₁₁ p₁ = −L₁₂ p₂.
        let (head, tail) = w.split_at_mut(rank);
        for (k, head) in head.iter_mut().enumerate() {
            *head = -dot(&self.factor[k * n + rank..k * n + count], tail);
        }
        solve_upper(&self.factor, n, rank, w);
        for _ in 0..REFINEMENTS {
            self.flatten(rank);
        }
        self.combine();
        true
    }

    /// Whether there is a step to where the cost is least along all directions with curvature, given its gradient:
    /// [`Face::direction`].
    pub(super) fn step(&mut self, gradient: &[f64]) -> bool {
        let rank = self.eliminate(gradient);
        let w = &mut self.work[..self.count];
        w[rank..].fill(0.0);
        solve_upper(&self.factor, self.n, rank, w);
        self.combine();
        rank > 0
    }

    /// Solves with Lᵀ for the slope along the directions, as far as there is curvature: what is left of it, in `work`,
    /// is the slope of what is flat. Returns how many have curvature.
    fn eliminate(&mut self, gradient: &[f64]) -> usize {
        let (n, count) = (self.n, self.count);
        let rank = match self.rank {
            Some(rank) => rank,
            None => self.factorise(),
        };
        self.rank = Some(rank);
        let z = &self.z;
        let w = &mut self.work[..count];
        for (w, &p) in w.iter_mut().zip(&self.pivots) {
            *w = -dot(&z[p * n..(p + 1) * n], gradient);
        }
        for k in 0..rank {
            let row = &self.factor[k * n..k * n + count];
            w[k] /= row[k];
            let value = w[k];
            axpy(&mut w[k + 1..], -value, &row[k + 1..]);
        }
        rank
    }

    /// The direction from its components in `work`.
    fn combine(&mut self) {
        let n = self.n;
        self.direction[..n].fill(0.0);
        for (w, &p) in self.work[..self.count].iter().zip(&self.pivots) {
            axpy(&mut self.direction[..n], *w, &self.z[p * n..(p + 1) * n]);
        }
    }

    /// Corrects the curved part of the direction in `work` by the curvature that is left along it.
    fn flatten(&mut self, rank: usize) {
        let (n, count) = (self.n, self.count);
        let (w, rest) = (&mut self.work[..count], &mut self.reduced[..count]);
        for (k, rest) in rest[..rank].iter_mut().enumerate() {
            let row = &self.m[self.pivots[k] * n..];
            *rest = -w
                .iter()
                .zip(&self.pivots)
                .map(|(w, &p)| w * row[p])
                .sum::<f64>();
        }
        for k in 0..rank {
            let row = &self.factor[k * n..k * n + rank];
            rest[k] /= row[k];
            let value = rest[k];
            axpy(&mut rest[k + 1..rank], -value, &row[k + 1..]);
        }
        solve_upper(&self.factor, n, rank, rest);
        axpy(&mut w[..rank], 1.0, &rest[..rank]);
    }

    /// `P M Pᵀ = Lᵀ L` with the largest diagonal first; returns how many pivots are more than rounding.
    fn factorise(&mut self) -> usize {
        let (n, count) = (self.n, self.count);
        let pivots = &mut self.pivots[..count];
        for (k, pivot) in pivots.iter_mut().enumerate() {
            *pivot = k;
        }
        for (factor, m) in self
            .factor
            .chunks_exact_mut(n)
            .zip(self.m.chunks_exact(n))
            .take(count)
        {
            factor[..count].copy_from_slice(&m[..count]);
        }
        let least = FLAT * count as f64 * self.curvature;
        let f = &mut self.factor;
        for k in 0..count {
            let best = (k..count).max_by(|&a, &b| f[a * n + a].total_cmp(&f[b * n + b]));
            let best = best.unwrap_or(k);
            if f[best * n + best] <= least {
                return k;
            }
            if best != k {
                pivots.swap(k, best);
                // Rows, then columns, of all there is.
                let (head, tail) = f.split_at_mut(best * n);
                head[k * n..k * n + count].swap_with_slice(&mut tail[..count]);
                for row in f.chunks_exact_mut(n).take(count) {
                    row.swap(k, best);
                }
            }
            let (head, tail) = f.split_at_mut((k + 1) * n);
            let row = &mut head[k * n..k * n + count];
            let reciprocal = 1.0 / row[k].sqrt();
            for value in &mut row[k..] {
                *value *= reciprocal;
            }
            for (i, target) in tail.chunks_exact_mut(n).take(count - k - 1).enumerate() {
                let factor = row[k + 1 + i];
                axpy(&mut target[k + 1..count], -factor, &row[k + 1..]);
            }
        }
        count
    }
}

/// Replaces the first entries of `w` by `L⁻¹` of them; L is upper triangular.
fn solve_upper(factor: &[f64], stride: usize, rank: usize, w: &mut [f64]) {
    for k in (0..rank).rev() {
        let row = &factor[k * stride..k * stride + rank];
        w[k] = (w[k] - dot(&row[k + 1..], &w[k + 1..rank])) / row[k];
    }
}

impl Face {
    /// A variable at which the factorisation of `M` shows a negative eigenvalue, if there is one beyond rounding.
    pub(super) fn indefinite(&mut self) -> Option<usize> {
        let (n, count) = (self.n, self.count);
        let rank = self.factorise();
        let least = INDEFINITE * self.curvature;
        let rest = self
            .factor
            .chunks_exact(n)
            .take(count)
            .enumerate()
            .skip(rank);
        for (i, row) in rest {
            let entries = row[rank..count].iter().enumerate();
            for (j, entry) in entries {
                if *entry < -least || (i != rank + j && entry.abs() > least) {
                    return Some(self.pivots[i]);
                }
            }
        }
        None
    }
}
