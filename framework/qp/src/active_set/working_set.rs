//! The constraints that are held, and the least-distance solution on them.
//!
//! # Mathematics
//! With `z = U x` and `v = U⁻ᵀ g` the problem on the held constraints is `min ½‖z + v‖²` subject to `Wᵀ z = b`, the
//! columns of W being `w = U⁻ᵀ a`. With `Wᵀ W = Rᵀ R` its solution is
//! ```text
//! Rᵀ z₁ = b,   Rᵀ v₁ = Wᵀ v,   R λ = −(z₁ + v₁),   z = −(v + W λ)
//! ```
//! R comes from the products of the normals, as long as no normal is at a small angle to those held before it: products
//! square the condition number, and a weakly weighted direction makes all constraints look alike. From the first small
//! angle on it comes from reflections, `W = Q [R; 0]` with a Q that is a product of them ([`Orthogonal`]), and
//! ```text
//! v₁ = (Qᵀv)₁,   z = Q [z₁; −(Qᵀv)₂]
//! ```
//! A constraint appends a column to R. One that leaves makes R Hessenberg, and rotations make it triangular again
//! (Goldfarb and Idnani 1983 update the same factorisation). Solving with R alone, the *seminormal equations*, and
//! correcting what comes out by its residuals is about as accurate as solving with Q (Å. Björck, *Stability analysis of
//! the method of seminormal equations*, Linear Algebra and its Applications 88/89 (1987)).

mod soft;

use super::{
    constraint::Active,
    hessian::Hessian,
    kernels::{dot, padded, squares_after},
    normals::Normals,
    orthogonal::Orthogonal,
    simd::Simd,
    triangle::{Triangle, rotation},
};
use crate::{Capacity, Qp};

/// Sine of the angle to the held constraints below which a constraint depends on them.
pub(super) const DEPENDENT: f64 = 1e-10;
/// Sine below which R is no longer to come from products: half of their digits are lost at 1e-4.
const SMALL_ANGLE: f64 = 1e-4;

/// Where R comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Factorisation {
    /// Products of normals, until an angle is small.
    Products,
    /// Reflections from the beginning: of a problem whose H has directions next to flat.
    Reflections,
    /// Products of normals and what constraints give, whatever the angles.
    Soft,
}

#[derive(Clone, Debug, Default)]
pub(super) struct WorkingSet {
    simd: Simd,
    n: usize,
    /// n with padding.
    stride: usize,
    active: Vec<Active>,
    normals: Normals,
    r: Triangle,
    /// Whether R comes from reflections.
    is_orthogonal: bool,
    /// Whether constraints give.
    is_soft: bool,
    /// How many constraints may be held.
    room: usize,
    /// By how much each row gives per unit of its multiplier, if any do.
    compliance: Vec<f64>,
    /// Of a constraint at a small angle to others: its combination, the residual of that, and what is left of `w`.
    combination: Vec<f64>,
    residual: Vec<f64>,
    rest: Vec<f64>,
    q: Orthogonal,
    /// `v`; with reflections `Qᵀ v`.
    v: Vec<f64>,
    /// `v₁`; with reflections it is in `v`.
    v1: Vec<f64>,
    /// The first `known` entries are valid.
    z1: Vec<f64>,
    known: usize,
    /// Multipliers, dual feasible.
    pub(super) multipliers: Vec<f64>,
    /// Multipliers of the solution on the held constraints, or how a dependent one combines from them.
    targets: Vec<f64>,
    /// `R⁻ᵀ Wᵀ w` of the constraint that was to be pushed last; with reflections `Qᵀ w`.
    column: Vec<f64>,
    /// What was let go because it depends on others, when the factorisation was made anew.
    dropped: Vec<Active>,
}

