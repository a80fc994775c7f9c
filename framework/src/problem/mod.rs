//! From the rows of the plug-ins to one quadratic program, and back.
//!
//! # Mathematics
//! The problem of a tick (numbers of the paper in brackets):
//! ```text
//! dynamics     M v̇ + h = S u + Σ J_cᵀ f_c + Σ J_fᵀ f_f                              (5a), (8)
//! minimise     Σ w (A_v v̇ + A_u u + A_f f − b)² + w_ε ‖(u, f)‖² + Σ (w s² + λ s)    (10a)
//! subject to   lower − s ≤ C_v v̇ + C_u u + C_f f ≤ upper + s,   s ≥ 0               (10c), (10e)
//!              bounds on single efforts and force components                        (10b)
//!              the dynamics, where nothing is substituted from them                 (10d)
//! ```
//! The rows and bounds of (10b), (10c), (10e) and the tasks of (11) are plug-ins': `tasks/`, linked by name in
//! docs/paper-to-code.md.
//!
//! Four ways of counting: by *velocity*, as in `v̇`; by *column* of y, the natural variables; by variable of the
//! problem, x; and by *position* among the columns that a row has. [`partition`] says which accelerations and efforts
//! are variables. In the order in which functions are called below:
//!
//! 1. [`contact_elimination`]: accelerations that contacts which do not move leave no choice of, `v̇_D = G v̇_S + g`.
//! 2. [`active_variables`]: which variables there are; the *natural* ones `y = (v̇, kept u, f, slacks)`, those of the
//!    problem `x`, the same without the accelerations that are substituted ([`partition`]).
//! 3. [`reduced_dynamics`]: with the forcing `F = [S J_cᵀ]` and the known forces `k = Σ J_fᵀ f_f − h` the dynamics
//!    read `M v̇ = F (u, f) + k`; from them `v̇_P = B x + c` and `τ = T y + t` for what is no variable.
//! 4. [`rows`]: what each entry wrote, over y.
//! 5. [`hessian`]: rows that are a cost, `H = 2 Σ w aᵀa` and `g = −2 Σ w b aᵀ`, summed up over y where they are sparse,
//!    and taken to x once, for all rows together.
//! 6. [`constraints`]: the equations of motion, rows that must hold, bounds.
//!
//! A solution goes the way back ([`solution`]). Limits that contradict one another: [`relaxation`].
#![allow(non_snake_case)]

mod active_variables;
mod asked;
mod constraints;
mod contact_elimination;
mod entry;
mod hessian;
mod kernels;
mod names;
mod partition;
mod reduced_dynamics;
mod relaxation;
mod rows;
mod solution;
mod sparsity;
mod table;
mod tree_cholesky;
mod weight;

pub(crate) use active_variables::ActiveVariables;
use active_variables::FirstIds;
use asked::Asked;
use constraints::TorqueRow;
pub(crate) use contact_elimination::ContactElimination;
pub(crate) use entry::{BoundEntry, EntrySpec, Treatment};
use hessian::NaturalCost;
pub(crate) use kernels::dot;
pub(crate) use names::{ProblemRows, VariableNames};
use partition::EffortPlace;
pub(crate) use partition::Partition;
use reduced_dynamics::ReducedDynamics;
pub(crate) use relaxation::Relaxation;
use rows::{Context, NaturalRows};
pub(crate) use solution::Solved;
use sparsity::SparsityPattern;
pub(crate) use table::Table;
pub use table::{RowInfo, VarInfo};

use nalgebra::Vector6;

