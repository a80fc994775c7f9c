//! From the rows of the plug-ins to one quadratic program, and back.
//!
//! # Mathematics
//! The problem of a tick (numbers of the paper in brackets):
//! ```text
//! dynamics     M v̇ + h = S u + Σ J_cᵀ f_c + Σ J_fᵀ f_f                              (5a)
//! minimise     Σ w (A_v v̇ + A_u u + A_f f − b)² + w_ε ‖(u, f)‖² + Σ (w s² + λ s)    (10a)
//! subject to   lower − s ≤ C_v v̇ + C_u u + C_f f ≤ upper + s,   s ≥ 0               (10c)
//!              A_v v̇ + A_u u + A_f f = b                                            (10e)
//!              bounds on single efforts and force components                        (10b)
//!              the dynamics, where nothing is substituted from them                 (10d)
//! ```
//! An inequality that is hard has no slack. An equality (the rows of a task, and those of a constraint that says so,
//! such as (10e)) never has one: if it is hard it is a row that must hold, or holds by substitution where a contact
//! determines accelerations; if it is soft, and while a hard one ramps, it is part of the cost. What must hold and
//! contradicts the rest is given up in a problem of its own, [`relaxation`].
//!
//! The rows and bounds of (10b), (10c), (10e) and the tasks of (11) are plug-ins': `tasks/`, linked by name in
//! docs/paper-to-code.md; but for the limits of each contact's normal force, which are the framework's own bounds.
//!
//! Four ways of counting: by *velocity*, as in `v̇`; by *column* of y, the natural variables; by variable of the
//! problem, x; and by *position* among the columns that a row has. [`variables`] says which accelerations and efforts
//! are variables. In the order in which functions are called below:
//!
//! 1. [`contact_elimination`]: accelerations that contacts which do not move leave no choice of, `v̇_D = G v̇_S + g`.
//! 2. [`variables`]: which variables there are; the *natural* ones `y = (v̇, kept u, f, slacks)`, those of the
//!    problem `x`, the same without the accelerations that are substituted.
//! 3. [`reduced_dynamics`]: with the forcing `F = [S J_cᵀ]` and the known forces `k = Σ J_fᵀ f_f − h` the dynamics
//!    read `M v̇ = F (u, f) + k`; from them `v̇_P = B x + c`, (8), and `τ = T y + t` for what is no variable.
//! 4. [`rows`]: what each entry wrote, over y.
//! 5. [`hessian`]: rows that are a cost, `H = 2 Σ w aᵀa` and `g = −2 Σ w b aᵀ`, summed up over y where they are sparse,
//!    and taken to x once, for all rows together.
//! 6. [`constraints`]: the equations of motion, rows that must hold, bounds.
//!
//! A solution goes the way back ([`solution`]). Limits that contradict one another: [`relaxation`].
#![allow(non_snake_case)]

mod bind;
mod constraints;
mod contact_elimination;
mod eliminable;
mod entry;
mod hessian;
mod linear_algebra;
mod names;
mod partition;
mod reduced_dynamics;
mod relaxation;
mod rows;
mod solution;
mod table;
mod tree;
mod variables;

use eliminable::ContactElimination;
pub(crate) use entry::{BoundEntry, EntrySpec, Treatment};
use hessian::NaturalCost;
pub(crate) use linear_algebra::dot;
pub(crate) use names::{ProblemRows, VariableNames};
pub(crate) use partition::Partition;
use partition::{ActiveVariables, FirstIds};
use reduced_dynamics::ReducedDynamics;
pub(crate) use relaxation::{Form, Relaxation};
use rows::{Context, NaturalRows};
use solution::Asked;
pub(crate) use solution::Solved;
pub use table::Named;
pub(crate) use table::Table;
use table::TorqueRow;

use nalgebra::Vector6;

use crate::{
    contact::ContactState,
    fault::Fault,
    plugin::layout::Relation,
    qp::{Qp, RowId},
};
use wbqp_dynamics::{Data, FrameKinematics};

