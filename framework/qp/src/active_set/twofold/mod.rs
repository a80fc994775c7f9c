//! The dual method once more, in numbers of twice as many digits: for what rounding keeps the others from.
//!
//! # Mathematics
//! Rows at an angle of 1e-10 to one another, with limits on opposite sides, have a solution that depends on the tenth
//! digit of their coefficients, and multipliers of 1e10 that cancel. In the usual numbers nothing is left of what
//! decides; with 32 digits (`number`) it is as easy as others are. The method is that of Goldfarb and Idnani (1983),
//! one constraint at a time: x moves towards the violated constraint that is farthest away, along the direction that
//! leaves those held where they are, and holds it, unless a multiplier becomes zero on the way, whose constraint is let
//! go.
//!
//! Where H is not definite, `½ ρ ‖x − c‖²` is added, with so small a weight that few rounds lead to the solution (the
//! proximal method has the sources), and where many would, it is extrapolated (`extrapolation`).
//!
//! What comes out is rounded, and has to hold with the tolerances of every other solution; else the solve has stalled.

mod extrapolation;
mod factor;
mod number;
mod start;

use super::{
    constraint::{self, Active, copy_normal, count, equality, is_empty, limits},
    kernels::largest,
    limits::Limits,
    proof::Proof,
};
use crate::{Qp, Solution, Status};
use extrapolation::Extrapolation;
use factor::Factor;
pub(super) use number::Twofold;
use number::dot_with;

/// A pivot below this part of its diagonal entry is rounding of H.
const WEAK: f64 = 1e-15;
/// Weight of the proximal term beside a curvature of one, for each variable: a little more than rounding of H can take
/// away from its eigenvalues.
const WEIGHT: f64 = 2e-15;
/// Rounds with it.
const ROUNDS: u32 = 30;
/// What the proximal term may leave of the gradient.
const SETTLED: f64 = 1e-13;
/// What is left of a normal less its combination from those held, relative to the largest term, below which it
/// depends on them: rounding of coefficients.
const DEPENDENT: f64 = 1e-14;
/// A part of a combination below this of the largest is rounding of coefficients.
const ROUNDED_RATE: f64 = 1e-13;
/// A violation below this, relative to the limit and the terms, is none.
const VIOLATION: f64 = 1e-12;
/// The same of a constraint that depends on those held.
const IMPLIED: f64 = 1e-11;
/// The same beside the largest variable, in units near one: rounding of numbers with twice as many digits, however
/// small the constraint's own terms are.
const ROUNDED_TERMS: f64 = 1e-25;
/// Limits that contradict one another by rounding are taken to be so much wider, relative to the limit and the terms:
/// less than a solution may violate them.
const WIDENINGS: [f64; 4] = [0.0, 1e-13, 1e-12, 2e-11];
/// Largest residual of the stationarity conditions, relative to the sum of its terms' sizes.
const STATIONARY: f64 = 1e-11;
/// Where the terms of the gradient are smaller than this in a unit in which the cost is near one, there is no cost.
const NO_COST: f64 = 1e-10;
/// What the weighted limits have to be below zero by in a proof of infeasibility, relative to the terms: at once, and
/// if wider limits contradict one another as well.
const BEYOND: [f64; 2] = [1e-9, 1e-13];

/// Why the iteration stopped.
enum End {
    /// Nothing is violated.
    Optimal,
    /// A constraint contradicts those held.
    Contradiction(Active),
    Budget,
}

