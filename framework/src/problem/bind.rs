//! Makes the problem before the first tick: its storage, for everything switched on, and the ids of rows and variables.

use super::{
    ActiveVariables, BoundEntry, ContactElimination, Partition, Problem, ProblemRows,
    ReducedDynamics, Table, Treatment, VariableNames,
    hessian::{BLOCK, NaturalCost},
    linear_algebra::TreeCholesky,
    partition::EffortPlace,
    rows::{Kind, NaturalRows},
    solution::{Asked, Solved},
};
use crate::{
    contact::ContactState,
    plugin::{
        Layout,
        layout::{Block, BoundTarget, VdotBlock},
        storage::Variable,
    },
    qp::Capacity,
};
use wbqp_dynamics::Actuation;

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
        partition.elimination = ContactElimination::new(&partition, entries);
        let motions = partition.elimination.sizes().len();
        partition.reserve(motions);
        partition.arrange();
        let natural = |entry: &BoundEntry| NaturalRows::new(entry, &partition, capacity);
        Self {
            regularisation,
            dynamics_rows: own_rows.dynamics,
            normal_rows: own_rows.normals,
            active: ActiveVariables::new(partition.nf.len(), entries.len(), capacity),
            reduced: ReducedDynamics::new(&partition, actuation, partition.nf.iter().sum()),
            rows: entries.iter().map(natural).collect(),
            is_arranged: false,
            cost: NaturalCost::new(&partition, capacity),
            solved: Solved::new(&partition, entries.len(), rows, capacity),
            asked: Asked::new(partition.nv),
            row: vec![0.0; capacity],
            constants: Vec::with_capacity(2 * rows + bounds + rows_of_motion),
            torque_rows: Vec::with_capacity(bounds),
            bound_owner: vec![[None; 2]; capacity],
            largest_weight: 1.0,
            regularisation_weight: 0.0,
            first_ids,
            partition,
        }
    }

    /// Chooses what contacts may determine. The robot is at home.
    pub(crate) fn choose_determined(&mut self, contacts: &[ContactState]) {
        let mut elimination = std::mem::take(&mut self.partition.elimination);
        elimination.choose(&self.partition, contacts);
        self.partition.elimination = elimination;
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
        let of = |entry: &BoundEntry| NaturalRows::numbers(entry, partition, natural);
        entries.iter().map(of).fold(0, usize::saturating_add)
    }
}

impl NaturalRows {
    /// For at most `capacity` natural variables.
    pub(super) fn new(entry: &BoundEntry, partition: &Partition, capacity: usize) -> Self {
        let layout = &entry.layout;
        let count = layout.len();
        let kind = kind(entry);
        let wide = width(kind, partition, capacity);
        Self {
            kind,
            count,
            is_expanded: false,
            is_cost: false,
            couples: layout.acts_on_accelerations() && layout.acts_on_forces(),
            singles: if kind == Kind::Single {
                singles(layout)
            } else {
                Vec::new()
            },
            columns: Vec::with_capacity(wide),
            values: Vec::with_capacity(count * wide),
            dense: vec![0.0; if kind == Kind::Mixed { count * wide } else { 0 }],
            constants: vec![0.0; count],
        }
    }

    /// Numbers that the rows of a layout take.
    pub(super) fn numbers(entry: &BoundEntry, partition: &Partition, capacity: usize) -> usize {
        let (layout, kind) = (&entry.layout, kind(entry));
        let width = width(kind, partition, capacity);
        let (rows, copies) = match kind {
            Kind::Single => return 5 * layout.len(),
            Kind::Motion | Kind::Forces => (layout.len(), 1),
            Kind::Mixed => (layout.len(), 2),
        };
        rows.saturating_mul(copies)
            .saturating_add(1)
            .saturating_mul(width)
    }
}

fn kind(entry: &BoundEntry) -> Kind {
    let layout = &entry.layout;
    match (&layout.vdot, &layout.effort, layout.forces.as_slice()) {
        (VdotBlock::Unit(_), None, [])
        | (VdotBlock::Absent, Some(Block::Unit(_)), [])
        | (VdotBlock::Absent, None, [(_, Block::Unit(_))]) => Kind::Single,
        (VdotBlock::Frame(..) | VdotBlock::Contact(..) | VdotBlock::Dense, None, []) => {
            Kind::Motion
        }
        (VdotBlock::Absent, None, _) if !entry.is_equality() => Kind::Forces,
        _ => Kind::Mixed,
    }
}