impl WorkingSet {
    pub(super) fn new(capacity: Capacity, simd: Simd) -> Self {
        let n = capacity.vars;
        Self {
            simd,
            active: Vec::with_capacity(n + 1),
            normals: Normals::new(capacity, simd),
            r: Triangle::new(n),
            q: Orthogonal::new(n, n + n / 2 + 4, 8 * n * n + 16, simd),
            v: vec![0.0; padded(n)],
            v1: vec![0.0; padded(n)],
            z1: vec![0.0; n],
            multipliers: Vec::with_capacity(n + 1),
            targets: vec![0.0; n],
            column: vec![0.0; padded(n)],
            compliance: Vec::with_capacity(capacity.rows),
            combination: vec![0.0; n],
            residual: vec![0.0; n],
            rest: vec![0.0; padded(n)],
            dropped: Vec::with_capacity(n + 1),
            ..Self::default()
        }
    }

    /// Nothing held, of a problem with a new factor; `v = U⁻ᵀ g`, padded.
    pub(super) fn reset(&mut self, qp: &Qp, v: &[f64], start: Factorisation) {
        self.n = qp.n();
        self.stride = v.len();
        self.active.clear();
        self.multipliers.clear();
        self.normals.forget(qp);
        self.r.reset(self.n);
        self.q.reset(self.n);
        self.is_orthogonal = start == Factorisation::Reflections;
        self.is_soft = start == Factorisation::Soft;
        self.room = self.n;
        if self.is_soft {
            let soft = self.compliance.iter().filter(|c| **c > 0.0).count();
            self.room = (self.n + soft).min(self.targets.len());
            self.r.reset(self.room);
        }
        self.v[..v.len()].copy_from_slice(v);
        self.known = 0;
    }

    pub(super) fn active(&self) -> &[Active] {
        &self.active
    }

    /// Whether constraints give.
    pub(super) fn is_soft(&self) -> bool {
        self.is_soft
    }

    /// The next solves are of problems whose rows give by so much per unit of their multipliers.
    pub(super) fn soften(&mut self, compliance: &[f64]) {
        self.compliance.clear();
        let room = self.compliance.capacity();
        self.compliance.extend(compliance.iter().take(room));
    }

    /// By how much a constraint gives per unit of its multiplier.
    pub(super) fn compliance(&self, index: usize) -> f64 {
        if self.is_soft {
            self.compliance.get(index).copied().unwrap_or(0.0)
        } else {
            0.0
        }
    }

    /// The constraints held with their multipliers.
    pub(super) fn held_mut(&mut self) -> impl Iterator<Item = (&Active, &mut f64)> {
        self.active.iter().zip(&mut self.multipliers)
    }

    pub(super) fn len(&self) -> usize {
        self.active.len()
    }

    /// `1/‖w‖` of a constraint.
    pub(super) fn reciprocal_length(&mut self, qp: &Qp, hessian: &Hessian, index: usize) -> f64 {
        self.normals.reciprocal_length(qp, hessian, index)
    }

    /// Holds a constraint, with the multiplier it has so far. False if the sine of its angle to those held is at most
    /// `sine`: then [`WorkingSet::combine`] says how it combines from them.
    pub(super) fn push(
        &mut self,
        qp: &Qp,
        hessian: &Hessian,
        constraint: Active,
        multiplier: f64,
        sine: f64,
    ) -> bool {
        self.normals.know(qp, hessian, constraint.index);
        if self.is_soft {
            if !self.append_soft(constraint.index, sine) {
                return false;
            }
        } else if !self.is_orthogonal
            && !self.append_product(constraint.index, sine.max(SMALL_ANGLE))
        {
            self.factorise_by_reflections();
        }
        if self.is_orthogonal {
            if !self.q.has_room(self.n * (self.n + 1) / 2) {
                self.factorise_by_reflections();
            }
            if !self.append_by_reflection(constraint.index, sine) {
                return false;
            }
        }
        self.active.push(constraint);
        self.multipliers.push(multiplier);
        true
    }