/// Storage of the method, made once.
#[derive(Clone, Debug)]
pub(super) struct Precise {
    factor: Factor,
    x: Vec<Twofold>,
    /// The linear term, with what is proximal.
    g: Vec<Twofold>,
    centre: Vec<Twofold>,
    extrapolation: Extrapolation,
    active: Vec<Active>,
    multipliers: Vec<Twofold>,
    /// What another method held, with which the first ascent begins.
    start: Vec<Active>,
    /// What the values of those held lack.
    excess: Vec<Twofold>,
    /// What their multipliers change by with it.
    corrections: Vec<Twofold>,
    widening: f64,
    /// Whether a point was found that violates nothing.
    is_feasible: bool,
    /// `|a|ᵀ |x|` where the limits contradicted one another.
    sizes: Vec<f64>,
    /// Constraints that are not to be looked at: held, or implied by those held.
    settled: Vec<bool>,
    normal: Vec<f64>,
    /// What is left of it less its combination.
    rest: Vec<Twofold>,
    terms: Vec<f64>,
}

impl Precise {
    pub(super) fn new(n: usize, rows: usize) -> Self {
        Self {
            factor: Factor::new(n),
            x: vec![Twofold::ZERO; n],
            g: vec![Twofold::ZERO; n],
            centre: vec![Twofold::ZERO; n],
            extrapolation: Extrapolation::new(n),
            active: Vec::with_capacity(n),
            multipliers: Vec::with_capacity(n),
            start: Vec::with_capacity(n),
            excess: vec![Twofold::ZERO; n],
            corrections: vec![Twofold::ZERO; n],
            widening: 0.0,
            is_feasible: false,
            sizes: vec![0.0; n + rows],
            settled: vec![false; n + rows],
            normal: vec![0.0; n],
            rest: vec![Twofold::ZERO; n],
            terms: vec![0.0; n],
        }
    }

    /// Solves a problem in units near one with the cost `½ xᵀ H x + gᵀ x`. [`Status::Stalled`] if that does not come
    /// to an end that can be proven.
    pub(super) fn solve(
        &mut self,
        problem: (&Qp, &[f64], &[f64]),
        limits: &mut Limits<'_>,
        out: &mut Solution,
    ) -> Status {
        let mut status = Status::Stalled;
        self.is_feasible = false;
        for widening in WIDENINGS {
            self.widening = widening;
            status = self.iterate(problem, limits, out);
            if status != Status::Stalled {
                break;
            }
            self.start.clear();
            for index in 0..count(problem.0) {
                self.sizes[index] = self.size(problem.0, index);
            }
        }
        status
    }

    /// Whether the last solve, whatever it ended with, came by a point that violates nothing.
    pub(super) fn is_feasible(&self) -> bool {
        self.is_feasible
    }

    /// The proximal iteration, which ends after one round if H is definite.
    fn iterate(
        &mut self,
        (scaled, h, g): (&Qp, &[f64], &[f64]),
        limits: &mut Limits<'_>,
        out: &mut Solution,
    ) -> Status {
        let n = scaled.n();
        self.centre[..n].fill(Twofold::ZERO);
        self.extrapolation.reset();
        let mut rho = 0.0;
        self.active.clear();
        self.multipliers.clear();
        if !self.factor.reset(n, (h, rho), WEAK) {
            let curvature = h.iter().step_by(n + 1).fold(0.0, |a: f64, h| a.max(*h));
            rho = WEIGHT * n as f64 * if curvature > 0.0 { curvature } else { 1.0 };
            if !self.factor.reset(n, (h, rho), 0.0) {
                return Status::Stalled;
            }
        }
        // Each round begins with what the one before held.
        for round in 1..=ROUNDS {
            for ((out, g), c) in self.g.iter_mut().zip(g).zip(&self.centre) {
                *out = Twofold::new(*g) - *c * rho;
            }
            self.factor.minimise(&self.g[..n], &mut self.x[..n]);
            let before = out.iterations;
            match self.ascend(scaled, limits, &mut out.iterations) {
                End::Optimal => self.is_feasible = true,
                End::Budget => return limits.status(out.iterations),
                End::Contradiction(constraint) => {
                    self.write_proof(scaled, constraint, out);
                    let proof = Proof::of(scaled, out);
                    let is_last = Some(&self.widening) == WIDENINGS.last();
                    return if proof.is_closed && proof.margin > BEYOND[usize::from(is_last)] {
                        Status::Infeasible
                    } else {
                        Status::Stalled
                    };
                }
            }
            let moved = self.x[..n].iter().zip(&self.centre);
            let moved = moved.fold(0.0, |a: f64, (x, c)| a.max((*x - *c).abs().rounded()));
            let (left, cost) = (rho * moved, largest(g).max(rho));
            let accepted = if round == ROUNDS { STATIONARY } else { SETTLED };
            if left <= accepted * cost {
                self.write(scaled, out);
                constraint::keep_bounds(scaled, out);
                let is_solution = self.is_stationary((scaled, h, g), out)
                    && constraint::all_hold(scaled, &out.x[..n]);
                if is_solution {
                    return Status::Optimal;
                }
                // Else what the proximal term left may be much beside small terms.
                if left <= ROUNDED_TERMS * cost {
                    return Status::Stalled;
                }
            }
            if out.iterations > before {
                self.extrapolation.begin_face();
            }
            self.extrapolation
                .advance(&self.x[..n], &mut self.centre[..n]);
        }
        Status::Stalled
    }

