//! The constraints that are held, and the least-distance solution on them.
//!
//! # Mathematics
//! With `z = U x` and `v = U⁻ᵀ g` the problem on the held constraints is `min ½‖z + v‖²` subject to `Wᵀ z = b`, the
//! columns of W being `w = U⁻ᵀ a`. The factorisation `W = Q [R; 0]` gives
//! ```text
//! z = Q [z₁; −(Qᵀv)₂],   Rᵀ z₁ = b,   R λ = −(z₁ + (Qᵀv)₁)
//! ```
//! A constraint appends a column: its components beyond the k-th are reflected on to one. One that leaves makes R
//! Hessenberg, and rotations make it triangular again (Goldfarb and Idnani 1983 update the same factorisation).
//! `Wᵀ W` is never formed: it would square the condition number, and a weakly weighted direction makes all
//! constraints look alike then.

use std::ops::Range;

use super::{
    constraint::Active,
    hessian::Hessian,
    kernels::{LANES, add_rows, axpy, dot, dots, padded, squares_after},
    orthogonal::Orthogonal,
};

/// Sine of the angle to the held constraints below which a constraint depends on them.
pub(super) const DEPENDENT: f64 = 1e-10;

#[derive(Clone, Debug, Default)]
pub(super) struct WorkingSet {
    n: usize,
    /// n with padding.
    stride: usize,
    active: Vec<Active>,
    /// Per held constraint `‖w‖²`.
    squares: Vec<f64>,
    q: Orthogonal,
    /// Row k holds column k of R: k + 1 entries.
    r: Vec<f64>,
    /// `1/R_kk`.
    reciprocal: Vec<f64>,
    /// `Qᵀ v`.
    v: Vec<f64>,
    /// The first `known` entries are valid.
    z1: Vec<f64>,
    known: usize,
    /// Multipliers, dual feasible.
    pub(super) multipliers: Vec<f64>,
    /// Multipliers of the solution on the held constraints, or how a dependent one combines from them.
    targets: Vec<f64>,
}

impl WorkingSet {
    pub(super) fn new(n: usize) -> Self {
        Self {
            n: 0,
            stride: 0,
            active: Vec::with_capacity(n + 1),
            squares: Vec::with_capacity(n + 1),
            q: Orthogonal::new(n, n + n / 2 + 4, 8 * n * n + 16),
            r: vec![0.0; padded(n) * n],
            reciprocal: vec![0.0; n],
            v: vec![0.0; padded(n)],
            z1: vec![0.0; n],
            known: 0,
            multipliers: Vec::with_capacity(n + 1),
            targets: vec![0.0; n],
        }
    }

    /// Nothing held; `v = U⁻ᵀ g`, padded, of n components.
    pub(super) fn reset(&mut self, n: usize, v: &[f64]) {
        self.n = n;
        self.stride = v.len();
        self.active.clear();
        self.squares.clear();
        self.multipliers.clear();
        self.q.reset(self.n);
        self.v[..v.len()].copy_from_slice(v);
        self.known = 0;
    }

    pub(super) fn active(&self) -> &[Active] {
        &self.active
    }

    /// The constraints held with their multipliers.
    pub(super) fn held_mut(&mut self) -> impl Iterator<Item = (&Active, &mut f64)> {
        self.active.iter().zip(&mut self.multipliers)
    }

    pub(super) fn len(&self) -> usize {
        self.active.len()
    }

    /// Whether a constraint can be held, and any number of them dropped, before the factorisation has to be made anew.
    pub(super) fn has_room(&self) -> bool {
        self.q.has_room(self.n * (self.n + 1) / 2)
    }

    /// Holds a constraint whose `w` is given, zero outside of a range, with the multiplier it has so far. False if the
    /// sine of its angle to those held is at most `sine`: then `w` is left as `Qᵀ w`, whose first entries give the
    /// combination.
    pub(super) fn push(
        &mut self,
        constraint: Active,
        multiplier: f64,
        sine: f64,
        (range, w): (Range<usize>, &mut [f64]),
    ) -> bool {
        let k = self.len();
        self.q.transposed(range, w);
        if k == self.n {
            return false;
        }
        let rest = squares_after(k, w);
        let beyond = w[k] * w[k] + rest;
        let size = dot(w, w);
        // `!(beyond > …)`: a NaN depends, too.
        let independent = beyond > sine * sine * size;
        if !independent {
            return false;
        }
        self.q.reflect(k, rest, w, &mut self.v[..self.stride]);
        let at = k * self.stride;
        self.r[at..=at + k].copy_from_slice(&w[..=k]);
        self.reciprocal[k] = 1.0 / w[k];
        self.active.push(constraint);
        self.squares.push(size);
        self.multipliers.push(multiplier);
        true
    }

