//! The method for every convex problem: linear, flat in some directions, unbounded, badly scaled.
//!
//! # Mathematics
//! The proximal iteration `x⁺ = argmin f(x) + ½ ρ ‖x − c‖²` over the feasible set, of a problem in units near one
//! (`scaling`), is one definite problem after another for the dual method, and its fixed points `x⁺ = c` are the
//! solutions (Rockafellar 1976). Where the cost is flat it alone would go in small steps. So after each, from x⁺, the
//! cost is followed down the face of the constraints held (`face`): to the minimiser on it, or along a ray, until a
//! further constraint is in the way, which narrows the face; the next centre c is where that ends. Where nothing seems
//! to end a ray, `recession` decides whether the problem is unbounded. Every round ends at a minimiser on a face, lower
//! than the one before; there are finitely many faces.

mod doubt;
mod face;
mod recession;
mod scaling;
mod span;

use super::{
    constraint::{self, Active, add_normal, copy_normal, count, limits, value},
    dual::{Dual, clear},
    kernels::{axpy, dot, largest},
    limits::Limits,
    proof,
    twofold::Precise,
    working_set::Factorisation,
};
use crate::{Capacity, Defect, Qp, Solution, Status};
use face::Face;
use recession::Recession;
use scaling::Scaling;

/// Weights of the proximal term beside a curvature of one: the next if rounding leads nowhere with one.
const WEIGHTS: [f64; 3] = [1e-6, 1e-4, 1e-2];
/// Iterations, besides two for each variable and row, that are left to the method with twice as many digits.
const RESERVE: u32 = 100;
/// Iterations for each variable and row, and as many more, after which that method is tried: most problems take two.
const SHARE: u32 = 8;
/// Rounds with one weight.
const ROUNDS: u32 = 200;
/// Largest residual of the stationarity conditions at an optimum, per variable, relative to the sum of its terms'
/// sizes.
const STATIONARY: f64 = 1e-11;
/// How many times larger than the cost's largest term those of multipliers, which cancel one another, may count.
const OPPOSED: f64 = 1e4;
/// A residual below this part of the largest term of all variables, and of what the largest variable could contribute,
/// is rounding.
const LEAST: f64 = 1e-14;
/// Rounds after which what is left of the gradient at [`STATIONARY`] beside its largest term is taken for rounding:
/// rays and steps would have been found.
const LATE: u32 = 12;
/// Part of a direction's largest component below which the rate at which a constraint's value changes is rounding.
const RATE: f64 = 1e-10;
/// A ray is not followed by more than so many times the largest variable, or one, at once.
const FAR: f64 = 1e6;
/// Rounds after which it is assumed that they go to and fro.
const ZIGZAG: u32 = 4;
/// A round that moves by more than this part of the move before has come no closer to the end.
const AS_FAR: f64 = 0.99;
/// Rounds as far as the ones before after which nothing will be closer, if no ray leads there.
const CRAWL: u32 = 8;
/// Part of the largest variable by which a round moves if rounding is all that moves it.
const SETTLED: f64 = 1e-12;
/// Part of the sum of the sizes of its terms below which a sum is rounding.
const ROUNDED: f64 = 1e-12;

/// How a cost falls in a direction.
#[derive(Clone, Copy, Debug)]
struct Fall {
    by: f64,
    /// The sum of the sizes of its terms.
    size: f64,
    /// What of it may be rounding.
    rounding: f64,
}

impl Fall {
    /// From slopes along the variables and the sizes of their terms.
    fn new(direction: &[f64], slopes: impl Iterator<Item = (f64, f64)>) -> Self {
        // A direction has rounding of its largest component in all of them.
        let spread = 1e-3 * largest(direction);
        let mut fall = Self {
            by: 0.0,
            size: 0.0,
            rounding: 0.0,
        };
        for ((slope, size), d) in slopes.zip(direction) {
            fall.by -= slope * d;
            fall.size += size * d.abs();
            fall.rounding += ROUNDED * size * (d.abs() + spread);
        }
        fall
    }

