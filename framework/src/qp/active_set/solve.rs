//! The dual iteration, from the factorisation to refined multipliers.

use super::{
    constraint::{
        Active, add_normal, copy_normal, count, equalities, largest_normal, limits, magnitude,
        value,
    },
    hessian::Hessian,
    kernels::{axpy, dot, largest, largest_product, padded},
    limits::Limits,
    point::Point,
    working_set::WorkingSet,
};
use crate::qp::{Capacity, ConstraintId, Held, Qp, Solution, Status, WarmStart};

/// Rounds in which all violated constraints are held together.
const JOINT_ROUNDS: u32 = 4;
/// Rounds in which all constraints with a multiplier of the wrong sign are let go together, before any was exact.
const GUESS_ROUNDS: u32 = 6;
/// Residual of the optimality conditions, relative to their terms, that needs no refinement.
const EXACT: f64 = 1e-14;
/// Relative residual of an optimum.
const CONVERGED: f64 = 1e-9;
/// Refinements, or proximal steps, on one set of held constraints.
const REFINEMENTS: u32 = 50;
/// Iterations after which larger violations, too, are taken for rounding.
const LONG: u32 = 200;
/// A violation below this, relative to the numbers that are added up, may be the rounding of an `x` that is not refined.
const ROUNDING: f64 = 1e-8;
/// Times that a refined point may turn out to violate a constraint, or to hold one too many.
const CORRECTIONS: u32 = 50;

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
/// Rounding of the coefficients of a combination, relative to the largest.
const COMBINED: f64 = 1e-14;

/// Why the dual iteration stopped.
enum End {
    /// Nothing is violated.
    Optimal,
    /// The certificate is in the solution.
    Infeasible,
    Budget,
}

/// Storage of the method, made once.
#[derive(Clone, Debug, Default)]
pub(super) struct Workspace {
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
    /// Size of the terms of the gradient at the last residuals, in units of the variables.
    size: f64,
    /// The last residuals, relative to it.
    residual: f64,
    /// Of these, those of the constraints held.
    primal: f64,
    /// The tolerance within which the point is known to violate nothing; infinite if that is not known.
    passed: f64,
    iterations: u32,
}

impl Workspace {
    pub(super) fn new(capacity: Capacity) -> Self {
        let Capacity { vars: n, rows: m } = capacity;
        Self {
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
        out.status = self.run(qp, &mut limits, out);
        out.iterations = self.iterations;
        let (n, m) = (qp.n(), qp.m());
        let mut numbers = out.x[..n].iter().chain(&out.y[..m]).chain(&out.z[..n]);
        if !numbers.all(|v| v.is_finite()) {
            clear(qp, out);
            out.status = Status::Failed;
        }
        if !(out.status.is_usable() || out.status == Status::Budget) {
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
            return Status::Failed;
        }
        let status = self.run_factorised(qp, limits, out);
        let is_final = status == Status::Optimal || limits.were_used_up();
        if is_final || !self.hessian.is_suspect() {
            return status;
        }
        // What was taken for curvature may have been rounding.
        clear(qp, out);
        if !self.hessian.factorise_raised(qp) {
            return Status::Failed;
        }
        self.previous.clear();
        self.run_factorised(qp, limits, out)
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
        if !self.hold_equalities(qp, out) {
            return Status::Infeasible;
        }
        self.hold_previous(qp);
        self.last[..n].fill(0.0);
        for correction in 0..CORRECTIONS {
            match self.ascend(qp, limits, correction == 0, out) {
                End::Optimal => {}
                End::Infeasible => return Status::Infeasible,
                End::Budget => {
                    self.stop(qp, out);
                    return Status::Budget;
                }
            }
            self.refine(qp);
            let raised = self.hessian.is_raised();
            if raised && self.residual > CONVERGED {
                if self.is_unbounded(qp) {
                    return Status::Unbounded;
                }
                self.last[..n].copy_from_slice(&self.point.x()[..n]);
            }
            // What goes to and fro is on the edge.
            let forgiven = FORGIVEN[(correction as usize / 4).min(FORGIVEN.len() - 1)];
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
                    Status::AlmostOptimal
                } else {
                    Status::Failed
                };
            }
            let is_last = correction + 1 == CORRECTIONS;
            if is_last && self.residual.max(missed) < ALMOST && self.is_settled(qp, ALMOST, ALMOST)
            {
                // To and fro at the edge of what can be computed.
                self.remember(qp);
                self.write(qp, out);
                return Status::AlmostOptimal;
            }
            self.move_on(qp, forgiven);
        }
        self.stop(qp, out);
        Status::Budget
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

