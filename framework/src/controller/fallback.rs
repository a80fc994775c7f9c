//! What a tick falls back on when its problem has no solution that may be sent.
//!
//! | level | when | command |
//! |---|---|---|
//! | optimal | | the optimum |
//! | relaxed | limits contradict one another, or the solver failed | the optimum with limits given up in the declared order |
//! | extrapolated | no solution, for as long as `extrapolation` says | the last efforts, kept |
//! | safe | no solution for longer, or never one | a [law](crate::plugin::FallbackLaw) that needs no solver |
//!
//! # Giving up
//! The order is the configuration's: hard tasks, then constraints, then the limits of the contacts' normal forces, of
//! each the last declared first; `problem::relaxation` says what is never given up. A contradiction is made void by
//! giving up the first in this order among the limits that contradict one another; if others are left, again. So a
//! limit goes only if it contradicts limits that are to be kept longer. After [`RESOLVES`] − 1 of them everything goes
//! at once, which ends it: a tick solves at most [`RESOLVES`] + 2 problems (its own, its own again by the active-set
//! method if another solver gave no proof, and those).
//!
//! # From one tick to the next
//! A contradiction mostly lasts. For some ticks after one, the next tick begins with the proof: a problem with the
//! tick's constraints, and with a cost of which the constraints of the last proof have the right multipliers, so that
//! the dual method finds the proof of this tick in a few steps from there, or a point that satisfies everything; only
//! then the optimum is looked for. The relaxed problem begins with the constraints held in the last one, and with what
//! had to be given up there, if what goes first is part of that. A level of which no limit was exceeded by more than
//! tasks pull it is tried again.
//!
//! The relaxed problems have a solver of their own, the active-set method, so that a solver that is configured and
//! fails does not fail twice, and the warm start of each is its own. A solver that ran out of its budget is not given
//! more time: the tick goes to the next level.

use super::{
    explanation::{is_proof, write_conflict},
    measurement::Measurement,
    names::Owner,
    report::{FallbackLevel, OnLevel, RelaxedRow, Report, Side},
};
use crate::{
    fault::Fault,
    plugin::BoundFallbackLaw,
    problem::{BoundEntry, DynamicsTerms, Problem, Relaxation},
    qp::{ActiveSet, Budget, ConstraintId, Held, Qp, QpSolver, Solution, Status, WarmStart},
};

/// For how many ticks after a contradiction the next one is looked for before the optimum.
const ALERT: u32 = 50;
/// The most relaxed problems in a tick.
const RESOLVES: u32 = 4;

/// The fallback levels, and what they need, in storage made once.
#[derive(Debug)]
pub(super) struct Fallback {
    /// Where the last tick ended, and since when.
    pub(super) level: FallbackLevel,
    pub(super) on_level: OnLevel,
    pub(super) relaxation: Relaxation,
    pub(super) solver: ActiveSet,
    pub(super) solution: Solution,
    /// What the relaxed problem of the last tick held, if it had one.
    pub(super) warm: WarmStart,
    /// The limits that contradicted one another last, but for one; none if none ever did.
    pub(super) proof: WarmStart,
    /// Ticks since then.
    pub(super) since_proof: u32,
    /// Whether the solution of this tick is a proof by the active-set method.
    pub(super) is_proven: bool,
    /// Whether the configured solver is the active-set method, whose proofs are irreducible.
    pub(super) is_native: bool,
    pub(super) law: BoundFallbackLaw,
    /// The efforts that come nearest to holding the home posture.
    pub(super) hover: Vec<f64>,
    /// Whose each row is, in words, for explanations.
    pub(super) owners: Vec<Owner>,
    /// Since the last solution and the last usable measurement.
    pub(super) without_solution: Age,
    pub(super) without_state: Age,
    pub(super) clock: Clock,
}

/// Tells a stamp that is out of order from a clock that was set.
///
/// A stamp that is not later than the last usable one is a fault. A clock that goes on regularly from an earlier time,
/// for [`Clock::STEADY`] ticks, was set: it is used again from there, and the controller's own time goes on without a
/// jump.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Clock {
    pub(super) previous: Option<f64>,
    pub(super) steady: u32,
}

