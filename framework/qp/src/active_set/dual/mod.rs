//! The dual method for an H that is definite, at least where the equality rows leave freedom: its storage, and its way
//! from the factorisation to a refined optimum.

mod ascent;
mod certificate;
mod homotopy;
mod long_step;
mod refinement;

use super::{
    compact::{self, Compact},
    constraint::{
        Active, count, equalities, equality, id_of, impossible, index_of, is_empty, limits,
    },
    hessian::Hessian,
    kernels::{largest_product, padded},
    limits::Limits,
    point::Point,
    simd::{Simd, with_simd},
    working_set::{DEPENDENT, Factorisation, WorkingSet},
};
use crate::{Capacity, Held, Qp, Solution, Status, WarmStart, validity::first_not_finite};

/// Residual of the optimality conditions, relative to their terms, that needs no refinement.
const EXACT: f64 = 1e-14;
/// Relative residual of an optimum.
const CONVERGED: f64 = 1e-9;
/// Times that a refined point may turn out to violate a constraint, or to hold one too many.
const CORRECTIONS: u32 = 50;
/// How many of these trust points that are not refined.
const TRUSTING: u32 = 2;

/// Relative violation, or multiplier of the wrong sign, that a refined point may have: the second after a few
/// corrections, which only degenerate problems need.
const FORGIVEN: [f64; 2] = [1e-11, 3e-11];
/// Largest relative violation of an optimum, constraints that are held or implied included. What it is relative to, a
/// limit and the terms of a value added up, is about twice the largest of them, of which this is 1e-10.
const VIOLATION: f64 = 5e-11;
/// Times that constraints which seemed to be implied are tried again: once after each of the first corrections.
const TRIALS: u32 = 2;

/// Sine of the angle to the equalities held so far above which one is held at once. Those that are nearly a combination
/// of others come last: then they are implied by more, instead of being held while others nearly depend on them.
const DISTINCT: f64 = 1e-6;

/// Why the dual iteration stopped.
enum End {
    /// Nothing is violated.
    Optimal,
    /// The certificate is in the solution.
    Infeasible,
    Budget,
    /// It goes in circles even with refined points.
    Circles,
}

/// Storage of the method, made once.
#[derive(Clone, Debug, Default)]
pub(super) struct Dual {
    simd: Simd,
    hessian: Hessian,
    compact: Compact,
    set: WorkingSet,
    /// n with padding: the length of vectors of variables.
    stride: usize,
    v: Vec<f64>,
    point: Point,
    /// Which constraints are not to be checked: held, equalities, or without a remedy.
    settled: Vec<bool>,
    /// Those of them that are not held, because those held imply them, or did when it was looked at.
    implied: Vec<Active>,
    /// Indices of constraints to be looked at.
    outside: Vec<usize>,
    violated: Vec<(f64, Active)>,
    w: Vec<f64>,
    gradient: Vec<f64>,
    p: Vec<f64>,
    previous: Vec<Held>,
    /// Multipliers before a step.
    before: Vec<f64>,
    /// By constraint.
    path: Vec<homotopy::Place>,
    /// Multipliers that change their sign on a long step, and after which part of it.
    crossed: Vec<(f64, usize)>,
    /// Size of the terms of the gradient at the last residuals, in units of the variables.
    size: f64,
    /// The last residuals, relative to it.
    residual: f64,
    /// Of these, those of the constraints held.
    primal: f64,
    /// The largest `|g_j|`, in units of the variables.
    steepest: f64,
    /// The largest entry of `H x` and of g, in units of the variables.
    pull: f64,
    /// The tolerance within which the point is known to violate nothing, zero if it is so to the last digit; infinite
    /// if that is not known.
    passed: f64,
    iterations: u32,
    /// How many constraints in a row were let go as soon as they were held.
    futile: u32,
}

