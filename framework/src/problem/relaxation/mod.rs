//! The problem of a tick with some of its limits given up.
//!
//! # Mathematics
//! A limit `l ≤ a x ≤ u` that is given up becomes `l ≤ a x + e ≤ u` with a free variable `e` of its own that costs
//! `w e²`; `e` is what the solution takes beyond the limit. An equality is the case `l = u`, a bound on a variable the
//! case of a unit row, and so is a bound on an eliminated effort, whose row stays with the actuator's own limits. So
//! the problem keeps its rows and says by how much each limit given up had to give. Of a large problem the active-set
//! method eliminates `e`, whose row gives by `1/w` per unit of its multiplier
//! ([`ActiveSet::solve_soft`](crate::qp::ActiveSet::solve_soft)); a small one, or one that does not come to an end that
//! way, gets one variable per limit given up.
//!
//! The price is heavy and scale-free: with the cost `½ xᵀHx`, moving `a x` by one costs at least
//! `½ κ, κ = 1/(a H⁻¹ aᵀ) ≤ n / Σ a_j²/h_jj` (Jacobi scaling, and the largest eigenvalue of a matrix with a unit
//! diagonal is at most n). `w` is a large multiple of that bound, so that the tasks pull a limit beyond what is needed
//! by a small share of what they ask for. Variables with no cost of their own, or next to none (accelerations, where a
//! formulation keeps them), have no such bound; there the largest weight that is on takes its place if it is larger.
//!
//! What is never given up are the limits of the world: the dynamics; each actuator's own limits and slew; a normal
//! force that does not pull; and the rows of constraints that say so
//! ([`Layout::never_relaxed`](crate::plugin::Layout::never_relaxed)), such as friction. No effort beyond what is needed
//! to stay within the actuators' limits, and no contact force at all, satisfies them: with everything else given up the
//! problem is feasible unless a plug-in contradicts that.

mod certificate;
mod problem;

pub(crate) use problem::Form;

use super::{BoundEntry, Problem, Table, Treatment};
use crate::{
    contact::ContactState,
    qp::{Capacity, Qp, RowId, Solution},
};
use wbqp_dynamics::actuator::Actuator;

/// How far beyond a limit a solution is that needs to be, in the limit's unit or as a share of it.
const NEEDED: f64 = 1e-2;

/// What is given up together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Level {
    /// The hard rows and the bounds of an entry.
    Entry(usize),
    /// The limits of a contact's normal force, except that it does not pull.
    Contact(usize),
}

/// A limit that is given up, in the problem that is built.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RelaxedLimit {
    /// Whose.
    pub(crate) id: RowId,
    level: usize,
    /// What is asked still, approximately.
    lower: f64,
    upper: f64,
    /// What was asked.
    asked: [f64; 2],
    /// A row of the tick's problem, or a bound.
    at: At,
}

#[derive(Clone, Copy, Debug)]
enum At {
    Row(usize),
    Variable(usize),
    /// A bound on an eliminated effort: a row that stays, for the actuator's own limits.
    Torque(usize),
}

/// The order of giving up, and storage for the problem.
#[derive(Debug)]
pub(crate) struct Relaxation {
    levels: Vec<Level>,
    /// By level.
    given_up: Vec<bool>,
    /// Those that were needed in the tick before.
    pub(crate) needed: Vec<bool>,
    /// The level of each row and bound, by id.
    level_of: Vec<Option<usize>>,
    first_slack: u32,
    first_row: u32,
    /// Own limits of the actuators in this tick: what they can bear, and how fast they can go there.
    efforts: Vec<[f64; 2]>,
    given: Vec<RelaxedLimit>,
    /// Who set the lower and the upper bound of each variable.
    bound_owner: Vec<[Option<RowId>; 2]>,
    pub(crate) qp: Qp,
    /// By how much each row of it gives per unit of its multiplier.
    pub(crate) compliance: Vec<f64>,
    /// `1/h_jj` of the tick's variables, for the problem built last.
    softness: Vec<f64>,
}