/// What the dynamics contribute this tick.
#[derive(Clone, Copy)]
pub(crate) struct DynamicsTerms<'a> {
    pub(crate) data: &'a Data,
    pub(crate) frames: &'a [FrameKinematics],
    pub(crate) contacts: &'a [ContactState],
    /// The unknown wrench on a floating base, `[force; moment]` about its origin, world axes, N and N·m.
    pub(crate) disturbance: Vector6<f64>,
}

/// What the problem is built in: storage made once, for everything switched on.
#[derive(Clone, Debug)]
pub(crate) struct Problem {
    /// Weight of `‖(u, f)‖²` relative to the largest one that is on.
    regularisation: f64,
    partition: Partition,
    first_ids: FirstIds,
    dynamics_rows: Vec<RowId>,
    /// The bound on each contact's normal force, which every contact brings.
    normal_rows: Vec<RowId>,
    pub(crate) active: ActiveVariables,
    reduced: ReducedDynamics,
    /// One per entry.
    rows: Vec<NaturalRows>,
    /// Whether they know where the variables of this tick are.
    is_arranged: bool,
    cost: NaturalCost,
    /// The solution taken last.
    pub(crate) solved: Solved,
    pub(crate) asked: Asked,
    /// A row on its way from y to x.
    row: Vec<f64>,
    /// What was taken from the limits of each row of the problem: the part of its value that does not depend on x.
    constants: Vec<f64>,
    /// The rows that are bounds on eliminated efforts.
    torque_rows: Vec<TorqueRow>,
    /// Who set the lower and the upper bound of each variable of the problem.
    pub(crate) bound_owner: Vec<[Option<RowId>; 2]>,
    /// Largest weight that is on this tick, 1 without any.
    largest_weight: f64,
    /// Weight of `‖(u, f)‖²` this tick.
    pub(crate) regularisation_weight: f64,
}

impl Problem {
    /// Builds the problem of this tick.
    pub(crate) fn build(
        &mut self,
        terms: &DynamicsTerms<'_>,
        entries: &[BoundEntry],
        qp: &mut Qp,
    ) -> Result<(), Fault> {
        if self.partition.elimination.update(entries, terms.contacts) {
            self.arrange();
        }
        self.put_together(terms, entries, qp)
    }

    /// Other accelerations are substituted than before.
    fn arrange(&mut self) {
        self.partition.arrange();
        self.is_arranged = false;
    }

    /// Lays out the variables, and finds what the dynamics say of those that are none; false if that cannot be
    /// inverted.
    fn lay_out(&mut self, terms: &DynamicsTerms<'_>, entries: &[BoundEntry]) -> bool {
        let (partition, contacts) = (&self.partition, terms.contacts);
        let active = &mut self.active;
        self.is_arranged &= !active.refresh(partition, &self.first_ids, contacts, entries);
        self.reduced.update(&self.partition, &self.active, terms)
    }

    fn put_together(
        &mut self,
        terms: &DynamicsTerms<'_>,
        entries: &[BoundEntry],
        qp: &mut Qp,
    ) -> Result<(), Fault> {
        if !self.lay_out(terms, entries) {
            if self.has_determined() {
                return self.build_with_all_rows(terms, entries, qp);
            }
            return Err(Fault::MassMatrix);
        }
        if qp.reset(self.active.vars.iter().copied()).is_err() {
            debug_assert!(false, "the storage is made for all variables");
            return Err(Fault::Solver);
        }
        self.constants.clear();
        self.torque_rows.clear();
        if !self.is_arranged {
            for (rows, entry) in self.rows.iter_mut().zip(entries) {
                rows.arrange(&entry.layout, &self.partition);
            }
            self.is_arranged = true;
        }
        if !self.push_dynamics(terms, qp) {
            return Err(Fault::Solver);
        }
        self.cost.reset(self.active.n);
        for (index, entry) in entries.iter().enumerate() {
            // Eliminated contacts' rows hold by substitution.
            let is_written = entry.live && !self.partition.elimination.hold(index);
            self.rows[index].is_cost = false;
            self.rows[index].is_expanded = is_written;
            if !entry.live {
                continue;
            }
            if is_written {
                let context = Context {
                    partition: &self.partition,
                    reduced: &self.reduced,
                    active: &self.active,
                };
                self.rows[index].expand(entry, &context, terms);
                if entry.treatment_now() == Treatment::Cost {
                    self.rows[index].is_cost = true;
                    self.rows[index].add_cost(entry, &context, &mut self.cost);
                } else if !self.push_rows(index, entry, qp) {
                    return Err(Fault::Rows(index));
                }
            }
            if !self.push_torque_bounds(entry, qp) {
                return Err(Fault::Rows(index));
            }
        }
        if !self.cost.is_finite()
            && let Some(index) = (0..entries.len()).find(|&i| !self.is_cost_finite(i, &entries[i]))
        {
            return Err(Fault::Rows(index));
        }
        self.regularise(entries);
        self.cost.add_all_determined(&self.partition);
        self.cost
            .add_torques(&self.partition, &self.reduced, &self.active);
        self.cost.write(&self.reduced, qp);
        self.add_bounds(terms, entries, qp)
    }

