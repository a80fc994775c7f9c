//! Makes the problem before the first tick: its storage, for everything switched on, and the ids of rows and variables.

use super::{
    ActiveVariables, BoundEntry, ContactElimination, Partition, Problem, ProblemRows,
    ReducedDynamics, Table, Treatment, VariableNames,
    hessian::{BLOCK, NaturalCost},
    linear_algebra::TreeCholesky,
    rows::{Kind, NaturalRows},
    solution::{Asked, Solved},
    variables::EffortPlace,
};
use crate::{
    contact::{ContactId, ContactState},
    plugin::{
        Hardness, Layout, PerRow,
        layout::{Block, BoundTarget, Relation, VdotBlock},
        storage::RowStore,
    },
    qp::Capacity,
    switch::{Switch, WeightRamp},
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

/// What an entry says about its rows.
pub(crate) struct EntrySpec<'a> {
    pub(crate) name: &'a str,
    pub(crate) weight: &'a PerRow,
    pub(crate) hardness: Hardness,
    pub(crate) switch: Switch,
    /// Tasks write `b`; constraints write limits unless they are equalities.
    pub(crate) is_task: bool,
}

impl BoundEntry {
    /// Registers the rows in the table; their storage comes later. Slacks are added by [`BoundEntry::add_slack`], so
    /// that the ids of physical variables come first.
    pub(crate) fn new(spec: &EntrySpec<'_>, layout: Layout, table: &mut Table) -> Self {
        let equality = spec.is_task || layout.relation == Relation::Equality;
        let (treatment, linear_penalty) = match (spec.hardness, equality) {
            (Hardness::Hard, _) => (Treatment::Hard, 0.0),
            (Hardness::Soft | Hardness::Exact(_), true) => (Treatment::Cost, 0.0),
            (Hardness::Soft, false) => (Treatment::Slack, 0.0),
            (Hardness::Exact(linear), false) => (Treatment::Slack, linear),
        };
        let mut rows = Vec::new();
        for row in &layout.rows {
            if treatment == Treatment::Slack {
                let mut add = |side: &str| {
                    table.add_row(spec.name, &format!("{} {side}", row.label), &row.unit)
                };
                rows.push(add("upper"));
                rows.push(add("lower"));
            } else {
                rows.push(table.add_row(spec.name, &row.label, &row.unit));
            }
        }
        let bounds = layout
            .bounds
            .iter()
            .map(|(row, _)| table.add_row(spec.name, &row.label, &row.unit))
            .collect();
        Self {
            name: spec.name.to_owned(),
            is_task: spec.is_task,
            weight: WeightRamp::new(
                (0..layout.len()).map(|i| spec.weight.row(i)).collect(),
                spec.switch.transition(),
            ),
            layout,
            store: RowStore::default(),
            linear_penalty,
            treatment,
            switch: spec.switch,
            rows,
            bounds,
            slack: None,
            live: false,
            alpha: 0.0,
        }
    }

    pub(crate) fn add_slack(&mut self, table: &mut Table) {
        if self.treatment == Treatment::Slack && !self.layout.is_empty() {
            let unit = self.layout.rows[0].unit.clone();
            self.slack = Some(table.add_var(&self.name, "slack", &unit));
        }
    }

    /// Lets the rows go to another weight.
    ///
    /// # Errors
    /// Why not, in words: the weight does not fit the rows, or is zero where it is the price of a limit.
    pub(crate) fn reweight(&mut self, weight: &PerRow) -> Result<(), String> {
        let rows = self.weight.now().len();
        let usable = weight.values().iter().all(|w| w.is_finite() && *w >= 0.0)
            && (matches!(weight, PerRow::Uniform(_)) || weight.values().len() == rows);
        if !usable {
            return Err(format!(
                "must be one number, or {rows}, finite and not negative"
            ));
        }
        if self.treatment == Treatment::Slack && weight.values().iter().all(|w| *w == 0.0) {
            return Err("is zero: a soft inequality without price limits nothing".to_owned());
        }
        self.weight.turn(|row| weight.row(row));
        Ok(())
    }
}

impl NaturalRows {
    /// For at most `capacity` natural variables.
    pub(super) fn new(layout: &Layout, partition: &Partition, capacity: usize) -> Self {
        let count = layout.len();
        let kind = kind(layout);
        let wide = width(layout, partition, capacity);
        Self {
            kind,
            count,
            singles: Vec::with_capacity(if kind == Kind::Single { count } else { 0 }),
            columns: Vec::with_capacity(wide),
            values: Vec::with_capacity(count * wide),
            dense: vec![0.0; if kind == Kind::Mixed { count * wide } else { 0 }],
            constants: vec![0.0; count],
        }
    }

    /// Numbers that the rows of a layout take.
    pub(super) fn numbers(layout: &Layout, partition: &Partition, capacity: usize) -> usize {
        let width = width(layout, partition, capacity);
        let (rows, copies) = match kind(layout) {
            Kind::Single => return 5 * layout.len(),
            Kind::Motion | Kind::Forces => (layout.len(), 1),
            Kind::Mixed => (layout.len(), 2),
        };
        rows.saturating_mul(copies)
            .saturating_add(1)
            .saturating_mul(width)
    }
}

fn kind(layout: &Layout) -> Kind {
    let ascend =
        |forces: &[(ContactId, Block)]| forces.windows(2).all(|pair| pair[0].0 < pair[1].0);
    match (&layout.vdot, &layout.effort, layout.forces.as_slice()) {
        (VdotBlock::Unit(_), None, [])
        | (VdotBlock::Absent, Some(Block::Unit(_)), [])
        | (VdotBlock::Absent, None, [(_, Block::Unit(_))]) => Kind::Single,
        (VdotBlock::Frame(..) | VdotBlock::Contact(..) | VdotBlock::Dense, None, []) => {
            Kind::Motion
        }
        (VdotBlock::Absent, None, forces) if ascend(forces) => Kind::Forces,
        _ => Kind::Mixed,
    }
}

/// The most natural variables that the rows have coefficients on, if they are written out; of `capacity`.
fn width(layout: &Layout, partition: &Partition, capacity: usize) -> usize {
    let of = |contact: &ContactId| partition.nf.get(contact.index()).copied();
    match kind(layout) {
        Kind::Single => 0,
        Kind::Motion => partition.nv,
        Kind::Forces => layout.forces.iter().filter_map(|(c, _)| of(c)).sum(),
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
    pub(super) fn new(
        partition: &Partition,
        elimination: &ContactElimination,
        capacity: usize,
    ) -> Self {
        Self {
            n: 0,
            h: vec![0.0; capacity * capacity],
            g: vec![0.0; capacity],
            torque: vec![[0.0; 2]; partition.torques.len()],
            determined: elimination
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
    /// For at most `rows` cost rows of so many entries, and `capacity` natural variables.
    pub(super) fn new(partition: &Partition, entries: usize, rows: usize, capacity: usize) -> Self {
        Self {
            vdot: vec![0.0; partition.nv],
            effort: vec![0.0; partition.efforts.len()],
            objective: 0.0,
            y: vec![0.0; capacity],
            values: vec![0.0; rows],
            residuals: Vec::with_capacity(rows),
            starts: vec![None; entries],
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
