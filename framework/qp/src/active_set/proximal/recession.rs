//! Whether the cost falls for ever along some direction, and along which.
//!
//! # Mathematics
//! From a feasible point, the directions that lead to no limit and along which the cost has no curvature are the cone
//! ```text
//! K = { d : H d = 0,  aᵀ d ≤ 0 for every upper limit,  aᵀ d ≥ 0 for every lower one }
//! ```
//! A convex quadratic cost with a feasible point has a minimum unless `gᵀ d < 0` for some d of K (M. Frank, P. Wolfe,
//! *An algorithm for quadratic programming*, Naval Research Logistics Quarterly 3 (1956)). The point of K next to −g,
//! ```text
//! d* = argmin ½ ‖d + g‖²  over K
//! ```
//! has `gᵀ d* = −‖d*‖²` (J.-J. Moreau, *Décomposition orthogonale d'un espace hilbertien selon deux cônes mutuellement
//! polaires*, C. R. Acad. Sci. Paris 255 (1962)): it is such a direction, of all of its length the one with the
//! steepest fall, or zero if there is none. That is one definite problem with H = 1, for the dual method. `H d = 0` and
//! the equalities enter it as an orthonormal basis of what their rows span (`span`).
//!
//! H and A are known up to rounding, and so is K: a row of H that is next to a combination of others tells little of
//! where it points. So d* is taken once more, from the span of H, the equalities and the constraints that hold it,
//! strong rows before weak ones.

use super::{
    super::{
        constraint::{copy_normal, count, limits, value},
        dual::Dual,
        kernels::{dot, largest, scale},
        limits::Limits,
        working_set::Factorisation,
    },
    Fall,
    span::Span,
};
use crate::{Capacity, Qp, QpError, Solution, Status};

/// Part of the sum of the sizes of its terms that a sum which has to vanish along a ray may be.
const VANISHES: f64 = 5e-13;
/// The same of the largest component of the ray, in units in which the diagonal of H and the largest coefficient of
/// every row are one, for each variable.
const ROUNDING: f64 = 1e-15;
/// How much further the cost has to fall along a ray than what the ray is off by explains; and along one that is such
/// a small part of −g that it may be nothing but rounding, whose parts happen to cancel in what explains it.
const BEYOND: f64 = 64.0;
const FAR_BEYOND: f64 = 1e8;
const SMALL: f64 = 1e-12;
/// A component of a ray below this part of the largest is rounding.
const NO_COMPONENT: f64 = 1e-12;

/// Times that constraints are held as well that a direction leads to by rounding.
const ROUNDS: u32 = 8;

/// Storage, made once.
#[derive(Clone, Debug)]
pub(super) struct Recession {
    /// The problem of the nearest point.
    nearest: Qp,
    solution: Solution,
    span: Span,
    /// The direction, and another to compare it with.
    ray: Vec<f64>,
    other: Vec<f64>,
    /// What becomes of its components in units in which they are one.
    ones: Vec<f64>,
    /// Constraints that the direction is to leave where they are.
    is_held: Vec<bool>,
    /// What was found of the problem at hand.
    found: Option<bool>,
}

impl Recession {
    /// The size of the problem of the nearest point.
    pub(super) fn capacity(Capacity { vars, rows }: Capacity) -> Capacity {
        let rows = rows + vars;
        Capacity { vars, rows }
    }

    pub(super) fn new(capacity: Capacity) -> Self {
        let Capacity { vars, rows } = capacity;
        Self {
            nearest: Qp::new(Self::capacity(capacity)),
            solution: Solution::new(Self::capacity(capacity)),
            span: Span::new(vars, rows + 2 * vars),
            ray: vec![0.0; vars],
            other: vec![0.0; vars],
            ones: vec![0.0; vars],
            is_held: vec![false; rows + vars],
            found: None,
        }
    }

    /// For another problem.
    pub(super) fn forget(&mut self) {
        self.found = None;
    }

    /// Whether it is known that the cost falls along no direction for ever.
    pub(super) fn is_none(&self) -> bool {
        self.found == Some(false)
    }

    /// The direction that was found.
    pub(super) fn ray(&self) -> &[f64] {
        &self.ray
    }

    /// Whether there is a ray of a problem in units near one with the cost `½ xᵀ H x + gᵀ x`. Looks once; after that
    /// the dual method begins without constraints.
    pub(super) fn find(
        &mut self,
        (scaled, h, g): (&Qp, &[f64], &[f64]),
        dual: &mut Dual,
        limits: &mut Limits<'_>,
        iterations: &mut u32,
    ) -> bool {
        if let Some(found) = self.found {
            return found;
        }
        let problem = Problem { scaled, h, g };
        dual.forget();
        let found = self.look(problem, dual, limits, iterations);
        dual.forget();
        // What was cut short may be found later.
        self.found = (!limits.were_used_up()).then_some(found);
        found
    }