    /// Holds what is violated until nothing is.
    fn ascend(&mut self, scaled: &Qp, limits: &mut Limits<'_>, iterations: &mut u32) -> End {
        let all = count(scaled);
        self.settled[..all].fill(false);
        for held in &self.active {
            self.settled[held.index] = true;
        }
        if let Err(end) = self.gather(scaled, limits, iterations) {
            return end;
        }
        self.begin(scaled);
        for index in 0..all {
            let (lower, upper) = constraint::limits(scaled, index);
            // With limits that are wider nothing is one.
            if self.settled[index] || lower != upper || self.widening > 0.0 {
                continue;
            }
            let held = equality(scaled, index);
            if let Err(end) = self.hold(scaled, held, limits, iterations) {
                return end;
            }
        }
        while let Some(constraint) = self.farthest(scaled) {
            if let Err(end) = self.hold(scaled, constraint, limits, iterations) {
                return end;
            }
        }
        End::Optimal
    }

    /// The violated constraint that is farthest away.
    fn farthest(&self, scaled: &Qp) -> Option<Active> {
        let mut farthest: Option<(f64, Active)> = None;
        for index in (0..count(scaled)).filter(|index| !self.settled[*index]) {
            let value = self.value(scaled, index);
            let (lower, upper) = limits(scaled, index);
            // Zero beside a limit that is infinite.
            let beyond = |limit: f64, side: f64| {
                let excess = (value - Twofold::new(limit)) * side;
                if limit.is_finite() {
                    excess.rounded()
                } else {
                    0.0
                }
            };
            let (above, below) = (beyond(upper, 1.0), beyond(lower, -1.0));
            let (excess, side, limit) = if above > 0.0 {
                (above, 1.0, upper)
            } else if below > 0.0 {
                (below, -1.0, lower)
            } else {
                continue;
            };
            let wider = self.widening * (limit.abs() + self.sizes[index]);
            let size = limit.abs() + self.size(scaled, index);
            let is_violated = excess > (VIOLATION * size).max(2.0 * wider);
            let limit = limit + side * wider;
            if is_violated && farthest.is_none_or(|(most, _)| excess > most) {
                farthest = Some((excess, Active { index, side, limit }));
            }
        }
        farthest.map(|(_, constraint)| constraint)
    }

    /// `aᵀ x`.
    fn value(&self, scaled: &Qp, index: usize) -> Twofold {
        match index.checked_sub(scaled.m()) {
            None => dot_with(scaled.row(index), &self.x),
            Some(j) => self.x[j],
        }
    }

    /// `|a|ᵀ |x|`.
    fn size(&self, scaled: &Qp, index: usize) -> f64 {
        match index.checked_sub(scaled.m()) {
            None => {
                let terms = scaled.row(index).iter().zip(&self.x);
                terms.map(|(a, x)| (a * x.rounded()).abs()).sum()
            }
            Some(j) => self.x[j].abs().rounded(),
        }
    }