    /// Beyond rounding: a step may be tried.
    fn is_beyond_rounding(&self) -> bool {
        self.by > self.rounding
    }

    /// So far beyond it that a status can be said.
    fn is_certain(&self) -> bool {
        self.by > STATIONARY * self.size && self.is_beyond_rounding()
    }
}

/// Storage of the method, made once.
#[derive(Clone, Debug)]
pub(super) struct Proximal {
    scaling: Scaling,
    /// In units near one, with the proximal term in H and g.
    scaled: Qp,
    /// H and g without it.
    h: Vec<f64>,
    g: Vec<f64>,
    centre: Vec<f64>,
    /// Where the last round's proximal step ended.
    last: Vec<f64>,
    x: Vec<f64>,
    gradient: Vec<f64>,
    /// Sums of the sizes of the gradient's terms.
    sizes: Vec<f64>,
    /// The sizes of g, `H x` and the multipliers' terms.
    terms: Vec<f64>,
    normal: Vec<f64>,
    /// What the face is made of, and constraints that depend on it.
    on_face: Vec<bool>,
    face: Face,
    recession: Recession,
    precise: Precise,
    /// Whether a point was found that is feasible.
    is_feasible: bool,
}

impl Proximal {
    pub(super) fn new(capacity: Capacity) -> Self {
        let Capacity { vars: n, rows: m } = capacity;
        Self {
            scaling: Scaling::new(n, m),
            scaled: Qp::new(capacity),
            h: vec![0.0; n * n],
            g: vec![0.0; n],
            centre: vec![0.0; n],
            last: vec![0.0; n],
            x: vec![0.0; n],
            gradient: vec![0.0; n],
            sizes: vec![0.0; n],
            terms: vec![0.0; n],
            normal: vec![0.0; n],
            on_face: vec![false; n + m],
            face: Face::new(n),
            recession: Recession::new(capacity),
            precise: Precise::new(n, m),
            is_feasible: false,
        }
    }

    /// The largest problem that the dual method gets.
    pub(super) fn capacity(capacity: Capacity) -> Capacity {
        Recession::capacity(capacity)
    }

    /// Solves a problem with variables and without defects but an indefinite H, which is found here.
    pub(super) fn solve(
        &mut self,
        qp: &Qp,
        dual: &mut Dual,
        limits: &mut Limits<'_>,
        out: &mut Solution,
    ) -> Status {
        let n = qp.n();
        if let Some(variable) = bilinear(qp) {
            clear(qp, out);
            out.defect = Some(Defect::Indefinite { variable });
            return Status::Invalid;
        }
        self.scaling.choose(qp);
        if self.scaling.apply(qp, &mut self.scaled).is_err() {
            // Made for the same capacity.
            return Status::Stalled;
        }
        self.h[..n * n].copy_from_slice(self.scaled.h());
        self.g[..n].copy_from_slice(self.scaled.g());
        self.face.reset(n, &self.h[..n * n]);
        if let Some(variable) = self.face.indefinite() {
            clear(qp, out);
            out.defect = Some(Defect::Indefinite { variable });
            return Status::Invalid;
        }
        self.recession.forget();
        self.is_feasible = false;
        let size = u32::try_from(n + qp.m()).unwrap_or(u32::MAX);
        limits.attempt_all_but(size.saturating_mul(2).saturating_add(RESERVE));
        let share = size.saturating_mul(SHARE).saturating_add(RESERVE);
        limits.attempt_at_most(out.iterations.saturating_add(share));
        let mut status = Status::Stalled;
        for weight in WEIGHTS {
            status = self.iterate(weight, dual, limits, out);
            if status != Status::Stalled {
                break;
            }
            dual.forget();
        }
        limits.attempt_until(u32::MAX);
        if status == Status::Stalled && self.is_feasible {
            status = self.finds_ray(dual, limits, out).unwrap_or(status);
        }
        if status == Status::Stalled {
            status = self.solve_precisely(limits, out);
            // Where rounding made limits contradict one another, there is a feasible point only now.
            if self.falls_perhaps(status, out) {
                status = self.finds_ray(dual, limits, out).unwrap_or(status);
            }
        }
        if status == Status::Stalled && limits.are_used_up(out.iterations) {
            status = limits.status(out.iterations);
        }
        self.scaling.undo(n, qp.m(), out);
        if status == Status::Unbounded {
            let longest = largest(&out.x[..n]);
            for x in &mut out.x[..n] {
                *x /= longest;
            }
        }
        let finite = |a: &[f64]| a.iter().all(|x| x.is_finite());
        if !(finite(&out.x[..n]) && finite(&out.y[..qp.m()]) && finite(&out.z[..n])) {
            clear(qp, out);
            return Status::Stalled;
        }
        status
    }