    /// Appends a constraint's column to R; false if the sine of its angle is at most `sine`, as it is if as many are
    /// held as there are variables.
    fn append_product(&mut self, index: usize, sine: f64) -> bool {
        let k = self.len();
        if k == self.n {
            return false;
        }
        let (range, w) = self.normals.get(index);
        let column = &mut self.column[..=k];
        self.normals.products(&self.active, (range, w), column);
        self.r.solve_transposed_in(self.simd, 0, column);
        let size = self.normals.square(index);
        let beyond = size - dot(&column[..k], &column[..k]);
        // `!(beyond > …)`: a NaN is small, too.
        let is_far = beyond > sine * sine * size;
        if !is_far {
            return false;
        }
        column[k] = beyond.sqrt();
        let known = dot(&column[..k], &self.v1[..k]);
        self.v1[k] = (dot(w, &self.v[..self.stride]) - known) / column[k];
        self.r.append(column);
        true
    }

    /// Appends a constraint's column to R and a reflection to Q; false if it depends on those held.
    fn append_by_reflection(&mut self, index: usize, sine: f64) -> bool {
        let k = self.r.len();
        let column = &mut self.column[..self.stride];
        let (range, w) = self.normals.get(index);
        column.copy_from_slice(w);
        self.q.transposed(range, column);
        if k == self.n {
            return false;
        }
        let rest = squares_after(k, column);
        let beyond = column[k] * column[k] + rest;
        let size = dot(column, column);
        // `!(beyond > …)`: a NaN depends, too.
        let is_independent = beyond > sine * sine * size;
        if !is_independent {
            return false;
        }
        let v = &mut self.v[..self.stride];
        self.q.reflect(k, rest, column, v);
        self.r.append(column);
        true
    }

    /// Factorises anew, by reflections: after a small angle, or when the product of reflections and rotations has
    /// become too long.
    fn factorise_by_reflections(&mut self) {
        if self.is_orthogonal {
            self.q.apply(&mut self.v[..self.stride]);
        }
        self.is_orthogonal = true;
        self.q.reset(self.n);
        self.r.reset(self.n);
        self.known = 0;
        let mut kept = 0;
        for i in 0..self.len() {
            let constraint = self.active[i];
            if self.append_by_reflection(constraint.index, DEPENDENT) {
                self.active[kept] = constraint;
                self.multipliers[kept] = self.multipliers[i];
                kept += 1;
            } else {
                self.dropped.push(constraint);
            }
        }
        self.active.truncate(kept);
        self.multipliers.truncate(kept);
    }

    /// One of the constraints that a factorisation made anew has let go.
    pub(super) fn next_dropped(&mut self) -> Option<Active> {
        self.dropped.pop()
    }

    /// Lets the j-th constraint go.
    pub(super) fn remove(&mut self, j: usize) -> Active {
        let removed = self.active.remove(j);
        self.multipliers.remove(j);
        if self.is_orthogonal {
            if j < self.len() {
                self.q.begin_rotations(j);
            }
            self.r.remove(j, &mut self.v, |a, b| self.q.rotate(a, b));
        } else {
            self.r.remove(j, &mut self.v1, rotation);
        }
        self.known = self.known.min(j);
        removed
    }

    /// Holds the j-th constraint at its other limit.
    pub(super) fn turn(&mut self, j: usize, limit: f64) {
        let held = &mut self.active[j];
        (held.side, held.limit) = (-held.side, limit);
        self.known = self.known.min(j);
    }

    /// `‖R d‖²` of the way from the multipliers to the targets; `scratch` has room for one number per constraint held.
    pub(super) fn steepness(&self, scratch: &mut [f64]) -> f64 {
        let k = self.len();
        let scratch = &mut scratch[..k];
        scratch.fill(0.0);
        let way = self.targets[..k].iter().zip(&self.multipliers);
        self.r.add_columns(way.map(|(t, m)| t - m), scratch);
        dot(scratch, scratch)
    }