    fn look(
        &mut self,
        problem: Problem<'_>,
        dual: &mut Dual,
        limits: &mut Limits<'_>,
        iterations: &mut u32,
    ) -> bool {
        if largest(problem.g) == 0.0 || self.pose(problem).is_err() {
            return false;
        }
        let rank = self.span.rank();
        let start = (*iterations, Factorisation::Reflections);
        let status = dual.solve(&self.nearest, limits, start, &mut self.solution);
        *iterations = self.solution.iterations;
        // A point that misses what it implies by the rounding of K is as good: the direction is checked.
        if !matches!(status, Status::Optimal | Status::Stalled) {
            return false;
        }
        // Rows of the basis come first.
        let held = dual.held().iter();
        let held = held.filter_map(|held| held.index.checked_sub(rank));
        for (index, is_held) in self.is_held[..count(problem.scaled)].iter_mut().enumerate() {
            *is_held = is_fixed(problem.scaled, index);
        }
        for index in held {
            self.is_held[index] = true;
        }
        for _ in 0..ROUNDS {
            self.project(problem);
            if !self.hold_reached(problem.scaled) {
                break;
            }
        }
        self.is_beyond_rounding() && self.is_clean_ray(problem)
    }

    /// Takes the direction once more, from the span of what is held.
    fn project(&mut self, problem: Problem<'_>) {
        let n = problem.g.len();
        self.span.clear(n);
        self.span_curvature(problem);
        for index in (0..count(problem.scaled)).filter(|index| self.is_held[*index]) {
            push_normal(&mut self.span, problem.scaled, index);
        }
        self.span.orthogonalise();
        for (d, g) in self.ray.iter_mut().zip(self.nearest.g()) {
            *d = -g;
        }
        self.span.project_out(&mut self.ray[..n]);
    }

    /// Holds the constraints as well that the direction leads to; whether there are any.
    fn hold_reached(&mut self, scaled: &Qp) -> bool {
        let mut any = false;
        for (index, is_held) in self.is_held[..count(scaled)].iter_mut().enumerate() {
            let rate = value(scaled, index, &self.ray);
            let (lower, upper) = limits(scaled, index);
            let limit = if rate > 0.0 { upper } else { lower };
            if !*is_held && rate != 0.0 && limit.is_finite() {
                (*is_held, any) = (true, true);
            }
        }
        any
    }

    /// The rows of H.
    fn span_curvature(&mut self, problem: Problem<'_>) {
        let curvature = problem.curvature();
        if curvature > 0.0 {
            for row in problem.h.chunks_exact(problem.g.len()) {
                if let Some(v) = self.span.push() {
                    v.copy_from_slice(row);
                    scale(v, 1.0 / curvature);
                }
            }
        }
    }

    /// The problem of the nearest point.
    fn pose(&mut self, problem: Problem<'_>) -> Result<(), QpError> {
        let Problem { scaled, g, .. } = problem;
        let n = scaled.n();
        self.span.clear(n);
        self.span_curvature(problem);
        for index in 0..count(scaled) {
            if is_fixed(scaled, index) {
                push_normal(&mut self.span, scaled, index);
            }
        }
        self.span.orthogonalise();
        let nearest = &mut self.nearest;
        nearest.reset(scaled.vars().iter().copied())?;
        for basis in self.span.basis() {
            nearest.push(0.0, 0.0)?.copy_from_slice(basis);
        }
        for i in 0..scaled.m() {
            let (lower, upper) = cone(limits(scaled, i));
            nearest.push(lower, upper)?.copy_from_slice(scaled.row(i));
        }
        let (h, out) = nearest.cost_mut();
        h.iter_mut().step_by(n + 1).for_each(|h| *h = 1.0);
        let steepest = largest(g);
        for (out, g) in out.iter_mut().zip(g) {
            *out = g / steepest;
        }
        let (lower, upper) = nearest.bounds_mut();
        for (j, bounds) in lower.iter_mut().zip(upper).enumerate() {
            (*bounds.0, *bounds.1) = cone((scaled.lower()[j], scaled.upper()[j]));
        }
        Ok(())
    }

    /// Sets components of the direction to zero that are rounding, as many as leave it a ray; whether it is one.
    fn is_clean_ray(&mut self, problem: Problem<'_>) -> bool {
        let (n, m) = (problem.g.len(), problem.scaled.m());
        let (ray, other) = (&mut self.ray[..n], &mut self.other[..n]);
        let rounding = NO_COMPONENT * largest(ray);
        if !(rounding > 0.0 && rounding.is_finite()) {
            return false;
        }
        for (d, is_held) in ray.iter_mut().zip(&self.is_held[m..]) {
            if *is_held {
                *d = 0.0;
            }
        }
        other.copy_from_slice(ray);
        for d in ray.iter_mut().filter(|d| d.abs() <= rounding) {
            *d = 0.0;
        }
        self.balance(problem);
        if problem.has_ray(&self.ray[..n]) {
            return true;
        }
        self.ray[..n].copy_from_slice(&self.other[..n]);
        self.balance(problem);
        problem.has_ray(&self.ray[..n])
    }

