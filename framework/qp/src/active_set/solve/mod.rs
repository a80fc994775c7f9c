//! The method's storage, and its way from the factorisation to a refined optimum.

mod ascent;
mod proof;
mod refinement;

use super::{
    constraint::{Active, copy_normal, count, equalities, limits},
    hessian::Hessian,
    kernels::padded,
    limits::Limits,
    point::Point,
    working_set::WorkingSet,
};
use crate::{Capacity, ConstraintId, Held, Qp, Solution, Status, WarmStart};

/// Residual of the optimality conditions, relative to their terms, that needs no refinement.
const EXACT: f64 = 1e-14;
/// Relative residual of an optimum.
const CONVERGED: f64 = 1e-9;
/// Times that a refined point may turn out to violate a constraint, or to hold one too many.
const CORRECTIONS: u32 = 50;
/// How many of these trust points that are not refined.
const TRUSTING: u32 = 2;

/// Relative violation, or multiplier of the wrong sign, that a refined point may have: the second after a few corrections,
/// which only degenerate problems need.
const FORGIVEN: [f64; 2] = [1e-11, 3e-11];
/// Largest relative violation of an optimum, constraints that are held or implied included. What it is relative to, a limit
/// and the terms of a value added up, is about twice the largest of them, of which this is 1e-10.
const VIOLATION: f64 = 5e-11;
/// The same of a point that is almost optimal, and of its multipliers' signs.
const ALMOST: f64 = 1e-6;
/// Times that constraints which seemed to be implied are tried again: once after each of the first corrections.
const TRIALS: u32 = 2;

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
pub(super) struct Workspace {
    capacity: Capacity,
    hessian: Hessian,
    set: WorkingSet,
    /// n with padding: the length of vectors of variables.
    stride: usize,
    v: Vec<f64>,
    point: Point,
    /// Where the last proximal steps began.
    last: Vec<f64>,
    /// Which constraints are not to be checked: held, equalities, or without a remedy.
    settled: Vec<bool>,
    /// Those of them that are not held, because those held imply them, or did when it was looked at.
    implied: Vec<Active>,
    violated: Vec<(f64, Active)>,
    w: Vec<f64>,
    gradient: Vec<f64>,
    p: Vec<f64>,
    previous: Vec<Held>,
    /// Multipliers before a step.
    before: Vec<f64>,
    /// Per constraint `1/‖U⁻ᵀ a‖`, or zero where nobody asked.
    reciprocal_lengths: Vec<f64>,
    /// Size of the terms of the gradient at the last residuals, in units of the variables.
    size: f64,
    /// The last residuals, relative to it.
    residual: f64,
    /// Of these, those of the constraints held.
    primal: f64,
    /// The last residuals, relative to the terms of the cost alone, however large the variables are.
    residual_in_cost: f64,
    /// The tolerance within which the point is known to violate nothing; infinite if that is not known.
    passed: f64,
    iterations: u32,
}

impl Workspace {
    /// Bytes of the storage for problems up to a capacity, about.
    pub(super) fn bytes(capacity: Capacity) -> usize {
        let Capacity { vars: n, rows: m } = capacity;
        let square = padded(n).saturating_mul(padded(n));
        let words = square
            .saturating_mul(10)
            .saturating_add((m + n).saturating_mul(16));
        words.saturating_mul(size_of::<f64>())
    }

    pub(super) fn capacity(&self) -> Capacity {
        self.capacity
    }

    pub(super) fn new(capacity: Capacity) -> Self {
        let Capacity { vars: n, rows: m } = capacity;
        Self {
            capacity,
            hessian: Hessian::new(n),
            set: WorkingSet::new(n),
            v: vec![0.0; padded(n)],
            point: Point::new(capacity),
            last: vec![0.0; n],
            settled: vec![false; m + n],
            implied: Vec::with_capacity(m + n),
            violated: Vec::with_capacity(m + n),
            w: vec![0.0; padded(n)],
            gradient: vec![0.0; padded(n)],
            p: vec![0.0; n],
            previous: Vec::with_capacity(n),
            before: Vec::with_capacity(n + 1),
            reciprocal_lengths: vec![0.0; m + n],
            ..Self::default()
        }
    }