    /// The dual iteration.
    fn ascend(
        &mut self,
        qp: &Qp,
        limits: &mut Limits<'_>,
        is_first: bool,
        out: &mut Solution,
    ) -> End {
        let (mut guess_rounds, mut joint_rounds) = if is_first {
            (GUESS_ROUNDS, JOINT_ROUNDS)
        } else {
            (0, 0)
        };
        let mut tolerance = limits.tolerance;
        loop {
            if limits.are_used_up(self.iterations) {
                return End::Budget;
            }
            self.iterations += 1;
            self.set.find_targets();
            if guess_rounds > 0 {
                // All multipliers are zero as yet, so that any of these constraints may go.
                guess_rounds -= 1;
                if self.release_wrong() {
                    continue;
                }
                guess_rounds = 0;
            } else if let Some((alpha, j)) = blocking(&self.set) {
                self.set.approach_targets(alpha);
                self.release(j);
                continue;
            }
            self.set.accept_targets();
            self.set.primal(&self.hessian, self.point.x_mut());
            self.point.evaluate(qp);
            let worst = self.find_violated(qp, tolerance);
            if self.violated.is_empty() {
                self.passed = tolerance;
                return End::Optimal;
            }
            if worst < ROUNDING || (worst < 1e3 * ROUNDING && self.iterations > LONG) {
                // May be rounding of x: constraints that are held and let go for that would never come to an end.
                // What is refined later is checked again.
                tolerance *= 2.0;
            }
            if joint_rounds > 0 && self.violated.len() > 1 {
                joint_rounds -= 1;
                let mut any = false;
                for i in 0..self.violated.len() {
                    let (_, constraint) = self.violated[i];
                    if !self.set.has_room() {
                        break;
                    }
                    if self.push(qp, constraint, 0.0) {
                        self.settled[constraint.index] = true;
                        any = true;
                    }
                }
                if any {
                    continue;
                }
                self.find_violated(qp, tolerance);
            }
            if !self.hold_worst(qp, out) {
                return End::Infeasible;
            }
        }
    }

    /// Lets all constraints go whose multiplier would have the wrong sign; whether there were any.
    fn release_wrong(&mut self) -> bool {
        let mut any = false;
        for j in (0..self.set.len()).rev() {
            let side = self.set.active()[j].side;
            if self.set.computed()[j] * side < 0.0 {
                self.release(j);
                any = true;
            }
        }
        any
    }

    fn release(&mut self, j: usize) {
        let released = self.set.remove(j);
        self.settled[released.index] = false;
    }

    /// Collects what the point violates by more than a tolerance, relative to the numbers that are added up; returns the
    /// largest relative violation.
    fn find_violated(&mut self, qp: &Qp, tolerance: f64) -> f64 {
        self.violated.clear();
        let mut worst = 0.0_f64;
        // One after the other: a chain of the two is slow to walk.
        let rows = (0, self.point.row_values(), qp.row_lower(), qp.row_upper());
        let bounds = (qp.m(), self.point.x(), qp.lower(), qp.upper());
        for (first, values, lower, upper) in [rows, bounds] {
            let limits = lower.iter().zip(upper);
            let constraints = values.iter().zip(limits).zip(&self.settled[first..]);
            for (i, ((&value, (&lower, &upper)), &settled)) in constraints.enumerate() {
                if settled || (lower <= value && value <= upper) {
                    continue;
                }
                let (excess, side, limit) = if value > upper {
                    (value - upper, 1.0, upper)
                } else {
                    (lower - value, -1.0, lower)
                };
                let index = first + i;
                let relative = excess / (limit.abs() + self.point.magnitude(qp, index));
                if relative > tolerance {
                    worst = worst.max(relative);
                    self.violated.push((excess, Active { index, side, limit }));
                }
            }
        }
        worst
    }