/// What each row is, of those that are one component each.
fn singles(layout: &Layout) -> Vec<Variable> {
    match (&layout.vdot, &layout.effort, layout.forces.as_slice()) {
        (VdotBlock::Unit(velocities), ..) => velocities
            .iter()
            .map(|&v| Variable::Acceleration(v))
            .collect(),
        (_, Some(Block::Unit(actuators)), _) => {
            actuators.iter().map(|&u| Variable::Effort(u)).collect()
        }
        (.., [(contact, Block::Unit(components))]) => components
            .iter()
            .map(|&i| Variable::Force(*contact, i))
            .collect(),
        _ => Vec::new(),
    }
}

/// The most natural variables that rows have coefficients on, if they are written out; of `capacity`.
fn width(kind: Kind, partition: &Partition, capacity: usize) -> usize {
    match kind {
        Kind::Single | Kind::Forces => 0,
        Kind::Motion => partition.nv,
        Kind::Mixed => capacity,
    }
}

impl ActiveVariables {
    pub(crate) fn new(contacts: usize, entries: usize, capacity: usize) -> Self {
        Self {
            forces: vec![None; contacts],
            slacks: vec![None; entries],
            n_physical: 0,
            n: 0,
            vars: Vec::with_capacity(capacity),
        }
    }
}

impl ReducedDynamics {
    /// For at most `forces` force components; `actuation` has the kept efforts.
    pub(crate) fn new(partition: &Partition, actuation: Actuation, forces: usize) -> Self {
        let (nv, inputs) = (partition.nv, partition.kept.len() + forces);
        let width = nv - partition.substituted + inputs;
        let torques = partition.torques.len();
        Self {
            actuation,
            cholesky: TreeCholesky::new(partition.ancestors.clone()),
            coupled: vec![0.0; partition.substituted * partition.substituted],
            scale: vec![0.0; partition.substituted],
            units: vec![0.0; partition.substituted],
            forcing: vec![0.0; nv * (inputs + 1)],
            inputs,
            response: vec![0.0; partition.substituted * (width + 1)],
            substituted: partition.substituted,
            width,
            torque: vec![0.0; torques * (nv + inputs)],
            torque_known: vec![0.0; torques],
            n_physical: nv + inputs,
        }
    }
}

impl TreeCholesky {
    /// For a matrix whose entry `(i, j)`, `j < i`, is zero unless `j` is an ancestor of `i`.
    pub(crate) fn new(ancestors: Vec<Vec<usize>>) -> Self {
        let n = ancestors.len();
        let carries = |i: usize| (i + 1..n).filter(|&d| ancestors[d].contains(&i)).collect();
        Self {
            n,
            l: vec![0.0; n * n],
            reciprocal: vec![0.0; n],
            descendants: (0..n).map(carries).collect(),
            ancestors,
        }
    }
}

impl NaturalCost {
    /// For at most `capacity` natural variables.
    pub(super) fn new(partition: &Partition, capacity: usize) -> Self {
        Self {
            n: 0,
            h: vec![0.0; capacity * capacity],
            g: vec![0.0; capacity],
            torque: vec![[0.0; 2]; partition.torques.len()],
            determined: partition
                .elimination
                .sizes()
                .map(|rows| vec![[0.0; 2]; rows])
                .collect(),
            is_coupled: false,
            carried: vec![0.0; partition.substituted * capacity],
            known: vec![0.0; partition.substituted],
            columns: Vec::with_capacity(capacity),
            values: Vec::with_capacity(capacity * BLOCK),
        }
    }
}

impl Solved {
    /// For at most `rows` rows of costs and tasks of so many entries, and `capacity` natural variables.
    pub(super) fn new(partition: &Partition, entries: usize, rows: usize, capacity: usize) -> Self {
        Self {
            vdot: vec![0.0; partition.nv],
            effort: vec![0.0; partition.efforts.len()],
            objective: 0.0,
            y: vec![0.0; capacity],
            values: vec![0.0; rows],
            residuals: Vec::with_capacity(rows),
            ranges: vec![0..0; entries],
        }
    }
}

impl Asked {
    /// For nv components.
    pub(crate) fn new(nv: usize) -> Self {
        Self {
            sums: vec![[0.0; 2]; nv],
        }
    }
}