    /// The largest of the n variables.
    fn largest(&self, n: usize) -> f64 {
        let sizes = self.x[..n].iter().map(|x| x.abs().rounded());
        sizes.fold(0.0, f64::max)
    }

    /// Moves to a constraint and holds it; lets others go on the way.
    fn hold(
        &mut self,
        scaled: &Qp,
        constraint: Active,
        limits: &mut Limits<'_>,
        iterations: &mut u32,
    ) -> Result<(), End> {
        let n = scaled.n();
        let Active { index, side, limit } = constraint;
        self.settled[index] = true;
        let mut multiplier = Twofold::ZERO;
        loop {
            if limits.are_used_up(*iterations) {
                return Err(End::Budget);
            }
            *iterations += 1;
            copy_normal(scaled, index, &mut self.normal[..n]);
            let rest = self.factor.look(&self.normal[..n]);
            let excess = self.value(scaled, index) - Twofold::new(limit);
            let is_free = rest.rounded() > 0.0 && !self.depends(scaled);
            let rounding = IMPLIED * (limit.abs() + self.size(scaled, index));
            let rounding = rounding.max(ROUNDED_TERMS * self.largest(n));
            if !is_free && (excess.abs().rounded() <= rounding || is_empty(scaled, index)) {
                // By those held.
                return Ok(());
            }
            // Along the step the multiplier grows by t on its side, and x moves by −t z.
            let full = if is_free { Some(excess / rest) } else { None };
            let direction = if side == 0.0 {
                if excess.rounded() < 0.0 { -1.0 } else { 1.0 }
            } else {
                side
            };
            let first = self.first_released(direction);
            let length = full.map(|full| full * direction);
            let is_full = match (length, first) {
                (Some(length), Some((part, _))) => (length - part).rounded() <= 0.0,
                (Some(_), None) => true,
                (None, Some(_)) => false,
                (None, None) => {
                    return Err(End::Contradiction(Active {
                        side: direction,
                        ..constraint
                    }));
                }
            };
            let step = match (is_full, length, first) {
                (true, Some(length), _) => length,
                (_, _, Some((part, _))) => part,
                _ => Twofold::ZERO,
            } * direction;
            if is_free {
                self.factor.step(-step, &mut self.x[..n]);
            }
            let changes = self.multipliers.iter_mut().zip(self.factor.combination());
            for (m, r) in changes {
                *m -= step * *r;
            }
            multiplier += step;
            if is_full {
                self.factor.push();
                self.active.push(constraint);
                self.multipliers.push(multiplier);
                self.refine(scaled);
                return Ok(());
            }
            if let Some((_, j)) = first {
                self.factor.remove(j);
                self.multipliers.remove(j);
                self.active.remove(j);
                // What those held implied, others may not.
                self.settled[..count(scaled)].fill(false);
                for held in self.active.iter().chain([&constraint]) {
                    self.settled[held.index] = true;
                }
            }
        }
    }

    /// Whether the constraint looked at depends on those held, its normal being in `normal`.
    fn depends(&mut self, scaled: &Qp) -> bool {
        let (n, m) = (scaled.n(), scaled.m());
        let (rest, terms) = (&mut self.rest[..n], &mut self.terms[..n]);
        for ((rest, term), a) in rest.iter_mut().zip(terms.iter_mut()).zip(&self.normal) {
            (*rest, *term) = (Twofold::new(*a), a.abs());
        }
        for (held, r) in self.active.iter().zip(self.factor.combination()) {
            match held.index.checked_sub(m) {
                None => {
                    let pairs = rest.iter_mut().zip(terms.iter_mut());
                    for ((rest, term), a) in pairs.zip(scaled.row(held.index)) {
                        let part = *r * *a;
                        *rest -= part;
                        *term += part.abs().rounded();
                    }
                }
                Some(j) => {
                    rest[j] -= *r;
                    terms[j] += r.abs().rounded();
                }
            }
        }
        let most = rest.iter().fold(0.0, |a: f64, r| a.max(r.abs().rounded()));
        most <= DEPENDENT * largest(terms)
    }