impl Relaxation {
    /// The order of giving up: hard tasks, then constraints, then the limits of contacts' forces; of each, the last
    /// declared goes first.
    pub(crate) fn new(
        problem: &Problem,
        entries: &[BoundEntry],
        table: &Table,
        actuators: &[Actuator],
        capacity: Capacity,
    ) -> Self {
        let mut levels = Vec::new();
        let mut level_of = vec![None; table.rows.len()];
        let limits = Self::limits_of(entries, problem.normal_rows.len());
        for of_tasks in [true, false] {
            for (index, entry) in entries.iter().enumerate().rev() {
                if entry.is_task != of_tasks {
                    continue;
                }
                let rows = given_up(entry);
                if rows.is_empty() && entry.bounds.is_empty() {
                    continue;
                }
                for id in rows.iter().chain(&entry.bounds) {
                    level_of[id.index()] = Some(levels.len());
                }
                levels.push(Level::Entry(index));
            }
        }
        for (contact, id) in problem.normal_rows.iter().enumerate().rev() {
            level_of[id.index()] = Some(levels.len());
            levels.push(Level::Contact(contact));
        }
        let capacity = Self::capacity(entries, problem.normal_rows.len(), capacity);
        Self {
            given_up: vec![false; levels.len()],
            needed: vec![false; levels.len()],
            levels,
            level_of,
            first_slack: table.vars.len() as u32,
            first_row: table.rows.len() as u32,
            efforts: actuators.iter().map(|a| [a.lower, a.upper]).collect(),
            given: Vec::with_capacity(limits),
            bound_owner: vec![[None; 2]; capacity.vars],
            qp: Qp::new(capacity),
            compliance: Vec::with_capacity(capacity.rows),
            softness: Vec::with_capacity(capacity.vars),
        }
    }

    /// The largest problem with all limits given up, of one with so many bounds on normal forces.
    pub(crate) fn capacity(entries: &[BoundEntry], normals: usize, problem: Capacity) -> Capacity {
        let limits = Self::limits_of(entries, normals);
        Capacity {
            vars: problem.vars + limits,
            rows: problem.rows + limits,
        }
    }

    /// How many limits there are to give up.
    fn limits_of(entries: &[BoundEntry], normals: usize) -> usize {
        let of_groups = entries.iter().map(|g| given_up(g).len() + g.bounds.len());
        of_groups.sum::<usize>() + normals
    }

    /// Takes down where each actuator may go in this tick, by its own limits and its slew.
    pub(crate) fn bind_efforts(&mut self, efforts: &[[f64; 2]]) {
        self.efforts.copy_from_slice(efforts);
    }

    /// Nothing is given up.
    pub(crate) fn restore(&mut self) {
        self.given_up.fill(false);
    }

    /// Gives up what was needed in the tick before, if what is given up now is part of that.
    pub(crate) fn give_up_as_before(&mut self) {
        let mut both = self.given_up.iter().zip(&self.needed);
        if both.all(|(now, before)| *before || !now) {
            self.given_up.copy_from_slice(&self.needed);
        }
    }

    /// Takes down what was needed: the levels of which a solution is beyond a limit by more than tasks pull it there.
    pub(crate) fn remember(&mut self, problem: &Problem, base: &Qp, x: &[f64]) {
        let mut needed = std::mem::take(&mut self.needed);
        needed.fill(false);
        for (id, _, limit, by) in self.exceeded(problem, base, x) {
            if by > NEEDED * (1.0 + limit.abs())
                && let Some(level) = self.level_of.get(id.index()).copied().flatten()
            {
                needed[level] = true;
            }
        }
        self.needed = needed;
    }

    /// Everything that can be given up is.
    pub(crate) fn give_up_all(&mut self) {
        self.given_up.fill(true);
    }

    /// Gives up the level of a contradiction that is the first to go, from the multipliers that prove it. False if
    /// nothing in it can be given up that is not. `owners` are those of the bounds of `qp`.
    fn give_up_first(
        &mut self,
        problem: &Problem,
        contacts: &[ContactState],
        qp: &Qp,
        owners: impl Fn(usize) -> [Option<RowId>; 2],
        proof: &Solution,
    ) -> bool {
        // What is given up has no part in a contradiction: a multiplier of it is rounding.
        let level_of = |id: RowId| {
            let level = self.level_of.get(id.index()).copied().flatten();
            level.filter(|level| !self.given_up[*level])
        };
        let mut first = self.levels.len();
        for (i, (y, id)) in proof.y.iter().zip(qp.rows()).enumerate() {
            let is_asked = *y != 0.0
                && problem.torque_row(*id).is_none_or(|(_, actuator)| {
                    let [least, most] = self.efforts[actuator];
                    let constant = problem.constant(i);
                    let (lower, upper) = (qp.row_lower()[i], qp.row_upper()[i]);
                    let crossed = lower > upper;
                    let below = (*y < 0.0 || crossed) && is_above(lower + constant, least);
                    let above = (*y > 0.0 || crossed) && is_above(most, upper + constant);
                    below || above
                });
            if is_asked {
                first = first.min(level_of(*id).unwrap_or(first));
            }
        }
        for (j, &z) in proof.z.iter().enumerate().take(qp.n()) {
            if z == 0.0 {
                continue;
            }
            let (lower, upper) = (qp.lower()[j], qp.upper()[j]);
            let crossed = lower > upper;
            let [least, most] = self.never_relaxed(problem, contacts, j);
            let [below, above] = owners(j);
            let lower = below.filter(|_| (z < 0.0 || crossed) && lower > least);
            let upper = above.filter(|_| (z > 0.0 || crossed) && upper < most);
            for owner in [lower, upper].into_iter().flatten() {
                first = first.min(level_of(owner).unwrap_or(first));
            }
        }
        let given_up = self.given_up.get_mut(first);
        given_up.map(|given_up| *given_up = true).is_some()
    }

