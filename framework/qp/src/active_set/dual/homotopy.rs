//! From the constraints and multipliers of the last solve to those of this one, along a line.
//!
//! # Mathematics
//! Constraints that were held at an optimum, with multipliers of the right sign, are the solution of a problem with
//! limits of its own: those that its minimiser is at. On the way from these limits to the problem's own,
//! `b(τ) = b + (1 − τ) p`, the solution on what is held moves along a line, until a multiplier becomes zero, whose
//! constraint is let go, or a constraint is met, which is held from there on. So constraints come and go in the order
//! in which they would as the problem changed, and about as many as differ between the two optima; letting all go whose
//! multiplier has the wrong sign would have most of the others follow (H. J. Ferreau, H. G. Bock, M. Diehl, *An online
//! active set strategy to overcome the limitations of explicit MPC*, Int. J. Robust Nonlinear Control 18 (2008), who
//! move along the linear term, too, and so keep the proof of optimality).

use super::{
    super::{
        constraint::{Active, count, limits},
        limits::Limits,
    },
    Dual, End,
};
use crate::{Qp, Solution};

/// One step per so many variables is taken; then the iteration goes on from where this is: its multipliers are dual
/// feasible.
const PATIENCE: usize = 4;

/// How it ended.
pub(super) enum Path {
    /// On the problem's limits.
    Arrived,
    /// After too many steps, with multipliers of the right sign.
    Left,
    /// And with it the solve.
    Ended(End),
}

/// What ends a step.
#[derive(Clone, Copy)]
enum Event {
    /// The multiplier of the j-th constraint held is zero.
    Left(usize),
    /// A constraint is met.
    Met(Active),
}

impl Dual {
    /// Moves from the solution for the multipliers at hand to the one on the problem's limits. There, targets and point
    /// are computed.
    pub(super) fn follow(&mut self, qp: &Qp, budget: &mut Limits<'_>, out: &mut Solution) -> Path {
        self.begin_path(qp);
        let mut rest = 1.0;
        for _ in 0..qp.n() / PATIENCE {
            if budget.are_used_up(self.iterations) {
                return Path::Ended(End::Budget);
            }
            self.iterations += 1;
            self.set.find_targets();
            self.set.primal(&self.hessian, self.point.x_mut());
            self.evaluate(qp);
            let Some((part, event)) = self.next_event(qp, rest, budget.tolerance) else {
                return Path::Arrived;
            };
            self.set.approach_targets(part);
            for index in 0..count(qp) {
                let value = &mut self.path[index].value;
                *value += part * (self.point.value(index) - *value);
            }
            rest *= 1.0 - part;
            match event {
                Event::Left(j) => self.release(j),
                Event::Met(constraint) => {
                    self.violated.clear();
                    self.violated.push((1.0, constraint));
                    if !self.hold_worst(qp, out) {
                        return Path::Ended(End::Infeasible);
                    }
                }
            }
        }
        Path::Left
    }

    /// Takes down which limits the minimiser for the multipliers at hand is at.
    fn begin_path(&mut self, qp: &Qp) {
        for j in 0..self.set.len() {
            let (side, target) = (self.set.active()[j].side, self.set.computed()[j]);
            let m = &mut self.set.multipliers[j];
            if side == 0.0 {
                *m = target;
            }
        }
        self.set
            .primal_of_multipliers(&self.hessian, self.point.x_mut());
        self.evaluate(qp);
        for index in 0..count(qp) {
            let (value, (lower, upper)) = (self.point.value(index), limits(qp, index));
            self.path[index] = Place {
                value,
                below: (lower - value).max(0.0),
                above: (value - upper).max(0.0),
            };
        }
        for held in self.set.active() {
            let place = &mut self.path[held.index];
            if held.side > 0.0 {
                place.above = place.value - held.limit;
            } else {
                place.below = held.limit - place.value;
            }
        }
    }

    /// What comes next on the way to the point, and after which part of it.
    fn next_event(&self, qp: &Qp, rest: f64, tolerance: f64) -> Option<(f64, Event)> {
        let mut next: Option<(f64, Event)> = None;
        let mut take = |part: f64, event: Event| {
            if next.is_none_or(|(p, _)| part < p) {
                next = Some((part, event));
            }
        };
        let multipliers = self.set.multipliers.iter().zip(self.set.computed());
        for (j, (held, (m, t))) in self.set.active().iter().zip(multipliers).enumerate() {
            let (m, t) = ((m * held.side).max(0.0), t * held.side);
            if t < 0.0 {
                take(m / (m - t), Event::Left(j));
            }
        }
        for index in 0..count(qp) {
            if self.settled[index] {
                continue;
            }
            let Place {
                value,
                below,
                above,
            } = self.path[index];
            let (end, (lower, upper)) = (self.point.value(index), limits(qp, index));
            let (excess, slack, side, limit) = if end > upper {
                (end - upper, upper + rest * above - value, 1.0, upper)
            } else if end < lower {
                (lower - end, value - (lower - rest * below), -1.0, lower)
            } else {
                continue;
            };
            if excess <= tolerance * (limit.abs() + self.point.magnitude(qp, index)) {
                continue;
            }
            let slack = slack.max(0.0);
            take(
                slack / (slack + excess),
                Event::Met(Active { index, side, limit }),
            );
        }
        next
    }
}

/// Where a constraint's value is on the path, and by how much its limits were farther away at its beginning.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Place {
    value: f64,
    below: f64,
    above: f64,
}