    /// Holds the violated constraint that is farthest away; false if that is impossible.
    fn hold_worst(&mut self, qp: &Qp, out: &mut Solution) -> bool {
        let mut worst: Option<(f64, Active)> = None;
        for &(excess, constraint) in &self.violated {
            let distance = if self.violated.len() == 1 {
                excess
            } else {
                let w = &mut self.w[..self.stride];
                copy_normal(qp, constraint.index, w);
                self.hessian.solve_transposed(w);
                excess / dot(w, w).sqrt()
            };
            if worst.is_none_or(|(d, _)| distance > d) {
                worst = Some((distance, constraint));
            }
        }
        let Some((_, constraint)) = worst else {
            return true;
        };
        let mut multiplier = 0.0;
        while !self.push(qp, constraint, multiplier) {
            self.set.combine(&self.w);
            let held = self.set.active().iter().zip(&self.set.multipliers);
            let rounding = 1e-11 * largest(self.set.computed());
            let mut first: Option<(f64, f64, usize)> = None;
            for (j, ((held, &multiplier), &r)) in held.zip(self.set.computed()).enumerate() {
                // Along the ray this multiplier changes by −side · r per unit.
                let rate = held.side * constraint.side * r;
                if rate > rounding {
                    let step = (multiplier * held.side).max(0.0) / rate;
                    if first.is_none_or(|(s, q, _)| step < s || (step == s && rate > q)) {
                        first = Some((step, rate, j));
                    }
                }
            }
            let Some((step, _, j)) = first else {
                if self.contradicts(qp, constraint) {
                    self.certify(qp, constraint.index, constraint.side, out);
                    return false;
                }
                // Implied by those held up to rounding, which is what the violation is.
                self.settled[constraint.index] = true;
                self.implied.push(constraint);
                return true;
            };
            multiplier += step * constraint.side;
            self.set.follow_ray(step * constraint.side);
            self.release(j);
            self.iterations += 1;
        }
        self.settled[constraint.index] = true;
        true
    }

    /// Whether the limits of a dependent constraint and of those held contradict one another by more than rounding.
    fn contradicts(&mut self, qp: &Qp, constraint: Active) -> bool {
        self.refine_combination(qp, constraint.index);
        let (mut sum, mut size) = (0.0, 0.0);
        let held = self.set.active().iter().zip(self.set.computed());
        let terms = held.map(|(held, r)| -constraint.side * r * held.limit);
        for term in terms.chain([constraint.side * constraint.limit]) {
            sum += term;
            size += f64::abs(term);
        }
        let is_negative = sum < -1e-9 * size;
        if !is_negative {
            return false;
        }
        // Where limits are zero, the whole sum may be the rounding of a coefficient that is zero, too.
        let unit = self.point.unit();
        let held = || self.set.active().iter().zip(self.set.computed());
        let largest = held().fold(
            largest_normal(qp, constraint.index, unit),
            |a, (held, r)| a.max(r.abs() * largest_normal(qp, held.index, unit)),
        );
        let rounding: f64 = held()
            .map(|(held, _)| held.limit.abs() / largest_normal(qp, held.index, unit))
            .sum();
        // `!(… ≤ …)`: a NaN explains nothing.
        let is_rounding = -sum <= COMBINED * largest * rounding;
        !is_rounding
    }