impl Dual {
    pub(super) fn new(capacity: Capacity, simd: Simd) -> Self {
        let Capacity { vars: n, rows: m } = capacity;
        Self {
            simd,
            hessian: Hessian::new(n, simd),
            compact: Compact::new(capacity, simd),
            set: WorkingSet::new(capacity, simd),
            v: vec![0.0; padded(n)],
            point: Point::new(capacity),
            settled: vec![false; m + n],
            implied: Vec::with_capacity(m + n),
            outside: Vec::with_capacity(m + n),
            violated: Vec::with_capacity(m + n),
            w: vec![0.0; padded(n)],
            gradient: vec![0.0; padded(n)],
            p: vec![0.0; n],
            previous: Vec::with_capacity(n),
            before: Vec::with_capacity(n + 1),
            path: vec![homotopy::Place::default(); m + n],
            crossed: Vec::with_capacity(n + 1),
            ..Self::default()
        }
    }

    pub(super) fn warm_start(&self, out: &mut WarmStart) {
        out.clear();
        for held in &self.previous {
            out.push(*held);
        }
    }

    /// The next solve begins with these; those beyond the capacity are forgotten.
    pub(super) fn start_from(&mut self, warm_start: &WarmStart) {
        self.previous.clear();
        let room = self.previous.capacity();
        self.previous.extend(warm_start.iter().take(room));
    }

    /// The next solve begins without any constraint held.
    pub(super) fn forget(&mut self) {
        self.previous.clear();
    }

    /// Solves a problem without defects. [`Status::Stalled`] says that this method does not come to an end that it can
    /// vouch for: H is not definite, or rounding is too large.
    pub(super) fn solve(
        &mut self,
        qp: &Qp,
        limits: &mut Limits<'_>,
        (iterations, start): (u32, Factorisation),
        out: &mut Solution,
    ) -> Status {
        clear(qp, out);
        self.iterations = iterations;
        let impossible = with_simd!(self.simd, impossible(qp));
        let status = if let Some(Active { index, side, .. }) = impossible {
            // Not a combination of constraints but one alone: its multiplier names it.
            add_multiplier(qp, index, side, out);
            Status::Infeasible
        } else if qp.n() == 0 {
            Status::Optimal
        } else if self.hessian.factorise(qp) {
            match start {
                Factorisation::Products if self.is_compact(qp) => self
                    .run_compact(qp, limits, out)
                    .unwrap_or_else(|| self.run(qp, limits, Factorisation::Reflections, out)),
                _ => self.run(qp, limits, start, out),
            }
        } else {
            Status::Stalled
        };
        out.iterations = self.iterations;
        let (n, m) = (qp.n(), qp.m());
        let numbers = [&out.x[..n], &out.y[..m], &out.z[..n]];
        let are_finite = with_simd!(
            self.simd,
            first_not_finite(numbers[0])
                .or(first_not_finite(numbers[1]))
                .or(first_not_finite(numbers[2]))
                .is_none()
        );
        if !are_finite {
            clear(qp, out);
            return Status::Stalled;
        }
        status
    }

    /// The next solves with [`Factorisation::Soft`] are of problems whose rows give by so much per unit of their
    /// multipliers.
    pub(super) fn soften(&mut self, compliance: &[f64]) {
        self.set.soften(compliance);
    }

    /// Computes the values of all constraints at the point.
    fn evaluate(&mut self, qp: &Qp) {
        with_simd!(self.simd, self.point.evaluate(qp));
    }

    /// The constraints held.
    pub(super) fn held(&self) -> &[Active] {
        self.set.active()
    }

    /// The next solve begins with this one, too.
    pub(super) fn begin_with(&mut self, qp: &Qp, constraint: Active) {
        if self.previous.len() < self.previous.capacity() {
            self.previous.push(identified(qp, constraint, 0.0));
        }
    }

    /// Whether a pivot may have been rounding, and the solution be as large as one divided by it.
    pub(super) fn is_doubtful(&self) -> bool {
        self.cancels()
    }