    /// Like [`Relaxation::give_up_first`] for the tick's problem.
    pub(crate) fn give_up_in(
        &mut self,
        problem: &Problem,
        contacts: &[ContactState],
        qp: &Qp,
        proof: &Solution,
    ) -> bool {
        let owners = |j: usize| problem.bound_owner[j];
        self.give_up_first(problem, contacts, qp, owners, proof)
    }

    /// Gives up more, from the proof that the problem built last has no solution.
    pub(crate) fn give_up_more(
        &mut self,
        problem: &Problem,
        contacts: &[ContactState],
        proof: &Solution,
    ) -> bool {
        // Both are lent out for the call.
        let qp = std::mem::replace(&mut self.qp, Qp::new(Capacity { vars: 0, rows: 0 }));
        let owners = std::mem::take(&mut self.bound_owner);
        let owner = |j: usize| owners.get(j).copied().unwrap_or_default();
        let more = self.give_up_first(problem, contacts, &qp, owner, proof);
        self.qp = qp;
        self.bound_owner = owners;
        more
    }

    /// Bounds on a variable that always hold.
    fn never_relaxed(
        &self,
        problem: &Problem,
        contacts: &[ContactState],
        position: usize,
    ) -> [f64; 2] {
        let active = &problem.active;
        if let Some(limits) = problem
            .effort_at(position)
            .and_then(|i| self.efforts.get(i))
        {
            return *limits;
        }
        let column = position + problem.partition.substituted;
        let is_slack = active.slacks.iter().flatten().any(|s| *s == column);
        let normals = contacts.iter().zip(&active.forces);
        let is_normal = normals
            .map(|(contact, start)| start.map(|start| start + contact.kind.normal()))
            .any(|normal| normal == Some(column));
        if is_slack || is_normal {
            [0.0, f64::INFINITY]
        } else {
            [f64::NEG_INFINITY, f64::INFINITY]
        }
    }

    /// Every limit given up that a solution of the tick's problem's variables is beyond: the limit, its side as −1 or
    /// 1, what it was, and by how much.
    pub(crate) fn exceeded<'a>(
        &'a self,
        problem: &'a Problem,
        base: &'a Qp,
        x: &'a [f64],
    ) -> impl Iterator<Item = (RowId, f64, f64, f64)> + 'a {
        self.given.iter().flat_map(move |given| {
            let (value, constant) = match given.at {
                At::Row(i) | At::Torque(i) => {
                    let value: f64 = base.row(i).iter().zip(x).map(|(a, x)| a * x).sum();
                    (value, problem.constant(i))
                }
                At::Variable(j) => (x[j], 0.0),
            };
            let [lower, upper] = given.asked.map(|limit| limit + constant);
            let value = value + constant;
            let below = (given.id, -1.0, lower, lower - value);
            let above = (given.id, 1.0, upper, value - upper);
            [below, above]
                .into_iter()
                .filter(|(_, _, limit, by)| by.is_finite() && *by > 1e-9 * (1.0 + limit.abs()))
        })
    }

    /// The most entries that [`Relaxation::exceeded`] may give.
    pub(crate) fn limits(&self) -> usize {
        2 * self.given.capacity()
    }
}

/// The rows of an entry that are given up with it.
fn given_up(entry: &BoundEntry) -> &[RowId] {
    match entry.treatment {
        Treatment::Hard if !entry.layout.never_relaxed => &entry.rows,
        _ => &[],
    }
}

/// Whether one limit is above another by more than what taking a constant from it and adding it again rounds.
fn is_above(limit: f64, other: f64) -> bool {
    limit > other + 1e-12 * (1.0 + limit.abs())
}
