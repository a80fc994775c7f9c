//! Puts the problem of a tick together: rows, cost, bounds.

use super::{
    ActiveVariables, Asked, BoundEntry, ContactElimination, NaturalCost, Partition, ProblemRows,
    Recovered, ReducedDynamics, Table, Treatment, VariableNames, active_variables::FirstIds,
    bounds::TorqueRow, expand::Context, partition::EffortPlace,
};
use crate::{
    contact::ContactState,
    dynamics::{Actuation, Data, FrameKinematics},
    fault::Fault,
    plugin::layout::{BoundTarget, Relation},
    qp::{Capacity, Qp, RowId},
};

/// What the dynamics contribute this tick.
#[derive(Clone, Copy)]
pub(crate) struct DynamicsTerms<'a> {
    pub(crate) data: &'a Data,
    pub(crate) frames: &'a [FrameKinematics],
    pub(crate) contacts: &'a [ContactState],
}

/// Workspace of the problem.
#[derive(Clone, Debug)]
pub(crate) struct Problem {
    pub(super) regularisation: f64,
    pub(super) partition: Partition,
    pub(super) first_ids: FirstIds,
    pub(super) dynamics_rows: Vec<RowId>,
    /// The bound on each contact's normal force, which every contact brings.
    pub(super) normal_rows: Vec<RowId>,
    pub(crate) live: ActiveVariables,
    pub(super) motions: ContactElimination,
    pub(super) reduced: ReducedDynamics,
    pub(super) quadratic: NaturalCost,
    pub(super) recovered: Recovered,
    asked: Asked,
    /// A row over y.
    pub(super) row: Vec<f64>,
    /// The rows over y of a entry that is a cost.
    pub(super) block: Vec<f64>,
    /// Their constant parts.
    pub(super) block_constants: Vec<f64>,
    /// Columns in which they are not all zero.
    pub(super) columns: Vec<usize>,
    /// What was taken from the limits of each row of the problem: the part of its value that does not depend on x.
    pub(super) constants: Vec<f64>,
    /// The rows that are bounds on eliminated efforts.
    pub(super) torque_rows: Vec<TorqueRow>,
    /// Who set the lower and the upper bound of each variable of the problem.
    pub(crate) bound_owner: Vec<[Option<RowId>; 2]>,
    /// Largest weight that is on this tick, 1 without any.
    pub(super) largest_weight: f64,
    /// Weight of `‖(u, f)‖²` this tick.
    pub(crate) regularisation_weight: f64,
}

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
        let rows: usize = entries.iter().map(|g| g.layout.len()).sum();
        let bounds: usize = entries.iter().map(|g| g.layout.bounds.len()).sum();
        let longest = entries.iter().map(|g| g.layout.len()).max().unwrap_or(0);
        let motions = ContactElimination::new(&partition, entries);
        partition.reserve(motions.sizes().len());
        partition.arrange(&motions);
        Self {
            regularisation,
            dynamics_rows: own_rows.dynamics,
            normal_rows: own_rows.normals,
            live: ActiveVariables::new(partition.nf.len(), entries.len(), capacity),
            reduced: ReducedDynamics::new(&partition, actuation, partition.nf.iter().sum()),
            quadratic: NaturalCost::new(&partition, &motions, capacity),
            recovered: Recovered::new(&partition, rows, capacity),
            asked: Asked::new(partition.nv),
            row: vec![0.0; capacity],
            block: vec![0.0; longest * capacity],
            block_constants: vec![0.0; longest],
            constants: Vec::with_capacity(2 * rows + bounds + rows_of_motion),
            torque_rows: Vec::with_capacity(bounds),
            columns: Vec::with_capacity(capacity),
            bound_owner: vec![[None; 2]; capacity],
            largest_weight: 1.0,
            regularisation_weight: 0.0,
            first_ids,
            motions,
            partition,
        }
    }

    /// Chooses what contacts may determine. The robot is at home.
    pub(crate) fn choose_determined(&mut self, contacts: &[ContactState]) {
        self.motions.choose(&self.partition, contacts);
        self.partition.arrange(&self.motions);
    }

    /// Whether contacts' rows hold by substitution in the problem built last.
    pub(crate) fn has_determined(&self) -> bool {
        self.motions.any()
    }

    /// Whether a row is one of the equations of motion.
    pub(crate) fn is_dynamics(&self, id: RowId) -> bool {
        self.dynamics_rows.contains(&id)
    }

    /// What the limits of a row of the problem leave out: the part of the row's value that does not depend on x.
    pub(crate) fn constant(&self, row: usize) -> f64 {
        self.constants.get(row).copied().unwrap_or(0.0)
    }

    /// The largest problem that can come up.
    pub(crate) fn capacity(&self, entries: &[BoundEntry]) -> Capacity {
        Self::capacity_for(&self.partition, entries, self.dynamics_rows.len())
    }

    /// The same before there is an problem.
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
        let bounds = |g: &BoundEntry| g.layout.bounds.iter().filter(|(_, t)| is_row(t)).count();
        let rows: usize = entries.iter().map(|g| g.row_capacity() + bounds(g)).sum();
        Capacity {
            vars: Self::natural_variables(partition, entries) - partition.substituted,
            rows: rows + dynamics_rows,
        }
    }

    /// Accelerations, kept efforts, forces and slacks.
    pub(crate) fn natural_variables(partition: &Partition, entries: &[BoundEntry]) -> usize {
        let slacks = entries.iter().filter(|g| g.treatment == Treatment::Slack);
        let forces: usize = partition.nf.iter().sum();
        partition.nv + partition.kept.len() + forces + slacks.count()
    }

    /// Builds the problem of this tick.
    pub(crate) fn assemble(
        &mut self,
        terms: &DynamicsTerms<'_>,
        entries: &mut [BoundEntry],
        qp: &mut Qp,
    ) -> Result<(), Fault> {
        if self.motions.update(entries, terms.contacts) {
            self.partition.arrange(&self.motions);
        }
        if self.relate(terms, entries) {
            self.put_together(terms, entries, qp)
        } else {
            self.assemble_with_all_rows(terms, entries, qp)
        }
    }

    /// Builds the problem of this tick without substituting anything from contacts: all limits have a row or a bound.
    pub(crate) fn assemble_with_all_rows(
        &mut self,
        terms: &DynamicsTerms<'_>,
        entries: &mut [BoundEntry],
        qp: &mut Qp,
    ) -> Result<(), Fault> {
        if self.motions.keep_all() {
            self.partition.arrange(&self.motions);
        }
        if self.relate(terms, entries) {
            self.put_together(terms, entries, qp)
        } else {
            Err(Fault::MassMatrix)
        }
    }

    /// Lays out the variables and what is substituted; false if that cannot be.
    fn relate(&mut self, terms: &DynamicsTerms<'_>, entries: &[BoundEntry]) -> bool {
        let live_slack = |g: usize| entries[g].live.then_some(entries[g].slack).flatten();
        self.live.refresh(
            &self.partition,
            &self.first_ids,
            |c| terms.contacts[c].live,
            live_slack,
        );
        self.reduced
            .update(&self.partition, &self.motions, &self.live, terms)
    }

    fn put_together(
        &mut self,
        terms: &DynamicsTerms<'_>,
        entries: &mut [BoundEntry],
        qp: &mut Qp,
    ) -> Result<(), Fault> {
        let made = qp.reset(self.live.vars.iter().copied());
        debug_assert!(made.is_ok(), "{made:?}");
        self.constants.clear();
        self.torque_rows.clear();
        self.push_dynamics(terms, qp);
        self.quadratic.reset(self.live.n);
        let mut cost_rows = 0;
        for (index, entry) in entries.iter_mut().enumerate() {
            entry.cost_start = None;
            if !entry.live {
                continue;
            }
            let treatment = entry.treatment_now(is_equality(entry));
            if self.motions.hold(index) {
                // By substitution.
            } else if treatment == Treatment::Cost {
                entry.cost_start = Some(cost_rows);
                cost_rows += entry.layout.len();
                self.add_cost(entry, terms);
            } else if !self.push_rows(index, entry, treatment, terms, qp) {
                return Err(Fault::Rows(index));
            }
            if !self.push_torque_bounds(entry, qp) {
                return Err(Fault::Rows(index));
            }
        }
        if !self.quadratic.is_finite()
            && let Some(index) = entries.iter().position(|g| !self.is_cost_finite(g))
        {
            return Err(Fault::Rows(index));
        }
        self.regularise(entries);
        self.quadratic
            .add_all_determined(&self.partition, &self.motions);
        self.quadratic
            .add_torques(&self.partition, &self.reduced, &self.live);
        self.quadratic.write(&self.reduced, &self.live, qp);
        self.add_bounds(terms, entries, qp)
    }

    pub(super) fn context<'a>(&'a self, terms: &DynamicsTerms<'a>) -> Context<'a> {
        Context {
            partition: &self.partition,
            motions: &self.motions,
            reduced: &self.reduced,
            live: &self.live,
            terms: *terms,
        }
    }

    /// Takes a solution of the problem.
    pub(crate) fn recover(&mut self, entries: &[BoundEntry], terms: &DynamicsTerms<'_>, x: &[f64]) {
        let Self {
            recovered,
            partition,
            motions,
            reduced,
            live,
            ..
        } = self;
        recovered.take(partition, motions, reduced, live, x);
        recovered.assess(entries, live, terms, partition, self.regularisation_weight);
    }

    /// `v̇` of the solution taken last.
    pub(crate) fn vdot(&self) -> &[f64] {
        &self.recovered.vdot
    }

    /// Writes what tasks ask of single components of `v̇`, see [`Asked::collect`].
    pub(crate) fn collect_asked(&mut self, tasks: &[BoundEntry], out: &mut [f64]) {
        self.asked.collect(tasks, out);
    }

    /// Its efforts.
    pub(crate) fn effort(&self) -> &[f64] {
        &self.recovered.effort
    }

    /// Its force components of a contact that is live.
    pub(crate) fn force(&self, contact: usize) -> Option<&[f64]> {
        self.recovered.force(&self.live, &self.partition, contact)
    }

    /// Its cost: `Σ w r²` over the cost rows, plus slacks and regularisation.
    pub(crate) fn objective(&self) -> f64 {
        self.recovered.objective
    }

    /// Its residuals `a x − b` and weights of a entry's rows, if the entry is a cost this tick.
    pub(crate) fn residuals(&self, entry: &BoundEntry) -> Option<&[[f64; 2]]> {
        let start = entry.cost_start?;
        self.recovered
            .residuals
            .get(start..start + entry.layout.len())
    }
}

/// Whether the rows have one right-hand side.
pub(crate) fn is_equality(entry: &BoundEntry) -> bool {
    entry.is_task || entry.layout.relation == Relation::Equality
}