    /// Computes the multipliers of the least-distance solution on the held constraints: [`WorkingSet::computed`].
    pub(super) fn find_targets(&mut self) {
        let k = self.len();
        let new = self.z1[self.known..].iter_mut();
        for (z, held) in new.zip(&self.active[self.known..]) {
            *z = held.limit;
        }
        self.r
            .solve_transposed_in(self.simd, self.known, &mut self.z1);
        self.known = k;
        let (targets, z1) = (&mut self.targets[..k], &self.z1[..k]);
        let v1 = if self.is_orthogonal {
            &self.v
        } else {
            &self.v1
        };
        for (t, (z, v)) in targets.iter_mut().zip(z1.iter().zip(v1)) {
            *t = -(z + v);
        }
        self.r.solve_in(self.simd, targets);
    }

    /// What [`WorkingSet::find_targets`] or [`WorkingSet::combine`] computed last, per held constraint.
    pub(super) fn computed(&self) -> &[f64] {
        &self.targets[..self.len()]
    }

    /// How the constraint that was not pushed combines from those held: `R⁻¹` of the first entries of `Qᵀ w`.
    pub(super) fn combine(&mut self) {
        let k = self.len();
        self.targets[..k].copy_from_slice(&self.column[..k]);
        self.r.solve_in(self.simd, &mut self.targets[..k]);
    }

    /// How the part of `a` along the held constraints combines from them, after a constraint was not pushed; `a` is
    /// used up.
    pub(super) fn project(&mut self, hessian: &Hessian, a: &mut [f64]) {
        debug_assert!(
            self.is_orthogonal || self.is_soft,
            "a normal that depends on others was met"
        );
        let range = hessian.solve_transposed(a);
        if self.is_soft {
            let column = &mut self.column[..self.active.len()];
            self.normals.products(&self.active, (range, a), column);
            self.r.solve_transposed_in(self.simd, 0, column);
        } else {
            self.q.transposed(range, a);
            self.column[..self.stride].copy_from_slice(a);
        }
        self.combine();
    }

    /// Lengths of the held constraints' normals in the metric of H: a combination's parts, times these, can be
    /// compared.
    pub(super) fn lengths(&self) -> impl Iterator<Item = f64> {
        let squares = self.active.iter().map(|h| self.normals.square(h.index));
        squares.map(f64::sqrt)
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
        if self.is_orthogonal {
            x[..k].copy_from_slice(&self.z1[..k]);
            negate(&mut x[k..], &self.v[k..]);
            self.q.apply(x);
        } else {
            negate(x, &self.v);
            self.normals.subtract(&self.active, &self.targets, x);
        }
        hessian.solve(x);
    }

    /// The `x` that minimises the cost with the multipliers at hand as prices.
    pub(super) fn primal_of_multipliers(&self, hessian: &Hessian, x: &mut [f64]) {
        negate(x, &self.v);
        if self.is_orthogonal {
            self.r.add_columns(self.multipliers.iter().map(|m| -m), x);
            self.q.apply(x);
        } else {
            self.normals.subtract(&self.active, &self.multipliers, x);
        }
        hessian.solve(x);
    }

    /// Solves `[H̃ A_aᵀ; A_a 0] [dx; dλ] = [−d; p]`: replaces `d` by `dx` and `p` (one entry per held constraint) by
    /// `dλ`.
    pub(super) fn correct(&mut self, hessian: &Hessian, d: &mut [f64], p: &mut [f64]) {
        let k = self.len();
        let targets = &mut self.targets[..k];
        let range = if d.iter().any(|d| *d != 0.0) {
            hessian.solve_transposed(d)
        } else {
            0..0
        };
        if self.is_soft {
            for (rest, p) in self.residual.iter_mut().zip(&*p) {
                *rest = -p;
            }
        }
        self.r.solve_transposed_in(self.simd, 0, p);
        if self.is_orthogonal {
            self.q.transposed(range, d);
            targets.copy_from_slice(&d[..k]);
        } else {
            self.normals.products(&self.active, (range, d), targets);
            self.r.solve_transposed_in(self.simd, 0, targets);
        }
        for (t, p) in targets.iter_mut().zip(&*p) {
            *t = -(p + *t);
        }
        self.r.solve_in(self.simd, targets);
        for d in &mut *d {
            *d = -*d;
        }
        if self.is_orthogonal {
            d[..k].copy_from_slice(&p[..k]);
            self.q.apply(d);
        } else {
            self.normals.subtract(&self.active, targets, d);
            if self.is_soft {
                self.correct_targets(d);
            }
        }
        hessian.solve(d);
        p[..k].copy_from_slice(&self.targets[..k]);
    }

