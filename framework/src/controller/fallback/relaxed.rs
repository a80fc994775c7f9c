//! The optimum with limits given up, where they contradict one another or the solver failed.
//!
//! # Giving up
//! The order is the configuration's: hard tasks, then constraints, then the limits of the contacts' normal forces, of
//! each the last declared first; `problem::relaxation` says what is never given up. A contradiction is made void by
//! giving up the first in this order among the limits that contradict one another; if others are left, again. So a
//! limit goes only if it contradicts limits that are to be kept longer. After [`RESOLVES`] − 1 of them everything goes
//! at once, which ends it: a tick solves at most 2 [`RESOLVES`] + 4 problems (its own, its own again by the active-set
//! method if another solver gave no proof, one for the proof before each of these, and those relaxed, each once more
//! if it stalls with rows that give).
//!
//! # From one tick to the next
//! A contradiction mostly lasts. For some ticks after one, the next tick begins with the proof: a problem with the
//! tick's constraints, and with a cost of which the constraints of the last proof have the right multipliers, so that
//! the dual method finds the proof of this tick in a few steps from there, or a point that satisfies everything; only
//! then the optimum is looked for. The relaxed problem begins with the constraints held in the last one, or with those
//! of the proof where that is another than the last, and with what had to be given up there, if what goes first is part
//! of that. A level of which no limit was exceeded by more than tasks pull it is tried again.
//!
//! The relaxed problems have a solver of their own, the active-set method, so that a solver that is configured and
//! fails does not fail twice, and the warm start of each is its own. A solver that ran out of its budget is not given
//! more time: the tick goes to the next level.

use super::Fallback;
use crate::{
    controller::{
        explanation::{is_proof, write_conflict},
        report::{LimitRow, Report, Side},
    },
    fault::Fault,
    problem::{BoundEntry, DynamicsTerms, Form, Problem},
    qp::{Budget, ConstraintId, Held, Qp, QpSolver as _, Solution, Status, WarmStart},
};

/// The most relaxed problems in a tick.
const RESOLVES: u32 = 4;
/// A proof that took more changes than this from the last one is of another contradiction: what it holds is nearer to
/// the relaxed optimum than what was held in that of the tick before.
const NEAR: u32 = 10;
/// From so many variables on, rows that give come first: fewer variables with one for each limit given up take less
/// time, as none of those solves stalls.
const MANY: usize = 32;

impl Fallback {
    /// Looks for the optimum with limits given up. On success the solution's first variables are the tick's; the error
    /// says why there is none.
    pub(in super::super) fn relax(
        &mut self,
        problem: &mut Problem,
        terms: &DynamicsTerms<'_>,
        entries: &[BoundEntry],
        qp: &mut Qp,
        solution: &mut Solution,
        report: &mut Report,
    ) -> Result<Fault, Fault> {
        let goes_on = self.is_alert();
        if solution.status.was_cut_short() {
            return Err(Fault::Solver);
        }
        if problem.has_determined() {
            // Rows that hold by substitution are part of a contradiction like all others, and may be given up.
            problem.build_with_all_rows(terms, entries, qp)?;
            solution.status = Status::Unsolved;
        }
        let (n, m) = (qp.n(), qp.m());
        if !(self.is_proven || self.is_native && is_proof(qp, solution)) {
            if !self.prove_again(qp, solution) {
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
        // Else the last relaxed optimum is of long ago, or of another contradiction.
        if !goes_on || solution.iterations > NEAR {
            self.warm.copy_from(&self.proof);
        }
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
            report.resolves = resolve;
            let status = self.solve_relaxed(problem, terms, entries, qp, report);
            if status == Status::Optimal {
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

    /// Looks for the optimum with the limits given up that are marked: with rows that give, if the problem is large,
    /// and if that comes to no end, with variables for what they give.
    fn solve_relaxed(
        &mut self,
        problem: &Problem,
        terms: &DynamicsTerms<'_>,
        entries: &[BoundEntry],
        qp: &Qp,
        report: &mut Report,
    ) -> Status {
        let forms = [Form::Compliance, Form::Slacks];
        let first = usize::from(qp.n() < MANY);
        for &form in &forms[first..] {
            self.relaxation.build(problem, terms, entries, qp, form);
            self.solver.start_from(&self.warm);
            let relaxed = &self.relaxation;
            let status = match form {
                Form::Compliance => {
                    self.solver
                        .solve_soft(&relaxed.qp, &relaxed.compliance, &mut self.solution)
                }
                Form::Slacks => {
                    self.solver
                        .solve(&relaxed.qp, Budget::Configured, &mut self.solution)
                }
            };
            report.iterations = report.iterations.saturating_add(self.solution.iterations);
            if matches!(status, Ok(Status::Optimal)) {
                break;
            }
            if is_proof(&relaxed.qp, &self.solution) {
                if form == Form::Compliance {
                    // With more given up the next one goes on from here.
                    self.solver.warm_start(&mut self.warm);
                }
                break;
            }
        }
        self.solution.status
    }

    /// Looks for a proof that limits contradict one another as they did last, and not for an optimum; whether there is
    /// one, in the solution then. Begins with the last proof. False says nothing.
    pub(in super::super) fn prove_again(&mut self, qp: &Qp, solution: &mut Solution) -> bool {
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
                report.relaxed.push(LimitRow {
                    row,
                    side: if side < 0.0 { Side::Lower } else { Side::Upper },
                    limit,
                    multiplier: 0.0,
                    short: by,
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