    /// The iteration with one weight, in units near one.
    fn iterate(
        &mut self,
        weight: f64,
        dual: &mut Dual,
        limits: &mut Limits<'_>,
        out: &mut Solution,
    ) -> Status {
        let n = self.scaled.n();
        let h = self.scaled.h_mut();
        h.copy_from_slice(&self.h[..n * n]);
        for j in 0..n {
            h[j * n + j] += weight;
        }
        self.centre[..n].fill(0.0);
        // Rounds one after the other that only rounding moved, and that moved as far as the one before.
        let (mut settled, mut crawling) = (0, 0);
        let mut moved_before = f64::INFINITY;
        for round in 0..ROUNDS {
            let terms = self.scaled.g_mut().iter_mut().zip(&self.g);
            for ((out, g), centre) in terms.zip(&self.centre) {
                *out = g - weight * centre;
            }
            let start = (out.iterations, Factorisation::Reflections);
            let status = dual.solve(&self.scaled, limits, start, out);
            // Now: what it holds after another solve is of another problem.
            self.precise.begin_with(dual.held());
            if status == Status::Infeasible {
                return if proof::holds(&self.scaled, out) {
                    status
                } else {
                    Status::Stalled
                };
            }
            if status != Status::Optimal {
                return status;
            }
            self.is_feasible = true;
            self.x[..n].copy_from_slice(&out.x[..n]);
            let moved = self.x[..n].iter().zip(&self.centre);
            let moved = moved.fold(0.0, |a: f64, (x, c)| a.max((x - c).abs()));
            settled = if moved <= SETTLED * largest(&self.x[..n]) {
                settled + 1
            } else {
                0
            };
            crawling = if moved > AS_FAR * moved_before {
                crawling + 1
            } else {
                0
            };
            moved_before = moved;
            let is_late = round >= LATE || settled >= ZIGZAG;
            let rounding = if is_late { STATIONARY } else { LEAST };
            if self.is_stationary(weight, rounding, out) {
                if self.hides_cost() {
                    return self.clear_up(dual, limits, out);
                }
                constraint::keep_bounds(&self.scaled, out);
                return if constraint::all_hold(&self.scaled, &out.x[..n]) {
                    Status::Optimal
                } else {
                    Status::Stalled
                };
            }
            let seems_unbounded = round >= ZIGZAG && self.extrapolate();
            self.last[..n].copy_from_slice(&out.x[..n]);
            let seems_unbounded = seems_unbounded || self.descend(dual, limits, out);
            if seems_unbounded && let Some(status) = self.finds_ray(dual, limits, out) {
                return status;
            }
            if limits.were_used_up() {
                return limits.status(out.iterations);
            }
            let is_going_nowhere = crawling > CRAWL && self.recession.is_none();
            if settled > ZIGZAG
                || is_going_nowhere
                || moved == 0.0 && self.x[..n] == self.centre[..n]
            {
                // Rounding is all that is left.
                return Status::Stalled;
            }
            self.centre[..n].copy_from_slice(&self.x[..n]);
        }
        Status::Stalled
    }