    fn is_compact(&self, qp: &Qp) -> bool {
        Compact::is_for(qp.n()) && !self.hessian.is_shifted()
    }

    /// The way of small ordinary problems; none if it does not lead to an answer.
    fn run_compact(
        &mut self,
        qp: &Qp,
        limits: &mut Limits<'_>,
        out: &mut Solution,
    ) -> Option<Status> {
        let with = (&self.hessian, &mut self.point);
        let end = self
            .compact
            .solve(qp, with, &mut self.previous, limits, &mut self.iterations);
        let status = match end {
            compact::End::Optimal => Status::Optimal,
            compact::End::Budget => limits.status(self.iterations),
            compact::End::Undecided => return None,
        };
        self.pull = self.compact.pull();
        out.x[..qp.n()].copy_from_slice(&self.point.x()[..qp.n()]);
        for (held, multiplier) in self.compact.multipliers() {
            // One of the wrong sign is rounding.
            if multiplier * held.side >= 0.0 {
                add_multiplier(qp, held.index, multiplier, out);
            }
        }
        Some(status)
    }

    fn run(
        &mut self,
        qp: &Qp,
        limits: &mut Limits<'_>,
        start: Factorisation,
        out: &mut Solution,
    ) -> Status {
        let n = qp.n();
        self.stride = padded(n);
        self.point.reset(qp);
        self.steepest = largest_product(qp.g(), self.point.unit());
        let v = &mut self.v[..self.stride];
        v[..n].copy_from_slice(qp.g());
        v[n..].fill(0.0);
        self.hessian.shift(v);
        self.hessian.solve_transposed(v);
        self.set.reset(qp, v, start);
        self.futile = 0;
        self.settled[..count(qp)].fill(false);
        self.implied.clear();
        if !self.hold_equalities(qp, out) {
            return Status::Infeasible;
        }
        self.hold_previous(qp);
        for correction in 0..CORRECTIONS {
            let forgiven = FORGIVEN[(correction as usize / 4).min(FORGIVEN.len() - 1)];
            let end = if correction < TRUSTING {
                self.ascend(qp, limits, correction == 0, out)
            } else if self.set.is_soft() {
                // There are others for that.
                break;
            } else {
                // Rounding leads that back to where it came from.
                self.ascend_refined(qp, limits, forgiven, out)
            };
            match end {
                End::Optimal | End::Circles => {}
                End::Infeasible => {
                    if self.set.is_soft() {
                        // More of the limits are going to give: the next solve goes on from here.
                        self.remember(qp);
                    }
                    return Status::Infeasible;
                }
                End::Budget => {
                    self.stop(qp, out);
                    return limits.status(self.iterations);
                }
            }
            self.refine(qp, EXACT);
            if self.point.be_strict() && self.passed > 0.0 {
                self.passed = f64::INFINITY;
            }
            let allowed = VIOLATION.max(limits.tolerance);
            let missed = self.missed(qp);
            if missed > allowed && correction < TRIALS {
                self.reconsider();
            }
            if self.is_settled(qp, limits.tolerance, forgiven) {
                self.remember(qp);
                self.write(qp, out);
                return if self.has_converged(qp) && self.primal.max(missed) <= allowed {
                    Status::Optimal
                } else {
                    Status::Stalled
                };
            }
            let is_last = correction + 1 == CORRECTIONS || matches!(end, End::Circles);
            if is_last {
                break;
            }
            self.move_on(qp, forgiven);
        }
        self.stop(qp, out);
        Status::Stalled
    }

    /// Ends before the optimum: with the minimiser on what is held, from where the next solve goes on.
    fn stop(&mut self, qp: &Qp, out: &mut Solution) {
        self.set.find_targets();
        self.set.primal(&self.hessian, self.point.x_mut());
        self.remember(qp);
        self.write(qp, out);
    }