use crate::{
    contact::ContactState,
    fault::Fault,
    plugin::layout::BoundTarget,
    qp::{Capacity, Qp, RowId},
};
use wbqp_dynamics::{Actuation, Data, FrameKinematics};

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
    elimination: ContactElimination,
    reduced: ReducedDynamics,
    /// One per entry.
    rows: Vec<NaturalRows>,
    /// Whether they know where the variables of this tick are.
    is_arranged: bool,
    /// Whether each entry's rows are a cost, this tick.
    is_cost: Vec<bool>,
    cost: NaturalCost,
    solved: Solved,
    asked: Asked,
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
        if self.elimination.update(entries, terms.contacts) {
            self.arrange();
        }
        if self.lay_out(terms, entries) {
            self.put_together(terms, entries, qp)
        } else if self.elimination.any() {
            self.build_with_all_rows(terms, entries, qp)
        } else {
            Err(Fault::MassMatrix)
        }
    }

    /// Builds the problem of this tick without substituting anything from contacts: all limits have a row or a bound.
    pub(crate) fn build_with_all_rows(
        &mut self,
        terms: &DynamicsTerms<'_>,
        entries: &[BoundEntry],
        qp: &mut Qp,
    ) -> Result<(), Fault> {
        if self.elimination.keep_all() {
            self.arrange();
        }
        if self.lay_out(terms, entries) {
            self.put_together(terms, entries, qp)
        } else {
            Err(Fault::MassMatrix)
        }
    }

    /// Other accelerations are substituted than before.
    fn arrange(&mut self) {
        self.partition.arrange(&self.elimination);
        self.is_arranged = false;
    }

    /// Lays out the variables, and finds what the dynamics say of those that are none; false if that cannot be
    /// inverted.
    fn lay_out(&mut self, terms: &DynamicsTerms<'_>, entries: &[BoundEntry]) -> bool {
        let live_slack = |e: usize| entries[e].live.then_some(entries[e].slack).flatten();
        let changed = self.active.refresh(
            &self.partition,
            &self.first_ids,
            |c| terms.contacts[c].live,
            live_slack,
        );
        self.is_arranged &= !changed;
        self.reduced
            .update(&self.partition, &self.elimination, &self.active, terms)
    }

    fn put_together(
        &mut self,
        terms: &DynamicsTerms<'_>,
        entries: &[BoundEntry],
        qp: &mut Qp,
    ) -> Result<(), Fault> {
        if qp.reset(self.active.vars.iter().copied()).is_err() {
            debug_assert!(false, "the storage is made for all variables");
            return Err(Fault::Solver);
        }
        self.constants.clear();
        self.torque_rows.clear();
        if !self.is_arranged {
            self.arrange_rows(terms, entries);
        }
        if !self.push_dynamics(terms, qp) {
            return Err(Fault::Solver);
        }
        self.cost.reset(self.active.n);
        for (index, entry) in entries.iter().enumerate() {
            self.is_cost[index] = false;
            if !entry.live {
                continue;
            }
            // Eliminated contacts' rows hold by substitution.
            if !self.elimination.hold(index) {
                self.expand(index, entry, terms);
                if entry.treatment_now() == Treatment::Cost {
                    self.is_cost[index] = true;
                    if entry.layout.acts_on_accelerations() && entry.layout.acts_on_forces() {
                        self.cost.couple();
                    }
                    self.rows[index].add_cost(entry, &mut self.cost);
                } else if !self.push_rows(index, entry, terms, qp) {
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
        self.cost
            .add_all_determined(&self.partition, &self.elimination);
        self.cost
            .add_torques(&self.partition, &self.reduced, &self.active);
        self.cost.write(&self.reduced, &self.active, qp);
        self.add_bounds(terms, entries, qp)
    }

    /// Finds where all entries' rows are.
    fn arrange_rows(&mut self, terms: &DynamicsTerms<'_>, entries: &[BoundEntry]) {
        let context = Context {
            partition: &self.partition,
            elimination: &self.elimination,
            reduced: &self.reduced,
            active: &self.active,
            terms: *terms,
        };
        for (rows, entry) in self.rows.iter_mut().zip(entries) {
            rows.arrange(&entry.layout, &context);
        }
        self.is_arranged = true;
    }

    /// Takes what an entry wrote.
    fn expand(&mut self, index: usize, entry: &BoundEntry, terms: &DynamicsTerms<'_>) {
        let context = Context {
            partition: &self.partition,
            elimination: &self.elimination,
            reduced: &self.reduced,
            active: &self.active,
            terms: *terms,
        };
        self.rows[index].expand(entry, &context);
    }

    /// Whether what an entry wrote for the cost is finite. (Where all of it is, and the cost is not, products overflow:
    /// the solver refuses the problem.)
    fn is_cost_finite(&self, index: usize, entry: &BoundEntry) -> bool {
        let is_finite = |k: usize| entry.store.lower[k].is_finite() && entry.store.is_finite(k);
        !self.is_cost[index] || (0..entry.layout.len()).all(is_finite)
    }

    /// `w_ε ‖(u, f)‖²` with `w_ε` relative to the largest weight that is on.
    fn regularise(&mut self, entries: &[BoundEntry]) {
        let on = entries.iter().zip(&self.is_cost).filter(|(_, on)| **on);
        let largest = on.map(|(entry, _)| entry.largest_weight());
        let largest = largest.fold(0.0, f64::max);
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
    pub(crate) fn recover(&mut self, entries: &[BoundEntry], x: &[f64]) -> &Solved {
        let (partition, active) = (&self.partition, &self.active);
        self.solved
            .take(partition, &self.elimination, &self.reduced, active, x);
        self.solved.assess(
            entries,
            &self.rows,
            &self.is_cost,
            active,
            partition.first_force(),
            self.regularisation_weight,
        );
        &self.solved
    }

    /// The solution taken last.
    pub(crate) fn solved(&self) -> &Solved {
        &self.solved
    }

    /// Its force components of a contact that is live.
    pub(crate) fn force(&self, contact: usize) -> Option<&[f64]> {
        let start = self.active.forces[contact]?;
        Some(&self.solved.y[start..start + self.partition.nf[contact]])
    }

    /// Writes what tasks ask of single components of `v̇`, see [`Asked::collect`].
    pub(crate) fn collect_asked(&mut self, tasks: &[BoundEntry], out: &mut [f64]) {
        self.asked.collect(tasks, out);
    }

    /// Identity of the bound on a contact's normal force.
    pub(crate) fn normal_row(&self, contact: usize) -> Option<RowId> {
        self.normal_rows.get(contact).copied()
    }

    /// Weight of `‖(u, f)‖²` relative to the largest one that is on.
    pub(crate) fn relative_regularisation(&self) -> f64 {
        self.regularisation
    }

    /// Whether contacts' rows hold by substitution in the problem built last.
    pub(crate) fn has_determined(&self) -> bool {
        self.elimination.any()
    }

    /// Whether a row is one of the equations of motion.
    pub(crate) fn is_dynamics(&self, id: RowId) -> bool {
        self.dynamics_rows.contains(&id)
    }

    /// What the limits of a row of the problem leave out: the part of the row's value that does not depend on x.
    pub(crate) fn constant(&self, row: usize) -> f64 {
        self.constants.get(row).copied().unwrap_or(0.0)
    }
}

/// Before the first tick.
impl Problem {
    /// Gives the physical variables, the dynamics rows and the slacks their ids. `actuation` has the efforts that the
    /// partition keeps.
    pub(crate) fn new(
        mut partition: Partition,
        actuation: Actuation,
        regularisation: f64,
        names: &VariableNames<'_>,
        own_rows: ProblemRows,
        entries: &mut [BoundEntry],
        table: &mut Table,
    ) -> Self {
        let rows_of_motion = own_rows.dynamics.len();
        let first_ids = names.register(entries, table);
        let capacity = table.vars.len() - partition.torques.len();
        let rows: usize = entries.iter().map(|e| e.layout.len()).sum();
        let bounds: usize = entries.iter().map(|e| e.layout.bounds.len()).sum();
        let elimination = ContactElimination::new(&partition, entries);
        partition.reserve(elimination.sizes().len());
        partition.arrange(&elimination);
        let natural = |entry: &BoundEntry| NaturalRows::new(&entry.layout, &partition, capacity);
        Self {
            regularisation,
            dynamics_rows: own_rows.dynamics,
            normal_rows: own_rows.normals,
            active: ActiveVariables::new(partition.nf.len(), entries.len(), capacity),
            reduced: ReducedDynamics::new(&partition, actuation, partition.nf.iter().sum()),
            rows: entries.iter().map(natural).collect(),
            is_arranged: false,
            is_cost: vec![false; entries.len()],
            cost: NaturalCost::new(&partition, &elimination, capacity),
            solved: Solved::new(&partition, entries.len(), rows, capacity),
            asked: Asked::new(partition.nv),
            row: vec![0.0; capacity],
            constants: Vec::with_capacity(2 * rows + bounds + rows_of_motion),
            torque_rows: Vec::with_capacity(bounds),
            bound_owner: vec![[None; 2]; capacity],
            largest_weight: 1.0,
            regularisation_weight: 0.0,
            first_ids,
            elimination,
            partition,
        }
    }

    /// Chooses what contacts may determine. The robot is at home.
    pub(crate) fn choose_determined(&mut self, contacts: &[ContactState]) {
        self.elimination.choose(&self.partition, contacts);
        self.arrange();
    }

    /// The largest problem that can come up.
    pub(crate) fn capacity(&self, entries: &[BoundEntry]) -> Capacity {
        Self::capacity_for(&self.partition, entries, self.dynamics_rows.len())
    }

    /// The same before there is a problem.
    pub(crate) fn capacity_for(
        partition: &Partition,
        entries: &[BoundEntry],
        dynamics_rows: usize,
    ) -> Capacity {
        let is_row = |target: &BoundTarget| match *target {
            BoundTarget::Effort(i) => {
                matches!(partition.efforts[i], EffortPlace::Eliminated(_))
            }
            BoundTarget::Force(..) => false,
        };
        let bounds = |e: &BoundEntry| e.layout.bounds.iter().filter(|(_, t)| is_row(t)).count();
        let rows: usize = entries.iter().map(|e| e.rows.len() + bounds(e)).sum();
        Capacity {
            vars: Self::natural_variables(partition, entries) - partition.substituted,
            rows: rows + dynamics_rows,
        }
    }

    /// Accelerations, kept efforts, forces and slacks.
    pub(crate) fn natural_variables(partition: &Partition, entries: &[BoundEntry]) -> usize {
        let slacks = entries.iter().filter(|e| e.treatment == Treatment::Slack);
        let forces: usize = partition.nf.iter().sum();
        partition.nv + partition.kept.len() + forces + slacks.count()
    }

    /// Numbers that the rows over the natural variables take.
    pub(crate) fn row_numbers(partition: &Partition, entries: &[BoundEntry]) -> usize {
        let natural = Self::natural_variables(partition, entries);
        let of = |entry: &BoundEntry| NaturalRows::numbers(&entry.layout, partition, natural);
        entries.iter().map(of).fold(0, usize::saturating_add)
    }
}