    /// Moves the linear term so that `x` with the present multipliers is the solution on the held constraints:
    /// the next proximal step.
    pub(super) fn centre(&mut self, hessian: &Hessian, x: &[f64], scratch: &mut [f64]) {
        let (stride, k) = (self.stride, self.len());
        hessian.multiply(x, scratch);
        let v = &mut self.v[..stride];
        if self.is_orthogonal {
            self.q.transposed(0..stride, scratch);
            negate(v, scratch);
            self.r.add_columns(self.multipliers.iter().map(|m| -m), v);
        } else {
            negate(v, scratch);
            self.normals.subtract(&self.active, &self.multipliers, v);
            let v1 = &mut self.v1[..k];
            self.normals.products(&self.active, (0..stride, v), v1);
            self.r.solve_transposed_in(self.simd, 0, v1);
        }
        self.known = 0;
    }
}

/// `y = −x` over the length of y.
fn negate(y: &mut [f64], x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y = -x;
    }
}

#[cfg(test)]
mod tests {
    use super::{Factorisation, WorkingSet};
    use crate::{
        Capacity, Qp,
        active_set::{constraint::Active, hessian::Hessian, kernels::padded, simd::Simd},
    };

    const ROWS: usize = 8;

    /// A definite problem with rows, the last of which is `lean` away from the first.
    fn problem(n: usize, lean: f64) -> Qp {
        // As good as random: the digits after the point.
        let wave = |i: usize| ((i as f64 + 1.0) * 97.135).sin() * 4e3 % 1.0;
        let root: Vec<f64> = (0..n * n).map(wave).collect();
        let mut h = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..n {
                let product = (0..n).map(|k| root[i * n + k] * root[j * n + k]);
                h[i * n + j] = product.sum::<f64>() + if i == j { 1.0 } else { 0.0 };
            }
        }
        let mut a: Vec<f64> = (0..ROWS * n).map(|i| wave(3 * i + 1)).collect();
        for j in 0..n {
            a[(ROWS - 1) * n + j] = a[j] + lean * wave(5 * j + 2);
        }
        let g: Vec<f64> = (0..n).map(|i| wave(11 * i)).collect();
        let (low, high) = (vec![-1.0; ROWS], vec![1.0; ROWS]);
        let (lower, upper) = (vec![-2.0; n], vec![2.0; n]);
        Qp::dense(&h, &g, &a, (&low, &high), (&lower, &upper)).expect("the shapes fit")
    }

    struct Solver {
        qp: Qp,
        hessian: Hessian,
        set: WorkingSet,
    }

    impl Solver {
        fn new(qp: Qp, start: Factorisation) -> Self {
            let n = qp.n();
            let capacity = Capacity {
                vars: n,
                rows: ROWS,
            };
            let (mut hessian, mut set) = (
                Hessian::new(n, Simd::detect()),
                WorkingSet::new(capacity, Simd::detect()),
            );
            assert!(hessian.factorise(&qp), "H is definite");
            let mut v = vec![0.0; padded(n)];
            v[..n].copy_from_slice(qp.g());
            hessian.solve_transposed(&mut v);
            set.reset(&qp, &v, start);
            Self { qp, hessian, set }
        }

        fn push(&mut self, index: usize) -> bool {
            let constraint = Active {
                index,
                side: 1.0,
                limit: 0.3 * index as f64 - 1.0,
            };
            let Self { qp, hessian, set } = self;
            set.push(qp, hessian, constraint, 0.0, super::DEPENDENT)
        }

        /// Multipliers, `x`, and the correction of some residuals.
        fn answer(&mut self) -> Vec<f64> {
            let (n, k) = (self.qp.n(), self.set.len());
            let mut x = vec![0.0; padded(n)];
            self.set.find_targets();
            self.set.primal(&self.hessian, &mut x);
            let mut out = self.set.computed().to_vec();
            out.extend_from_slice(&x[..n]);
            let mut d: Vec<f64> = (0..padded(n))
                .map(|j| if j < n { 0.1 * j as f64 } else { 0.0 })
                .collect();
            let mut p: Vec<f64> = (0..k).map(|j| 1.0 - 0.2 * j as f64).collect();
            self.set.correct(&self.hessian, &mut d, &mut p);
            out.extend_from_slice(&d[..n]);
            out.extend_from_slice(&p);
            out
        }
    }

    fn distance(a: &[f64], b: &[f64]) -> f64 {
        assert_eq!(a.len(), b.len());
        let size = a.iter().fold(1.0_f64, |size, a| size.max(a.abs()));
        let away = a.iter().zip(b).map(|(a, b)| (a - b).abs());
        away.fold(0.0, f64::max) / size
    }

    #[test]
    fn products_and_reflections_agree() {
        // Strides that the code knows, and others.
        for n in [3, 8, 12, 15, 22] {
            let qp = problem(n, 1.0);
            let mut one = Solver::new(qp.clone(), Factorisation::Products);
            let mut other = Solver::new(qp, Factorisation::Reflections);
            let mut held = 0;
            for step in 0..3 * n {
                // Rows and bounds come and go.
                let index = (7 * step + 2) % (ROWS + n);
                let is_held = one.set.active().iter().position(|h| h.index == index);
                if let Some(j) = is_held {
                    one.set.remove(j);
                    other.set.remove(j);
                } else if one.set.len() < n {
                    assert!(one.push(index) && other.push(index), "{n} {step}");
                }
                held = held.max(one.set.len());
                assert!(
                    distance(&one.answer(), &other.answer()) < 1e-10,
                    "{n} {step}"
                );
            }
            assert!(
                held >= n.min(ROWS),
                "as many as there are variables, or most rows"
            );
            assert!(!one.set.is_orthogonal && other.set.is_orthogonal);
        }
    }

    #[test]
    fn a_full_set_combines_to_any_normal() {
        let n = 8;
        let mut solver = Solver::new(problem(n, 1.0), Factorisation::Products);
        for index in 0..n {
            assert!(solver.push(index), "rows are independent");
        }
        assert!(!solver.push(ROWS + 3), "there is no room for another");
        solver.set.combine();
        let combination = solver.set.computed();
        for j in 0..n {
            let terms = combination.iter().enumerate();
            let sum: f64 = terms.map(|(i, r)| r * solver.qp.row(i)[j]).sum();
            let expected = if j == 3 { 1.0 } else { 0.0 };
            assert!((sum - expected).abs() < 1e-12, "{j}: {sum}");
        }
        assert!(
            solver.set.is_orthogonal,
            "combinations are made with reflections"
        );
    }

    #[test]
    fn a_small_angle_turns_to_reflections() {
        for (lean, is_small) in [(1e-1, false), (1e-6, true)] {
            let qp = problem(12, lean);
            let mut one = Solver::new(qp.clone(), Factorisation::Products);
            let mut other = Solver::new(qp, Factorisation::Reflections);
            for index in [3, 0, 12, ROWS - 1] {
                assert!(one.push(index) && other.push(index));
            }
            assert_eq!(one.set.is_orthogonal, is_small);
            let apart = distance(&one.answer(), &other.answer());
            assert!(apart < 1e-9, "{lean}: {apart:e}");
        }
    }
}