    /// Corrects the combination of held normals that a dependent one was found to be, by what is left of it.
    fn refine_combination(&mut self, qp: &Qp, index: usize) {
        let k = self.set.len();
        self.p[..k].copy_from_slice(self.set.computed());
        let rest = &mut self.gradient[..self.stride];
        for _ in 0..2 {
            copy_normal(qp, index, rest);
            for (held, &r) in self.set.active().iter().zip(&self.p) {
                add_normal(qp, held.index, -r, rest);
            }
            self.set.project(&self.hessian, rest);
            axpy(&mut self.p[..k], 1.0, self.set.computed());
        }
        self.set.take_combination(&self.p[..k]);
    }

    /// Writes the proof that a constraint, at one of its sides, contradicts those held, whose combination was computed last.
    fn certify(&mut self, qp: &Qp, index: usize, side: f64, out: &mut Solution) {
        for (r, held) in self.set.computed().iter().zip(self.set.active()) {
            let multiplier = -side * r;
            // One of the wrong sign is rounding, else its constraint would have been let go.
            if multiplier * held.side >= 0.0 {
                add_multiplier(qp, held.index, multiplier, out);
            }
        }
        add_multiplier(qp, index, side, out);
    }

    /// Corrects `x` and the multipliers by the residuals of the optimality conditions on the held constraints, until
    /// rounding is left.
    fn refine(&mut self, qp: &Qp) {
        let k = self.set.len();
        // A proximal step may gain slowly, a refinement gains at once or not at all.
        let stalled = if self.hessian.is_raised() { 0.95 } else { 0.3 };
        let mut before = f64::INFINITY;
        for _ in 0..REFINEMENTS {
            let residual = self.residuals(qp);
            if residual < EXACT || residual > stalled * before {
                return;
            }
            before = residual;
            let (d, p) = (&mut self.gradient[..self.stride], &mut self.p[..k]);
            self.set.correct(&self.hessian, d, p);
            axpy(self.point.x_mut(), 1.0, d);
            self.passed = f64::INFINITY;
            axpy(&mut self.set.multipliers, 1.0, p);
            self.point.evaluate(qp);
        }
        self.residuals(qp);
    }

    /// `H x + g + N λ` into `self.gradient`, `b − Nᵀ x` into `self.p`; returns the larger of the two relative to what it
    /// is the difference of.
    fn residuals(&mut self, qp: &Qp) -> f64 {
        let point = &self.point;
        let gradient = &mut self.gradient[..self.stride];
        self.hessian.product(qp, point.x(), gradient);
        gradient[qp.n()..].fill(0.0);
        let unit = point.unit();
        let mut size = largest_product(gradient, unit).max(largest_product(qp.g(), unit));
        axpy(gradient, 1.0, qp.g());
        if self.hessian.is_raised() {
            // The size of a proximal term.
            size = size.max(1e-6 * point.largest());
        }
        let mut primal = 0.0_f64;
        let held = self.set.active().iter().zip(&self.set.multipliers);
        for ((held, &m), p) in held.zip(&mut self.p) {
            add_normal(qp, held.index, m, gradient);
            *p = held.limit - point.value(held.index);
            // Else exact whatever the magnitude.
            if p.abs() > EXACT * held.limit.abs() {
                primal = primal.max(p.abs() / (held.limit.abs() + point.magnitude(qp, held.index)));
            }
        }
        let stationarity = largest_product(gradient, unit);
        // The entries of H x may be small differences of large terms, none of which exceeds the largest variable.
        self.size = size.max(point.largest()).max(f64::MIN_POSITIVE);
        self.primal = primal;
        self.residual = primal.max(stationarity / self.size);
        primal.max(stationarity / size.max(f64::MIN_POSITIVE))
    }