    /// Lets the j-th constraint go.
    pub(super) fn remove(&mut self, j: usize) -> Active {
        let n = self.stride;
        let removed = self.active.remove(j);
        self.squares.remove(j);
        self.multipliers.remove(j);
        let k = self.len();
        for i in j..k {
            let from = (i + 1) * n;
            self.r.copy_within(from..from + i + 2, i * n);
        }
        if j < k {
            self.q.begin_rotations(j);
        }
        for i in j..k {
            let at = i * n + i;
            let (c, s, r) = self.q.rotate(self.r[at], self.r[at + 1]);
            self.r[at] = r;
            self.reciprocal[i] = 1.0 / r;
            for row in self.r[(i + 1) * n..k * n].chunks_exact_mut(n) {
                (row[i], row[i + 1]) = (c * row[i] + s * row[i + 1], c * row[i + 1] - s * row[i]);
            }
            let v = &mut self.v;
            (v[i], v[i + 1]) = (c * v[i] + s * v[i + 1], c * v[i + 1] - s * v[i]);
        }
        self.known = self.known.min(j);
        removed
    }

    /// Computes the multipliers of the least-distance solution on the held constraints: [`WorkingSet::computed`].
    pub(super) fn find_targets(&mut self) {
        let k = self.len();
        for (z, held) in self.z1[self.known..]
            .iter_mut()
            .zip(&self.active[self.known..])
        {
            *z = held.limit;
        }
        solve_rows(
            self.known,
            &self.r,
            self.stride,
            &self.reciprocal[..k],
            &mut self.z1,
        );
        self.known = k;
        let (targets, z1) = (&mut self.targets[..k], &self.z1[..k]);
        for (t, (z, v)) in targets.iter_mut().zip(z1.iter().zip(&self.v)) {
            *t = -(z + v);
        }
        self.solve_r(k);
    }

    /// What [`WorkingSet::find_targets`] or [`WorkingSet::combine`] computed last, per held constraint.
    pub(super) fn computed(&self) -> &[f64] {
        &self.targets[..self.len()]
    }

    /// `targets ← R⁻¹ targets`.
    fn solve_r(&mut self, k: usize) {
        let (r, stride) = (&self.r, self.stride);
        let whole = k - k % LANES;
        for i in (whole..k).rev() {
            let (head, tail) = self.targets.split_at_mut(i);
            tail[0] *= self.reciprocal[i];
            axpy(head, -tail[0], &r[i * stride..i * stride + i]);
        }
        for first in (0..whole).step_by(LANES).rev() {
            let (head, t) = self.targets.split_at_mut(first);
            let at = first * stride;
            let [_, r1, r2, r3] = [0, 1, 2, 3].map(|i| &r[at + i * stride + first..][..LANES]);
            let by = &self.reciprocal[first..first + LANES];
            let t = &mut t[..LANES];
            t[3] *= by[3];
            t[2] = (t[2] - r3[2] * t[3]) * by[2];
            t[1] = ((t[1] - r3[1] * t[3]) - r2[1] * t[2]) * by[1];
            t[0] = (((t[0] - r3[0] * t[3]) - r2[0] * t[2]) - r1[0] * t[1]) * by[0];
            let alpha = [-t[0], -t[1], -t[2], -t[3]];
            add_rows(head, alpha, &r[at..], stride);
        }
    }

    /// Computes `R⁻¹` of the first entries of `Qᵀ w`: how a dependent constraint combines from those held.
    pub(super) fn combine(&mut self, transformed: &[f64]) {
        let k = self.len();
        self.targets[..k].copy_from_slice(&transformed[..k]);
        self.solve_r(k);
    }

    /// Replaces `a` by `Qᵀ U⁻ᵀ a` and computes how the part of it along the held constraints combines from them.
    pub(super) fn project(&mut self, hessian: &Hessian, a: &mut [f64]) {
        let range = hessian.solve_transposed(a);
        self.q.transposed(range, a);
        self.combine(a);
    }

    /// Lengths of the held constraints' normals in the metric of H: a combination's parts, times these, can be
    /// compared.
    pub(super) fn lengths(&self) -> impl Iterator<Item = f64> {
        self.squares.iter().map(|square| square.sqrt())
    }

    /// Takes a combination that was corrected.
    pub(super) fn take_combination(&mut self, combination: &[f64]) {
        self.targets[..combination.len()].copy_from_slice(combination);
    }