    /// The gradient at `x`, without the proximal term, and the sizes of its terms.
    fn differentiate(&mut self) {
        let n = self.scaled.n();
        let x = &self.x[..n];
        let rows = self.h[..n * n].chunks_exact(n).zip(&self.g);
        for ((row, g), (gradient, size)) in rows.zip(self.gradient.iter_mut().zip(&mut self.sizes))
        {
            *gradient = g + dot(row, x);
            *size = row
                .iter()
                .zip(x)
                .fold(g.abs(), |a, (h, x)| a + (h * x).abs());
        }
    }

    /// Whether the multipliers balance the gradient, up to its terms' accepted part or to rounding of the largest term.
    fn is_stationary(&mut self, weight: f64, rounding: f64, out: &mut Solution) -> bool {
        self.differentiate();
        let (n, m) = (self.scaled.n(), self.scaled.m());
        let curvature = self.face.curvature() + weight;
        let contribution = largest(&self.x[..n]) * curvature;
        if largest(&self.gradient[..n]) <= LEAST * contribution {
            // No cost: what the multipliers are is rounding.
            out.y[..m].fill(0.0);
            out.z[..n].fill(0.0);
            return true;
        }
        // Of `H x` only what it comes to counts: where the cost is flat its terms grow with x.
        let sums = self.gradient[..n].iter().zip(&self.g);
        for (term, (gradient, g)) in self.terms.iter_mut().zip(sums) {
            *term = g.abs() + (gradient - g).abs();
        }
        for (index, y) in out.y[..m].iter().chain(&out.z[..n]).enumerate() {
            if *y == 0.0 {
                continue;
            }
            add_normal(&self.scaled, index, *y, &mut self.gradient[..n]);
            match index.checked_sub(m) {
                None => {
                    for (term, a) in self.terms.iter_mut().zip(self.scaled.row(index)) {
                        *term += (a * y).abs();
                    }
                }
                Some(j) => self.terms[j] += y.abs(),
            }
        }
        let most = largest(&self.sizes[..n]).max(contribution);
        let mut pairs = self.gradient[..n].iter().zip(&self.terms);
        // `!(… > …)` would let a NaN through.
        pairs.all(|(r, term)| {
            r.abs() <= STATIONARY * term.min(OPPOSED * most) || r.abs() <= rounding * most
        })
    }

    /// Follows the cost from `x` down the face of the constraints held, and narrower ones; whether nothing seems to end
    /// that.
    fn descend(&mut self, dual: &mut Dual, limits: &mut Limits<'_>, out: &mut Solution) -> bool {
        let (n, all) = (self.scaled.n(), count(&self.scaled));
        self.face.reset(n, &self.h[..n * n]);
        self.on_face[..all].fill(false);
        for held in dual.held() {
            copy_normal(&self.scaled, held.index, &mut self.normal[..n]);
            self.face.confine(&self.normal[..n]);
            self.on_face[held.index] = true;
        }
        // The count that the limits see grows from look to look.
        while !limits.are_used_up(out.iterations) {
            out.iterations += 1;
            self.differentiate();
            let is_ray = self.face.ray(&self.gradient[..n])
                && self.fall_of_linear_term().is_beyond_rounding();
            let falls =
                is_ray || (self.face.step(&self.gradient[..n]) && self.fall().is_beyond_rounding());
            if !falls {
                return false;
            }
            let full = if is_ray { f64::INFINITY } else { 1.0 };
            let (length, blocking) = self.first_in_the_way(full);
            if length.is_infinite() {
                return self.fall_of_linear_term().is_certain() && !self.recession.is_none();
            }
            let reach = FAR * largest(&self.x[..n]).max(1.0);
            let longest = largest(self.face.direction());
            let is_far = is_ray && length * longest > reach;
            if !is_far {
                axpy(&mut self.x[..n], length, self.face.direction());
            }
            let Some(blocking) = blocking else {
                return false;
            };
            self.on_face[blocking.index] = true;
            copy_normal(&self.scaled, blocking.index, &mut self.normal[..n]);
            // What is so far in the way may be so by rounding: the ray may go past it.
            if self.face.confine(&self.normal[..n]) && !is_far {
                dual.begin_with(&self.scaled, blocking);
            }
        }
        false
    }