    pub(super) fn warm_start(&self, out: &mut WarmStart) {
        out.clear();
        for held in &self.previous {
            out.push(held.constraint, held.side);
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

    pub(super) fn solve(&mut self, qp: &Qp, mut limits: Limits<'_>, out: &mut Solution) {
        clear(qp, out);
        self.iterations = 0;
        out.defect = qp.defect();
        out.status = if out.defect.is_some() {
            Status::Invalid
        } else {
            self.run(qp, &mut limits, out)
        };
        out.iterations = self.iterations;
        let (n, m) = (qp.n(), qp.m());
        let mut numbers = out.x[..n].iter().chain(&out.y[..m]).chain(&out.z[..n]);
        if !numbers.all(|v| v.is_finite()) {
            clear(qp, out);
            out.status = Status::Stalled;
        }
        if !(out.status == Status::Optimal || out.status.was_cut_short()) {
            self.previous.clear();
        }
    }

    fn run(&mut self, qp: &Qp, limits: &mut Limits<'_>, out: &mut Solution) -> Status {
        if qp.n() == 0 {
            return without_variables(qp, out);
        }
        if let Some(index) = crossed(qp) {
            // Not a combination of constraints but one alone: its multiplier names it.
            add_multiplier(qp, index, 1.0, out);
            return Status::Infeasible;
        }
        if !self.hessian.factorise(qp) {
            return Status::Stalled;
        }
        loop {
            let status = self.run_factorised(qp, limits, out);
            let is_final = status == Status::Optimal || limits.were_used_up();
            let has_given_up = status == Status::Stalled;
            // What was taken for curvature may have been rounding.
            let try_again =
                self.hessian.is_suspect() || (has_given_up && self.hessian.can_be_raised_further());
            if is_final || !try_again {
                return status;
            }
            clear(qp, out);
            if !self.hessian.factorise_raised(qp) {
                return Status::Stalled;
            }
            self.previous.clear();
        }
    }

    fn run_factorised(&mut self, qp: &Qp, limits: &mut Limits<'_>, out: &mut Solution) -> Status {
        let n = qp.n();
        self.stride = padded(n);
        self.point.reset(qp);
        let v = &mut self.v[..self.stride];
        v[..n].copy_from_slice(qp.g());
        v[n..].fill(0.0);
        self.hessian.shift(v);
        self.hessian.solve_transposed(v);
        self.set.reset(n, v);
        self.settled[..count(qp)].fill(false);
        self.implied.clear();
        self.reciprocal_lengths[..count(qp)].fill(0.0);
        if !self.hold_equalities(qp, out) {
            return Status::Infeasible;
        }
        self.hold_previous(qp);
        self.last[..n].fill(0.0);
        for correction in 0..CORRECTIONS {
            let forgiven = FORGIVEN[(correction as usize / 4).min(FORGIVEN.len() - 1)];
            let end = if correction < TRUSTING {
                self.ascend(qp, limits, correction == 0, out)
            } else {
                // Rounding leads that back to where it came from.
                self.ascend_refined(qp, limits, forgiven, out)
            };
            match end {
                End::Optimal | End::Circles => {}
                End::Infeasible => return Status::Infeasible,
                End::Budget => {
                    self.stop(qp, out);
                    return limits.status(self.iterations);
                }
            }
            self.refine(qp, EXACT);
            let raised = self.hessian.is_raised();
            if raised && self.residual_in_cost > CONVERGED {
                if self.is_unbounded(qp) {
                    return Status::Unbounded;
                }
                self.last[..n].copy_from_slice(&self.point.x()[..n]);
            }
            let far = raised && self.residual > CONVERGED && correction + 1 < CORRECTIONS;
            let allowed = VIOLATION.max(limits.tolerance);
            let missed = self.missed(qp);
            if missed > allowed && correction < TRIALS {
                self.reconsider();
            }
            if self.is_settled(qp, limits.tolerance, forgiven) && !far {
                self.remember(qp);
                self.write(qp, out);
                return if self.residual < CONVERGED && self.primal.max(missed) <= allowed {
                    Status::Optimal
                } else if self.residual.max(missed) < ALMOST {
                    Status::Stalled
                } else {
                    Status::Stalled
                };
            }
            let is_last = correction + 1 == CORRECTIONS || matches!(end, End::Circles);
            if is_last && self.residual.max(missed) < ALMOST && self.is_settled(qp, ALMOST, ALMOST)
            {
                // To and fro at the edge of what can be computed.
                self.remember(qp);
                self.write(qp, out);
                return Status::Stalled;
            }
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
        for (index, limit) in equalities(qp) {
            self.settled[index] = true;
            let constraint = Active {
                index,
                side: 0.0,
                limit,
            };
            if self.push(qp, constraint, 0.0) {
                continue;
            }
            // Depends on those held: either implied by them, or in contradiction.
            self.set.combine(&self.w);
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
            let Held { constraint, side } = self.previous[i];
            let found = match constraint {
                ConstraintId::Row(id) => qp.rows().binary_search(&id).ok(),
                ConstraintId::Bound(id) => qp.vars().binary_search(&id).ok().map(|j| qp.m() + j),
            };
            let Some(index) = found.filter(|&i| !self.settled[i]) else {
                continue;
            };
            let (lower, upper) = limits(qp, index);
            let (side, limit) = if side > 0.0 {
                (1.0, upper)
            } else {
                (-1.0, lower)
            };
            let constraint = Active { index, side, limit };
            if limit.is_finite() && self.push(qp, constraint, 0.0) {
                self.settled[index] = true;
            }
        }
    }

    /// Holds a constraint, with `w` in `self.w`.
    fn push(&mut self, qp: &Qp, constraint: Active, multiplier: f64) -> bool {
        if !self.set.has_room() {
            self.rebuild(qp);
        }
        let w = &mut self.w[..self.stride];
        copy_normal(qp, constraint.index, w);
        let range = self.hessian.solve_transposed(w);
        self.set.push(constraint, multiplier, range, w)
    }

    /// Factorises the held constraints anew, when the product of reflections and rotations has become too long.
    fn rebuild(&mut self, qp: &Qp) {
        let n = qp.n();
        let count = self.set.len();
        self.violated.clear();
        for (&held, &multiplier) in self.set.active().iter().zip(&self.set.multipliers) {
            self.violated.push((multiplier, held));
        }
        self.set.linear_term(&mut self.v[..self.stride]);
        self.set.reset(n, &self.v[..self.stride]);
        for i in 0..count {
            let (multiplier, held) = self.violated[i];
            let w = &mut self.w[..self.stride];
            copy_normal(qp, held.index, w);
            let range = self.hessian.solve_transposed(w);
            if !self.set.push(held, multiplier, range, w) {
                self.settled[held.index] = held.side == 0.0;
            }
        }
    }

    /// Lets the j-th constraint held go.
    fn release(&mut self, j: usize) {
        let released = self.set.remove(j);
        self.settled[released.index] = false;
    }

    fn remember(&mut self, qp: &Qp) {
        self.previous.clear();
        for held in self.set.active().iter().filter(|h| h.side != 0.0) {
            let constraint = match held.index.checked_sub(qp.m()) {
                None => ConstraintId::Row(qp.rows()[held.index]),
                Some(j) => ConstraintId::Bound(qp.vars()[j]),
            };
            let side = held.side;
            self.previous.push(Held { constraint, side });
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

/// Nothing to choose: each row is zero, which its limits allow or not.
fn without_variables(qp: &Qp, out: &mut Solution) -> Status {
    for (i, (&lower, &upper)) in qp.row_lower().iter().zip(qp.row_upper()).enumerate() {
        if lower > 0.0 || upper < 0.0 {
            add_multiplier(qp, i, if lower > 0.0 { -1.0 } else { 1.0 }, out);
            return Status::Infeasible;
        }
    }
    Status::Optimal
}

/// A constraint whose lower limit is above its upper one.
fn crossed(qp: &Qp) -> Option<usize> {
    let crossed = |(lower, upper): (&f64, &f64)| lower > upper;
    let mut rows = qp.row_lower().iter().zip(qp.row_upper());
    let mut bounds = qp.lower().iter().zip(qp.upper());
    let bound = bounds.position(crossed).map(|j| qp.m() + j);
    rows.position(crossed).or(bound)
}

fn clear(qp: &Qp, out: &mut Solution) {
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