    /// The multiplier that becomes zero first as that of the constraint looked at grows in a direction, and when.
    fn first_released(&self, direction: f64) -> Option<(Twofold, usize)> {
        let parts = self.factor.combination();
        let largest = parts.iter().fold(0.0, |a: f64, r| a.max(r.abs().rounded()));
        let mut first: Option<(Twofold, usize)> = None;
        for (j, ((held, m), r)) in self
            .active
            .iter()
            .zip(&self.multipliers)
            .zip(parts)
            .enumerate()
        {
            let rate = *r * (held.side * direction);
            if rate.rounded() <= ROUNDED_RATE * largest {
                continue;
            }
            let left = *m * held.side;
            let left = if left.rounded() > 0.0 {
                left
            } else {
                Twofold::ZERO
            };
            let step = left / rate;
            if first.is_none_or(|(least, _)| (step - least).rounded() < 0.0) {
                first = Some((step, j));
            }
        }
        first
    }

    fn write(&self, scaled: &Qp, out: &mut Solution) {
        let (n, m) = (scaled.n(), scaled.m());
        for (out, x) in out.x[..n].iter_mut().zip(&self.x) {
            *out = x.rounded();
        }
        out.y[..m].fill(0.0);
        out.z[..n].fill(0.0);
        for (held, multiplier) in self.active.iter().zip(&self.multipliers) {
            put(scaled, held.index, multiplier.rounded(), out);
        }
    }

    /// The proof that a constraint, at one of its sides, contradicts those held.
    fn write_proof(&self, scaled: &Qp, constraint: Active, out: &mut Solution) {
        let (n, m) = (scaled.n(), scaled.m());
        out.x[..n].fill(0.0);
        out.y[..m].fill(0.0);
        out.z[..n].fill(0.0);
        for (held, r) in self.active.iter().zip(self.factor.combination()) {
            let multiplier = -constraint.side * r.rounded();
            if multiplier * held.side >= 0.0 {
                put(scaled, held.index, multiplier, out);
            }
        }
        put(scaled, constraint.index, constraint.side, out);
    }

    /// Whether the rounded solution is stationary.
    fn is_stationary(&mut self, (scaled, h, g): (&Qp, &[f64], &[f64]), out: &Solution) -> bool {
        let (n, m) = (scaled.n(), scaled.m());
        let (rest, terms) = (&mut self.normal[..n], &mut self.terms[..n]);
        rest.copy_from_slice(g);
        terms.fill(0.0);
        for held in &self.active {
            match held.index.checked_sub(m) {
                None => {
                    let (row, y) = (scaled.row(held.index), out.y[held.index]);
                    for ((rest, term), a) in rest.iter_mut().zip(terms.iter_mut()).zip(row) {
                        *rest += a * y;
                        *term += (a * y).abs();
                    }
                }
                Some(j) => {
                    rest[j] += out.z[j];
                    terms[j] += out.z[j].abs();
                }
            }
        }
        let x = &out.x[..n];
        for (i, (rest, terms)) in rest.iter_mut().zip(terms.iter_mut()).enumerate() {
            *terms += g[i].abs();
            for (h, x) in h[i * n..(i + 1) * n].iter().zip(x) {
                *rest += h * x;
                *terms += (h * x).abs();
            }
        }
        let rounding = f64::EPSILON * (n + m) as f64 * largest(terms).max(NO_COST);
        let mut pairs = rest.iter().zip(&*terms);
        pairs.all(|(rest, terms)| rest.abs() <= STATIONARY * terms || rest.abs() <= rounding)
    }
}

fn put(scaled: &Qp, index: usize, multiplier: f64, out: &mut Solution) {
    match index.checked_sub(scaled.m()) {
        None => out.y[index] = multiplier,
        Some(j) => out.z[j] = multiplier,
    }
}