    /// Whether what an entry wrote for the cost is finite. (Where all of it is, and the cost is not, products overflow:
    /// the solver refuses the problem.)
    fn is_cost_finite(&self, index: usize, entry: &BoundEntry) -> bool {
        let is_finite = |k: usize| entry.store.lower[k].is_finite() && entry.store.is_finite(k);
        !self.rows[index].is_cost || (0..entry.layout.rows.len()).all(is_finite)
    }

    /// `w_ε ‖(u, f)‖²` with `w_ε` relative to the largest weight that is on.
    fn regularise(&mut self, entries: &[BoundEntry]) {
        let on = entries
            .iter()
            .zip(&self.rows)
            .filter(|(_, rows)| rows.is_cost);
        let largest = on.fold(0.0, |most, (entry, _)| entry.largest_weight().max(most));
        self.largest_weight = if largest > 0.0 { largest } else { 1.0 };
        let weight = self.regularisation * self.largest_weight;
        self.regularisation_weight = weight;
        for column in self.partition.accelerations..self.active.n_physical {
            self.cost.add_unit(column, weight, 0.0);
        }
        for torque in 0..self.partition.torques.len() {
            self.cost.add_torque(torque, weight, 0.0);
        }
    }

    /// Takes a solution of the problem.
    pub(crate) fn recover(&mut self, entries: &[BoundEntry], x: &[f64]) {
        let (partition, active) = (&self.partition, &self.active);
        let (first_force, weight) = (partition.first_force(), self.regularisation_weight);
        self.solved.take(partition, &self.reduced, active, x);
        self.solved
            .assess(entries, &self.rows, active, first_force, weight);
    }

    /// The values of the problem's rows, less their constants, at the solution taken last: of an eliminated effort it
    /// is known.
    pub(crate) fn row_values(&self, qp: &Qp, x: &[f64]) -> impl Iterator<Item = f64> {
        let mut torques = self.torque_rows.iter().peekable();
        (0..qp.m()).map(move |i| match torques.next_if(|torque| torque.row == i) {
            Some(torque) => self.solved.effort[torque.actuator] - self.constants[i],
            None => dot(qp.row(i), x),
        })
    }

    /// The force of a contact in the solution taken last; nothing while it is off.
    pub(crate) fn force(&self, contact: usize) -> &[f64] {
        &self.solved.y[self.active.force(&self.partition, contact)]
    }
}

impl BoundEntry {
    /// Takes over what was asked for since the last tick; whether the entry is switched on in this one.
    pub(crate) fn settle(&mut self, now: f64) -> bool {
        self.weight.update(now);
        self.switch.settle(now) == Some(true)
    }

    /// Whether the rows have one right-hand side.
    pub(crate) fn is_equality(&self) -> bool {
        self.is_task || self.layout.relation == Relation::Equality
    }

    /// How the rows are treated this tick: hard equalities ramp as a cost and become hard at the end.
    pub(crate) fn treatment_now(&self) -> Treatment {
        if self.treatment == Treatment::Hard && self.is_equality() && self.alpha < 1.0 {
            Treatment::Cost
        } else {
            self.treatment
        }
    }

    /// Largest weight, without the ramp.
    pub(crate) fn largest_weight(&self) -> f64 {
        self.weight.now().iter().copied().fold(0.0, f64::max)
    }
}
