//! Puts the problem of a tick together: rows, cost, bounds.

use super::{
    Actuation, Asked, Group, Live, Motions, Partition, ProblemRows, Quadratic, Recovered,
    Relations, Table, Treatment, VariableNames, bounds::TorqueRow, expand::Context, live::FirstIds,
    partition::EffortPlace,
};
use crate::{
    contact::ContactState,
    dynamics::{Data, FrameKinematics},
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

/// Workspace of the assembly.
#[derive(Clone, Debug)]
pub(crate) struct Assembly {
    pub(super) regularisation: f64,
    pub(super) partition: Partition,
    pub(super) first_ids: FirstIds,
    pub(super) dynamics_rows: Vec<RowId>,
    /// The bound on each contact's normal force, which every contact brings.
    pub(super) normal_rows: Vec<RowId>,
    pub(crate) live: Live,
    pub(super) motions: Motions,
    pub(super) relations: Relations,
    pub(super) quadratic: Quadratic,
    pub(super) recovered: Recovered,
    asked: Asked,
    /// A row over y.
    pub(super) row: Vec<f64>,
    /// The rows over y of a group that is a cost.
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

impl Assembly {
    /// Gives the physical variables, the dynamics rows and the slacks their ids. `actuation` has the efforts that the
    /// partition keeps.
    pub(crate) fn new(
        mut partition: Partition,
        actuation: Actuation,
        regularisation: f64,
        names: &VariableNames<'_>,
        own_rows: ProblemRows,
        groups: &mut [Group],
        table: &mut Table,
    ) -> Self {
        let rows_of_motion = own_rows.dynamics.len();
        let first_ids = names.register(groups, table);
        let capacity = table.vars.len() - partition.torques.len();
        let rows: usize = groups.iter().map(|g| g.layout.len()).sum();
        let bounds: usize = groups.iter().map(|g| g.layout.bounds.len()).sum();
        let longest = groups.iter().map(|g| g.layout.len()).max().unwrap_or(0);
        let motions = Motions::new(&partition, groups);
        partition.reserve(motions.sizes().len());
        partition.arrange(&motions);
        Self {
            regularisation,
            dynamics_rows: own_rows.dynamics,
            normal_rows: own_rows.normals,
            live: Live::new(partition.nf.len(), groups.len(), capacity),
            relations: Relations::new(&partition, actuation, partition.nf.iter().sum()),
            quadratic: Quadratic::new(&partition, &motions, capacity),
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
    pub(crate) fn capacity(&self, groups: &[Group]) -> Capacity {
        Self::capacity_for(&self.partition, groups, self.dynamics_rows.len())
    }

    /// The same before there is an assembly.
    pub(crate) fn capacity_for(
        partition: &Partition,
        groups: &[Group],
        dynamics_rows: usize,
    ) -> Capacity {
        let is_row = |target: &BoundTarget| match *target {
            BoundTarget::Effort(i) => {
                matches!(partition.efforts[i], EffortPlace::Eliminated(_))
            }
            BoundTarget::Force(..) => false,
        };
        let bounds = |g: &Group| g.layout.bounds.iter().filter(|(_, t)| is_row(t)).count();
        let rows: usize = groups.iter().map(|g| g.row_capacity() + bounds(g)).sum();
        Capacity {
            vars: Self::natural_variables(partition, groups) - partition.substituted,
            rows: rows + dynamics_rows,
        }
    }

    /// Accelerations, kept efforts, forces and slacks.
    pub(crate) fn natural_variables(partition: &Partition, groups: &[Group]) -> usize {
        let slacks = groups.iter().filter(|g| g.treatment == Treatment::Slack);
        let forces: usize = partition.nf.iter().sum();
        partition.nv + partition.kept.len() + forces + slacks.count()
    }

    /// Builds the problem of this tick.
    pub(crate) fn assemble(
        &mut self,
        terms: &DynamicsTerms<'_>,
        groups: &mut [Group],
        qp: &mut Qp,
    ) -> Result<(), Fault> {
        if self.motions.update(groups, terms.contacts) {
            self.partition.arrange(&self.motions);
        }
        if self.relate(terms, groups) {
            self.put_together(terms, groups, qp)
        } else {
            self.assemble_with_all_rows(terms, groups, qp)
        }
    }

    /// Builds the problem of this tick without substituting anything from contacts: all limits have a row or a bound.
    pub(crate) fn assemble_with_all_rows(
        &mut self,
        terms: &DynamicsTerms<'_>,
        groups: &mut [Group],
        qp: &mut Qp,
    ) -> Result<(), Fault> {
        if self.motions.keep_all() {
            self.partition.arrange(&self.motions);
        }
        if self.relate(terms, groups) {
            self.put_together(terms, groups, qp)
        } else {
            Err(Fault::MassMatrix)
        }
    }

    /// Lays out the variables and what is substituted; false if that cannot be.
    fn relate(&mut self, terms: &DynamicsTerms<'_>, groups: &[Group]) -> bool {
        let live_slack = |g: usize| groups[g].live.then_some(groups[g].slack).flatten();
        self.live.refresh(
            &self.partition,
            &self.first_ids,
            |c| terms.contacts[c].live,
            live_slack,
        );
        self.relations
            .update(&self.partition, &self.motions, &self.live, terms)
    }

    fn put_together(
        &mut self,
        terms: &DynamicsTerms<'_>,
        groups: &mut [Group],
        qp: &mut Qp,
    ) -> Result<(), Fault> {
        let made = qp.reset(self.live.vars.iter().copied());
        debug_assert!(made.is_ok(), "{made:?}");
        self.constants.clear();
        self.torque_rows.clear();
        self.push_dynamics(terms, qp);
        self.quadratic.reset(self.live.n);
        let mut cost_rows = 0;
        for (index, group) in groups.iter_mut().enumerate() {
            group.cost_start = None;
            if !group.live {
                continue;
            }
            let treatment = group.treatment_now(is_equality(group));
            if self.motions.hold(index) {
                // By substitution.
            } else if treatment == Treatment::Cost {
                group.cost_start = Some(cost_rows);
                cost_rows += group.layout.len();
                self.add_cost(group, terms);
            } else if !self.push_rows(index, group, treatment, terms, qp) {
                return Err(Fault::Rows(index));
            }
            if !self.push_torque_bounds(group, qp) {
                return Err(Fault::Rows(index));
            }
        }
        if !self.quadratic.is_finite()
            && let Some(index) = groups.iter().position(|g| !self.is_cost_finite(g))
        {
            return Err(Fault::Rows(index));
        }
        self.regularise(groups);
        self.quadratic
            .add_all_determined(&self.partition, &self.motions);
        self.quadratic
            .add_torques(&self.partition, &self.relations, &self.live);
        self.quadratic.write(&self.relations, &self.live, qp);
        self.add_bounds(terms, groups, qp)
    }

    pub(super) fn context<'a>(&'a self, terms: &DynamicsTerms<'a>) -> Context<'a> {
        Context {
            partition: &self.partition,
            motions: &self.motions,
            relations: &self.relations,
            live: &self.live,
            terms: *terms,
        }
    }

    /// Takes a solution of the problem.
    pub(crate) fn recover(&mut self, groups: &[Group], terms: &DynamicsTerms<'_>, x: &[f64]) {
        let Self {
            recovered,
            partition,
            motions,
            relations,
            live,
            ..
        } = self;
        recovered.take(partition, motions, relations, live, x);
        recovered.assess(groups, live, terms, partition, self.regularisation_weight);
    }

    /// `v̇` of the solution taken last.
    pub(crate) fn vdot(&self) -> &[f64] {
        &self.recovered.vdot
    }

    /// Writes what tasks ask of single components of `v̇`, see [`Asked::collect`].
    pub(crate) fn collect_asked(&mut self, tasks: &[Group], out: &mut [f64]) {
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

    /// Its residuals `a x − b` and weights of a group's rows, if the group is a cost this tick.
    pub(crate) fn residuals(&self, group: &Group) -> Option<&[[f64; 2]]> {
        let start = group.cost_start?;
        self.recovered
            .residuals
            .get(start..start + group.layout.len())
    }
}

/// Whether the rows have one right-hand side.
pub(crate) fn is_equality(group: &Group) -> bool {
    group.is_task || group.layout.relation == Relation::Equality
}