    /// Whether the refined point violates nothing and holds nothing with a multiplier of the wrong sign, beyond what is
    /// forgiven.
    fn is_settled(&mut self, qp: &Qp, tolerance: f64, forgiven: f64) -> bool {
        let tolerance = tolerance.max(forgiven);
        if self.passed > tolerance {
            self.find_violated(qp, tolerance);
            if !self.violated.is_empty() {
                return false;
            }
        }
        (0..self.set.len()).all(|j| !self.is_wrong(qp, j, forgiven))
    }

    /// The largest violation, relative to the numbers that are added up, of the constraints that were found to be implied.
    fn missed(&self, qp: &Qp) -> f64 {
        let mut worst = 0.0_f64;
        for implied in &self.implied {
            let away = self.point.value(implied.index) - implied.limit;
            let excess = if implied.side == 0.0 {
                away.abs()
            } else {
                away * implied.side
            };
            if excess <= 0.0 {
                continue;
            }
            let size = implied.limit.abs() + self.point.magnitude(qp, implied.index);
            let relative = excess / size;
            // A NaN is the worst.
            if relative.is_nan() {
                return f64::INFINITY;
            }
            worst = worst.max(relative);
        }
        worst
    }

    /// Has the constraints checked again that were found to be implied: those held may be others now. Equalities stay: what
    /// implies them is never let go.
    fn reconsider(&mut self) {
        let settled = &mut self.settled;
        self.implied.retain(|implied| {
            settled[implied.index] = implied.side == 0.0;
            implied.side == 0.0
        });
        self.passed = f64::INFINITY;
    }

    /// Whether the multiplier of the j-th constraint held has the wrong sign by more than is forgiven.
    fn is_wrong(&self, qp: &Qp, j: usize, forgiven: f64) -> bool {
        let held = self.set.active()[j];
        let wrong = -self.set.multipliers[j] * held.side;
        wrong > 0.0
            && wrong * largest_normal(qp, held.index, self.point.unit()) > forgiven * self.size
    }

    /// The next proximal step, or another look at a point that was refined: what is wrongly held is let go.
    fn move_on(&mut self, qp: &Qp, forgiven: f64) {
        let w = &mut self.w[..self.stride];
        self.set.centre(&self.hessian, self.point.x(), w);
        for j in (0..self.set.len()).rev() {
            if self.is_wrong(qp, j, forgiven) {
                self.release(j);
            }
        }
        for (held, m) in self.set.held_mut() {
            if *m * held.side < 0.0 {
                *m = 0.0;
            }
        }
    }

    /// Whether the last proximal steps went along a direction in which the cost falls for ever.
    fn is_unbounded(&mut self, qp: &Qp) -> bool {
        let n = qp.n();
        let d = &mut self.w[..n];
        for ((d, x), last) in d.iter_mut().zip(self.point.x()).zip(&self.last) {
            *d = x - last;
        }
        let d = &self.w[..n];
        let size = largest(d);
        let flat = qp
            .h()
            .chunks_exact(n)
            .all(|h| dot(h, d).abs() <= 1e-9 * size);
        let free = (0..count(qp)).all(|index| {
            let (lower, upper) = limits(qp, index);
            let rate = value(qp, index, d);
            let rounding = 1e-9 * magnitude(qp, index, d, self.point.unit(), size);
            (upper.is_infinite() || rate <= rounding) && (lower.is_infinite() || rate >= -rounding)
        });
        flat && free && dot(qp.g(), d) < 0.0
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

/// The first multiplier that changes its sign on the way to the targets, and after which part of the way.
fn blocking(set: &WorkingSet) -> Option<(f64, usize)> {
    let mut first: Option<(f64, usize)> = None;
    let multipliers = set.multipliers.iter().zip(set.computed());
    for (j, (held, (m, t))) in set.active().iter().zip(multipliers).enumerate() {
        let (m, t) = ((m * held.side).max(0.0), t * held.side);
        if t < 0.0 {
            let alpha = m / (m - t);
            if first.is_none_or(|(a, _)| alpha < a) {
                first = Some((alpha, j));
            }
        }
    }
    first
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