    /// How the cost falls in the direction from `x`.
    fn fall(&self) -> Fall {
        let n = self.scaled.n();
        let pairs = self.gradient[..n].iter().zip(&self.sizes);
        Fall::new(self.face.direction(), pairs.map(|(g, size)| (*g, *size)))
    }

    /// How `gᵀ x` falls in the direction: without curvature that does not depend on x, however large x has become.
    fn fall_of_linear_term(&self) -> Fall {
        let pairs = self.g.iter().map(|g| (*g, g.abs()));
        Fall::new(self.face.direction(), pairs)
    }

    /// Goes on in the direction in which the last rounds' ends moved, as far as the cost falls and nothing is in the
    /// way; whether nothing seems to end that.
    fn extrapolate(&mut self) -> bool {
        let n = self.scaled.n();
        self.differentiate();
        let d = self.face.direction_mut();
        for (d, (x, last)) in d.iter_mut().zip(self.x.iter().zip(&self.last)) {
            *d = x - last;
        }
        let longest = largest(d);
        if longest == 0.0 {
            return false;
        }
        for d in d.iter_mut() {
            *d /= longest;
        }
        let fall = self.fall();
        if !fall.is_certain() {
            return false;
        }
        let d = self.face.direction();
        let products = self.h[..n * n].chunks_exact(n).zip(d);
        let curvature: f64 = products.map(|(h, d_i)| d_i * dot(h, d)).sum();
        let full = if curvature <= ROUNDED * self.face.curvature() {
            f64::INFINITY
        } else {
            fall.by / curvature
        };
        self.on_face[..count(&self.scaled)].fill(false);
        let (length, _) = self.first_in_the_way(full);
        if length.is_infinite() {
            return !self.recession.is_none();
        }
        axpy(&mut self.x[..n], length, self.face.direction());
        false
    }

    /// How far the direction can be followed from `x`, at most `full`, and what ends it.
    fn first_in_the_way(&self, full: f64) -> (f64, Option<Active>) {
        let n = self.scaled.n();
        let (x, d) = (&self.x[..n], self.face.direction());
        let rounding = RATE * largest(d);
        let mut first = (full, None);
        for index in (0..count(&self.scaled)).filter(|&index| !self.on_face[index]) {
            let rate = value(&self.scaled, index, d);
            // In units near one, a component that is so much smaller than others is rounding.
            if rate.abs() <= rounding {
                continue;
            }
            let (lower, upper) = limits(&self.scaled, index);
            let (side, limit) = if rate > 0.0 {
                (1.0, upper)
            } else {
                (-1.0, lower)
            };
            if limit.is_infinite() {
                continue;
            }
            let length = ((limit - value(&self.scaled, index, x)) / rate).max(0.0);
            if length < first.0 {
                first = (length, Some(Active { index, side, limit }));
            }
        }
        first
    }
}

/// A variable whose own curvature is zero, while that with another is not: the cost is a saddle, whatever the units.
/// What is left where the square of a small number has become zero is none.
fn bilinear(qp: &Qp) -> Option<usize> {
    let (n, h) = (qp.n(), qp.h());
    (0..n).filter(|j| h[j * n + j] == 0.0).find(|j| {
        let mut row = h[j * n..(j + 1) * n].iter().enumerate();
        row.any(|(i, entry)| entry * entry > h[i * n + i] * f64::MIN_POSITIVE)
    })
}