impl Clock {
    const STEADY: u32 = 10;

    /// Takes a stamp; true if the clock was set. `last` is the last usable stamp.
    pub(super) fn was_set(&mut self, stamp: f64, last: Option<f64>, period: f64) -> bool {
        let goes_on = self.previous.is_some_and(|previous| {
            let step = stamp - previous;
            step > 0.0 && step < 10.0 * period
        });
        self.previous = Some(stamp);
        let is_early = last.is_some_and(|last| stamp <= last);
        self.steady = if goes_on && is_early {
            self.steady + 1
        } else {
            0
        };
        if self.steady < Self::STEADY {
            return false;
        }
        self.steady = 0;
        true
    }
}

/// How long ago something was.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Age {
    /// Time stamp and ticks since; nothing if it never was.
    pub(super) last: Option<(f64, u64)>,
}

impl Age {
    /// It is in this tick.
    pub(super) fn renew(&mut self, time: f64) {
        self.last = Some((time, 0));
    }

    /// A tick has begun.
    pub(super) fn pass(&mut self) {
        if let Some((_, ticks)) = &mut self.last {
            *ticks = ticks.saturating_add(1);
        }
    }

    pub(super) fn time(&self) -> Option<f64> {
        self.last.map(|(time, _)| time)
    }

    /// Seconds: by the clock or by the number of ticks, whichever is longer; infinite if it never was.
    pub(super) fn seconds(&self, now: f64, period: f64) -> f64 {
        self.last.map_or(f64::INFINITY, |(time, ticks)| {
            let passed = ticks as f64 * period;
            // A stamp that is not a number says nothing.
            if now.is_finite() {
                passed.max(now - time)
            } else {
                passed
            }
        })
    }
}

impl Fallback {
    /// Looks for the optimum with limits given up. On success the solution's first variables are the tick's; the error
    /// says why there is none.
    pub(super) fn relax(
        &mut self,
        problem: &Problem,
        terms: &DynamicsTerms<'_>,
        entries: &[BoundEntry],
        qp: &Qp,
        solution: &mut Solution,
        report: &mut Report,
    ) -> Result<Fault, Fault> {
        let (n, m) = (qp.n(), qp.m());
        let goes_on = self.is_alert();
        if solution.status.was_cut_short() {
            return Err(Fault::Solver);
        }
        let is_native = self.is_native || self.is_proven;
        if !(is_native && is_proof(qp, solution)) {
            if !self.is_still_infeasible(qp, solution) {
                self.solver.reset();
                let solved = self
                    .solver
                    .solve(qp, Budget::Configured, &mut self.solution);
                if solved == Ok(Status::Optimal) {
                    self.hand_over(n, m, solution);
                    return Ok(Fault::Solver);
                }
                if !is_proof(qp, &self.solution) {
                    return Err(Fault::Solver);
                }
                self.hand_over(n, m, solution);
            }
            report.iterations = report.iterations.saturating_add(self.solution.iterations);
            report.status = Status::Infeasible;
        }
        write_conflict(problem, qp, solution, &mut report.conflict);
        write_proof(qp, solution, &mut self.proof);
        self.since_proof = 0;
        self.relaxation.restore();
        if !self
            .relaxation
            .give_up_in(problem, terms.contacts, qp, solution)
        {
            return Err(Fault::Infeasible);
        }
        if goes_on {
            self.relaxation.give_up_as_before();
        }
        let mut is_last = false;
        for resolve in 1..=RESOLVES {
            is_last |= resolve == RESOLVES;
            if is_last {
                self.relaxation.give_up_all();
            }
            self.relaxation.build(problem, terms, entries, qp);
            self.solver.start_from(&self.warm);
            let status =
                self.solver
                    .solve(&self.relaxation.qp, Budget::Configured, &mut self.solution);
            report.resolves = resolve;
            report.iterations = report.iterations.saturating_add(self.solution.iterations);
            if status == Ok(Status::Optimal) {
                self.report_exceeded(problem, qp, report);
                self.hand_over(n, m, solution);
                self.solver.warm_start(&mut self.warm);
                self.relaxation.remember(problem, qp, &self.solution.x);
                return Ok(Fault::Infeasible);
            }
            if is_last {
                break;
            }
            let proof = &self.solution;
            is_last = !(is_proof(&self.relaxation.qp, proof)
                && self.relaxation.give_up_more(problem, terms.contacts, proof));
        }
        Err(Fault::Infeasible)
    }