    /// Changes the multipliers along the last combination, by `−step` times it.
    pub(super) fn follow_ray(&mut self, step: f64) {
        for (m, r) in self.multipliers.iter_mut().zip(&self.targets) {
            *m -= step * r;
        }
    }

    /// The targets of the last call of [`WorkingSet::find_targets`] become the multipliers.
    pub(super) fn accept_targets(&mut self) {
        self.multipliers
            .copy_from_slice(&self.targets[..self.active.len()]);
    }

    /// Goes the part `α` of the way to the targets.
    pub(super) fn approach_targets(&mut self, alpha: f64) {
        for (m, t) in self.multipliers.iter_mut().zip(&self.targets) {
            *m += alpha * (t - *m);
        }
    }

    /// The `x` that belongs to the targets.
    pub(super) fn primal(&self, hessian: &Hessian, x: &mut [f64]) {
        let k = self.len();
        x[..k].copy_from_slice(&self.z1[..k]);
        for (x, v) in x[k..].iter_mut().zip(&self.v[k..]) {
            *x = -v;
        }
        self.q.apply(x);
        hessian.solve(x);
    }

    /// The `x` that minimises the cost with the multipliers at hand as prices.
    pub(super) fn primal_of_multipliers(&self, hessian: &Hessian, x: &mut [f64]) {
        for (x, v) in x.iter_mut().zip(&self.v) {
            *x = -v;
        }
        for (i, &m) in self.multipliers.iter().enumerate() {
            let at = i * self.stride;
            axpy(&mut x[..=i], -m, &self.r[at..=at + i]);
        }
        self.q.apply(x);
        hessian.solve(x);
    }

    /// Solves `[H̃ A_aᵀ; A_a 0] [dx; dλ] = [−d; p]`: replaces `d` by `dx` and `p` (one entry per held constraint) by
    /// `dλ`.
    pub(super) fn correct(&mut self, hessian: &Hessian, d: &mut [f64], p: &mut [f64]) {
        let k = self.len();
        if d.iter().any(|d| *d != 0.0) {
            let range = hessian.solve_transposed(d);
            self.q.transposed(range, d);
        }
        solve_rows(0, &self.r, self.stride, &self.reciprocal[..k], p);
        for (t, (p, d)) in self.targets.iter_mut().zip(p.iter().zip(&*d)) {
            *t = -(p + d);
        }
        self.solve_r(k);
        d[..k].copy_from_slice(&p[..k]);
        for d in &mut d[k..] {
            *d = -*d;
        }
        self.q.apply(d);
        hessian.solve(d);
        p[..k].copy_from_slice(&self.targets[..k]);
    }

    /// Moves the linear term so that `x` with the present multipliers is the solution on the held constraints:
    /// the next proximal step.
    pub(super) fn centre(&mut self, hessian: &Hessian, x: &[f64], scratch: &mut [f64]) {
        let (stride, k) = (self.stride, self.len());
        hessian.multiply(x, scratch);
        self.q.transposed(0..stride, scratch);
        for (v, z) in self.v[..stride].iter_mut().zip(scratch) {
            *v = -*z;
        }
        for (i, &m) in self.multipliers.iter().enumerate().take(k) {
            axpy(&mut self.v[..=i], -m, &self.r[i * stride..=i * stride + i]);
        }
        self.known = 0;
    }

    /// `v` in its original axes, to begin anew with [`WorkingSet::reset`].
    pub(super) fn linear_term(&self, v: &mut [f64]) {
        v.copy_from_slice(&self.v[..self.stride]);
        self.q.apply(v);
    }
}

/// Solves `L z = b` for a lower triangle given by its rows, which are `stride` apart: replaces `z`, which holds b from
/// `known` on and the solution before that.
fn solve_rows(known: usize, rows: &[f64], stride: usize, reciprocal: &[f64], z: &mut [f64]) {
    let k = reciprocal.len();
    let mut i = known;
    while i < k {
        let at = i * stride;
        let (head, tail) = z.split_at_mut(i);
        if i.is_multiple_of(LANES) && i + LANES <= k {
            let sums = dots(&rows[at..], stride, head);
            for p in 0..LANES {
                let row = &rows[at + p * stride + i..];
                let sum = sums[p] + row.iter().zip(&tail[..p]).map(|(r, z)| r * z).sum::<f64>();
                tail[p] = (tail[p] - sum) * reciprocal[i + p];
            }
            i += LANES;
        } else {
            tail[0] = (tail[0] - dot(&rows[at..at + i], head)) * reciprocal[i];
            i += 1;
        }
    }
}