    /// Whether the direction, as it was projected, is more than what rounding leaves of −g. With the basis q of the
    /// span that was taken out of −g
    /// ```text
    /// gᵀ d = −dᵀ d + Σ (qᵀ g) (qᵀ d),
    /// ```
    /// and of a cost that has a minimum g is within the span: what is left falls by as much as it is off by.
    fn is_beyond_rounding(&mut self) -> bool {
        let n = self.nearest.n();
        let (ray, g) = (&self.ray[..n], self.nearest.g());
        let sizes = &mut self.ones[..n];
        for (size, g) in sizes.iter_mut().zip(g) {
            *size = g.abs();
        }
        let mut explained = 0.0;
        for q in self.span.basis() {
            let part = dot(q, g).abs();
            explained += part * dot(q, ray).abs();
            for (size, q) in sizes.iter_mut().zip(q) {
                *size += part * q.abs();
            }
        }
        let terms = ray.iter().zip(sizes);
        explained += terms
            .map(|(d, size)| f64::EPSILON * *size * d.abs())
            .sum::<f64>();
        let is_small = largest(ray) <= SMALL * largest(g);
        let beyond = if is_small { FAR_BEYOND } else { BEYOND };
        -dot(g, ray) > beyond * explained
    }

    /// Corrects the direction by what is left of the sums that have to vanish, in units in which each of its components
    /// is one: after that each sum is the rounding of its own terms, not of the largest component.
    fn balance(&mut self, problem: Problem<'_>) {
        let Problem { scaled, h, g } = problem;
        let n = g.len();
        let (ray, other) = (&mut self.ray[..n], &mut self.ones[..n]);
        let longest = largest(ray);
        let held = (0..scaled.m()).filter(|index| self.is_held[*index]);
        let rows = held.map(|i| (scaled.row(i), longest));
        let curved = longest * problem.curvature();
        let curvature = h.chunks_exact(n).map(|row| (row, curved));
        self.span.clear(n);
        for (row, size) in curvature.chain(rows).filter(|(_, size)| *size > 0.0) {
            if let Some(normal) = self.span.push() {
                for ((normal, a), d) in normal.iter_mut().zip(row).zip(&*ray) {
                    *normal = a * d / size;
                }
            }
        }
        self.span.orthogonalise();
        for (one, d) in other.iter_mut().zip(&*ray) {
            *one = if *d == 0.0 { 0.0 } else { 1.0 };
        }
        self.span.project_out(other);
        for (d, one) in ray.iter_mut().zip(other) {
            *d *= *one;
        }
    }
}

/// Limits of a direction's rate from those of a value.
fn cone((lower, upper): (f64, f64)) -> (f64, f64) {
    let both = lower.is_finite() && upper.is_finite();
    // What has both is in the basis.
    let limit = |limit: f64| if limit.is_finite() { 0.0 } else { limit };
    if both {
        (f64::NEG_INFINITY, f64::INFINITY)
    } else {
        (limit(lower), limit(upper))
    }
}

/// Whether a constraint has limits on both sides: a direction of K leaves it where it is.
fn is_fixed(scaled: &Qp, index: usize) -> bool {
    let (lower, upper) = limits(scaled, index);
    lower.is_finite() && upper.is_finite()
}

/// Adds a normal with length one.
fn push_normal(span: &mut Span, scaled: &Qp, index: usize) {
    if let Some(normal) = span.push() {
        copy_normal(scaled, index, normal);
        let length = dot(normal, normal).sqrt();
        if length > 0.0 {
            scale(normal, 1.0 / length);
        }
    }
}

/// A problem in units near one, with the cost that it has without a proximal term.
#[derive(Clone, Copy)]
struct Problem<'a> {
    scaled: &'a Qp,
    h: &'a [f64],
    g: &'a [f64],
}

impl Problem<'_> {
    /// The largest diagonal entry of H.
    fn curvature(&self) -> f64 {
        let diagonal = self.h.iter().step_by(self.g.len() + 1);
        diagonal.fold(0.0, |largest: f64, h| largest.max(*h))
    }

    /// Whether the cost falls along a direction, without curvature and towards no limit.
    fn has_ray(&self, d: &[f64]) -> bool {
        let Self { scaled, h, g } = *self;
        let n = g.len();
        let rounding = ROUNDING * n as f64 * largest(d);
        let vanishes = |row: &[f64], size: f64| {
            let terms: f64 = row.iter().zip(d).map(|(a, d)| (a * d).abs()).sum();
            dot(row, d).abs() <= VANISHES * terms + rounding * size
        };
        let curvature = self.curvature();
        let is_flat = h.chunks_exact(n).all(|row| vanishes(row, curvature));
        let is_free = (0..count(scaled)).all(|index| {
            let (rate, (lower, upper)) = (value(scaled, index, d), limits(scaled, index));
            let limit = if rate > 0.0 { upper } else { lower };
            let is_row = index < scaled.m();
            rate == 0.0 || limit.is_infinite() || (is_row && vanishes(scaled.row(index), 1.0))
        });
        let slopes = g.iter().map(|g| (*g, g.abs()));
        is_flat && is_free && Fall::new(d, slopes).is_certain()
    }
}