    /// Whether limits contradicted one another a short time ago.
    pub(super) fn is_alert(&self) -> bool {
        self.since_proof < ALERT && self.proof.iter().next().is_some()
    }

    /// A tick without a contradiction.
    pub(super) fn calm(&mut self) {
        self.since_proof = self.since_proof.saturating_add(1);
    }

    /// Whether limits contradict one another as they did last; if so, the proof is in the solution. Begins with the
    /// last proof, and does not look for an optimum. False says nothing.
    pub(super) fn is_still_infeasible(&mut self, qp: &Qp, solution: &mut Solution) -> bool {
        if self.proof.iter().next().is_none() {
            return false;
        }
        self.relaxation.prove(qp, &self.proof);
        self.solver.start_from(&self.proof);
        let status = self
            .solver
            .solve(&self.relaxation.qp, Budget::Configured, &mut self.solution);
        solution.iterations = self.solution.iterations;
        self.is_proven = status == Ok(Status::Infeasible) && is_proof(qp, &self.solution);
        if self.is_proven {
            self.hand_over(qp.n(), qp.m(), solution);
        }
        self.is_proven
    }

    /// Copies what belongs to the tick's own variables and rows.
    fn hand_over(&self, n: usize, m: usize, solution: &mut Solution) {
        solution.status = self.solution.status;
        solution.x[..n].copy_from_slice(&self.solution.x[..n]);
        solution.y[..m].copy_from_slice(&self.solution.y[..m]);
        solution.z[..n].copy_from_slice(&self.solution.z[..n]);
    }

    fn report_exceeded(&self, problem: &Problem, qp: &Qp, report: &mut Report) {
        for (row, side, limit, by) in self.relaxation.exceeded(problem, qp, &self.solution.x) {
            if report.relaxed.len() < report.relaxed.capacity() {
                report.relaxed.push(RelaxedRow {
                    row,
                    side: if side < 0.0 { Side::Lower } else { Side::Upper },
                    limit,
                    by,
                });
            }
        }
    }
}

/// Takes down the limits of a proof but for one of them, an inequality if there is one: the rest can be met together.
fn write_proof(qp: &Qp, proof: &Solution, out: &mut WarmStart) {
    // The problem that begins with it has a cost, and multipliers, of its own.
    let held = |constraint, side| Held {
        constraint,
        side,
        multiplier: 0.0,
    };
    out.clear();
    let (rows, bounds) = (&proof.y[..qp.m()], &proof.z[..qp.n()]);
    let last_bound = bounds.iter().rposition(|z| *z != 0.0);
    let is_inequality = |i: &usize| rows[*i] != 0.0 && qp.row_lower()[*i] != qp.row_upper()[*i];
    let last_row = match last_bound {
        Some(_) => None,
        None => (0..qp.m()).rev().find(is_inequality),
    };
    for (i, (y, id)) in rows.iter().zip(qp.rows()).enumerate() {
        if *y != 0.0 && Some(i) != last_row {
            out.push(held(ConstraintId::Row(*id), y.signum()));
        }
    }
    for (j, (z, id)) in bounds.iter().zip(qp.vars()).enumerate() {
        if *z != 0.0 && Some(j) != last_bound {
            out.push(held(ConstraintId::Bound(*id), z.signum()));
        }
    }
}

impl OnLevel {
    /// One more tick on a level.
    pub(super) fn step(&mut self, changed: bool, measurement: &Measurement, last: Option<f64>) {
        if changed || self.ticks == 0 {
            let stamp = measurement.time;
            self.since = if stamp.is_finite() {
                stamp
            } else {
                last.unwrap_or(0.0)
            };
            self.ticks = 0;
        }
        self.ticks = self.ticks.saturating_add(1);
    }
}

impl FallbackLevel {
    /// Whether the command is the solution of a problem of this tick.
    pub fn is_solved(self) -> bool {
        matches!(self, Self::Optimal | Self::Relaxed)
    }
}