    /// Holds all equality rows and fixed variables; false if they contradict one another.
    fn hold_equalities(&mut self, qp: &Qp, out: &mut Solution) -> bool {
        self.outside.clear();
        for constraint in equalities(qp) {
            self.settled[constraint.index] = true;
            if !self.push_beyond(qp, constraint, 0.0, DISTINCT) {
                self.outside.push(constraint.index);
            }
        }
        for i in 0..self.outside.len() {
            let index = self.outside[i];
            let constraint = equality(qp, index);
            if self.push(qp, constraint, 0.0) || is_empty(qp, index) {
                continue;
            }
            // Depends on those held: either implied by them, or in contradiction.
            self.set.combine();
            for side in [1.0, -1.0] {
                if self.contradicts(qp, Active { side, ..constraint }) {
                    self.certify(qp, index, side, out);
                    return false;
                }
            }
            self.implied.push(constraint);
        }
        true
    }

    /// Holds what was held at the end of the last solve and still exists.
    fn hold_previous(&mut self, qp: &Qp) {
        for i in 0..self.previous.len() {
            let Held {
                constraint,
                side,
                multiplier,
            } = self.previous[i];
            let Some(index) = index_of(qp, constraint).filter(|&i| !self.settled[i]) else {
                continue;
            };
            let (lower, upper) = limits(qp, index);
            let (side, limit) = if side > 0.0 {
                (1.0, upper)
            } else {
                (-1.0, lower)
            };
            let constraint = Active { index, side, limit };
            if limit.is_finite() && self.push(qp, constraint, multiplier) {
                self.settled[index] = true;
            }
        }
    }

    /// Holds a constraint; false if it depends on those held.
    fn push(&mut self, qp: &Qp, constraint: Active, multiplier: f64) -> bool {
        self.push_beyond(qp, constraint, multiplier, DEPENDENT)
    }

    /// Holds a constraint whose angle to those held has more than this sine.
    fn push_beyond(&mut self, qp: &Qp, constraint: Active, multiplier: f64, sine: f64) -> bool {
        let is_held = self
            .set
            .push(qp, &self.hessian, constraint, multiplier, sine);
        while let Some(dropped) = self.set.next_dropped() {
            self.settled[dropped.index] = dropped.side == 0.0;
        }
        is_held
    }

    /// Lets the j-th constraint held go.
    fn release(&mut self, j: usize) {
        let released = self.set.remove(j);
        self.settled[released.index] = false;
    }

    fn remember(&mut self, qp: &Qp) {
        self.previous.clear();
        for (held, m) in self.set.active().iter().zip(&self.set.multipliers) {
            if held.side != 0.0 && self.previous.len() < self.previous.capacity() {
                self.previous.push(identified(qp, *held, *m));
            }
        }
    }

    fn write(&self, qp: &Qp, out: &mut Solution) {
        out.x[..qp.n()].copy_from_slice(&self.point.x()[..qp.n()]);
        for (held, &m) in self.set.active().iter().zip(&self.set.multipliers) {
            // One of the wrong sign is rounding.
            if m * held.side >= 0.0 {
                add_multiplier(qp, held.index, m, out);
            }
        }
    }
}

fn identified(qp: &Qp, Active { index, side, .. }: Active, multiplier: f64) -> Held {
    Held {
        constraint: id_of(qp, index),
        side,
        multiplier,
    }
}

pub(super) fn clear(qp: &Qp, out: &mut Solution) {
    let (n, m) = (qp.n(), qp.m());
    out.x[..n].fill(0.0);
    out.y[..m].fill(0.0);
    out.z[..n].fill(0.0);
}

fn add_multiplier(qp: &Qp, index: usize, multiplier: f64, out: &mut Solution) {
    match index.checked_sub(qp.m()) {
        None => out.y[index] += multiplier,
        Some(j) => out.z[j] += multiplier,
    }
}
