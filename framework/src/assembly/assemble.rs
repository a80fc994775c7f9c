//! Puts the problem of a tick together: rows, cost, bounds.

use super::{
    Actuation, Group, Live, Partition, Quadratic, Recovered, Relations, Table, Treatment,
    expand::{Context, is_finite},
    live::FirstIds,
    partition::EffortPlace,
};
use crate::{
    config::Formulation,
    contact::ContactState,
    controller::Fault,
    dynamics::{Data, FrameKinematics},
    layout::{Block, BoundTarget, Relation, VdotBlock},
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
    regularisation: f64,
    pub(super) partition: Partition,
    first_ids: FirstIds,
    dynamics_rows: Vec<RowId>,
    /// The bound on each contact's normal force, which every contact brings.
    pub(super) normal_rows: Vec<RowId>,
    pub(crate) live: Live,
    relations: Relations,
    quadratic: Quadratic,
    recovered: Recovered,
    /// A row over y.
    row: Vec<f64>,
    /// The rows over y of a group that is a cost.
    block: Vec<f64>,
    /// Their constant parts.
    constants: Vec<f64>,
    /// Columns in which they are not all zero.
    columns: Vec<usize>,
    /// Who set the lower and the upper bound of each variable of the problem.
    pub(crate) bound_owner: Vec<[Option<RowId>; 2]>,
    /// Largest weight that is on this tick, 1 without any.
    pub(super) largest_weight: f64,
    /// Weight of `‖(u, f)‖²` this tick.
    pub(crate) regularisation_weight: f64,
}

/// Names of the efforts and of the contacts' force components.
pub(crate) struct VariableNames<'a> {
    pub(crate) accelerations: Vec<(String, &'static str)>,
    pub(crate) efforts: Vec<(&'a str, &'static str)>,
    pub(crate) contacts: Vec<(&'a str, &'static [usize])>,
}

/// Rows that belong to the framework, registered before those of the entries: ids ascend in the order in which rows
/// appear in the problem.
pub(crate) struct ProblemRows {
    dynamics: Vec<RowId>,
    normals: Vec<RowId>,
}

impl ProblemRows {
    pub(crate) fn new(
        formulation: Formulation,
        names: &VariableNames<'_>,
        table: &mut Table,
    ) -> Self {
        let mut dynamics = Vec::new();
        if formulation == Formulation::Explicit {
            for (label, unit) in &names.accelerations {
                let unit = match *unit {
                    "m/s²" => "N",
                    _ => "N·m",
                };
                dynamics.push(table.add_row("dynamics", label, unit));
            }
        }
        table.add_row("regularisation", "efforts and forces", "1");
        let normals = names.contacts.iter();
        let normals = normals
            .map(|(name, _)| table.add_row(name, "normal force", "N"))
            .collect();
        Self { dynamics, normals }
    }
}

const FORCE_LABELS: [(&str, &str); 6] = [
    ("x", "N"),
    ("y", "N"),
    ("normal", "N"),
    ("moment x", "N·m"),
    ("moment y", "N·m"),
    ("moment z", "N·m"),
];

impl Assembly {
    /// Gives the physical variables, the dynamics rows and the slacks their ids. `actuation` has the efforts that the
    /// partition keeps.
    pub(crate) fn new(
        partition: Partition,
        actuation: Actuation,
        regularisation: f64,
        names: &VariableNames<'_>,
        rows: ProblemRows,
        groups: &mut [Group],
        table: &mut Table,
    ) -> Self {
        let ProblemRows {
            dynamics: dynamics_rows,
            normals: normal_rows,
        } = rows;
        let first_vdot = table.vars.len() as u32;
        for (label, unit) in &names.accelerations {
            table.add_var("acceleration", label, unit);
        }
        let first_effort = table.vars.len() as u32;
        for (name, unit) in &names.efforts {
            table.add_var(name, "effort", unit);
        }
        let mut first_force = Vec::new();
        for (name, directions) in &names.contacts {
            first_force.push(table.vars.len() as u32);
            for &d in *directions {
                let (label, unit) = FORCE_LABELS[d];
                table.add_var(name, label, unit);
            }
        }
        for group in groups.iter_mut() {
            group.add_slack(table);
        }
        let capacity = table.vars.len() - partition.torques.len();
        let rows: usize = groups.iter().map(|g| g.layout.len()).sum();
        let longest = groups.iter().map(|g| g.layout.len()).max().unwrap_or(0);
        Self {
            regularisation,
            dynamics_rows,
            normal_rows,
            live: Live::new(partition.nf.len(), groups.len(), capacity),
            relations: Relations::new(&partition, actuation, partition.nf.iter().sum()),
            quadratic: Quadratic::new(&partition, capacity),
            recovered: Recovered::new(&partition, rows, capacity),
            row: vec![0.0; capacity],
            block: vec![0.0; longest * capacity],
            constants: vec![0.0; longest],
            columns: Vec::with_capacity(capacity),
            bound_owner: vec![[None; 2]; capacity],
            largest_weight: 1.0,
            regularisation_weight: 0.0,
            first_ids: FirstIds {
                vdot: first_vdot,
                effort: first_effort,
                force: first_force,
            },
            partition,
        }
    }

    /// Whether a row is one of the equations of motion.
    pub(crate) fn is_dynamics(&self, id: RowId) -> bool {
        self.dynamics_rows.contains(&id)
    }

    /// The largest problem that can come up.
    pub(crate) fn capacity(&self, groups: &[Group]) -> Capacity {
        let is_row = |target: &BoundTarget| match *target {
            BoundTarget::Effort(i) => {
                matches!(self.partition.efforts[i], EffortPlace::Eliminated(_))
            }
            BoundTarget::Force(..) => false,
        };
        let bounds = |g: &Group| g.layout.bounds.iter().filter(|(_, t)| is_row(t)).count();
        let rows: usize = groups.iter().map(|g| g.row_capacity() + bounds(g)).sum();
        Capacity {
            vars: self.row.len() - self.partition.substituted,
            rows: rows + self.dynamics_rows.len(),
        }
    }

    /// Builds the problem of this tick.
    pub(crate) fn assemble(
        &mut self,
        terms: &DynamicsTerms<'_>,
        groups: &mut [Group],
        qp: &mut Qp,
    ) -> Result<(), Fault> {
        let live_slack = |g: usize| groups[g].live.then_some(groups[g].slack).flatten();
        self.live.refresh(
            &self.partition,
            &self.first_ids,
            |c| terms.contacts[c].live,
            live_slack,
        );
        qp.reset(self.live.vars.iter().copied());
        if !self.relations.update(&self.partition, &self.live, terms) {
            return Err(Fault::MassMatrix);
        }
        self.push_dynamics(terms, qp);
        self.quadratic.reset(self.live.n);
        let mut cost_rows = 0;
        for (index, group) in groups.iter_mut().enumerate() {
            group.cost_start = None;
            if !group.live {
                continue;
            }
            let treatment = group.treatment_now(is_equality(group));
            if treatment == Treatment::Cost {
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
            .add_torques(&self.partition, &self.relations, &self.live);
        self.quadratic.write(&self.relations, &self.live, qp);
        self.add_bounds(terms, groups, qp)
    }

    fn context<'a>(&'a self, terms: &DynamicsTerms<'a>) -> Context<'a> {
        Context {
            partition: &self.partition,
            relations: &self.relations,
            live: &self.live,
            terms: *terms,
        }
    }

    /// `M v̇ − [S J_cᵀ] (u, f) = Σ J_fᵀ f_f − h`.
    fn push_dynamics(&self, terms: &DynamicsTerms<'_>, qp: &mut Qp) {
        let (nv, n) = (self.partition.nv, self.live.n_physical);
        let mass = terms.data.mass_matrix();
        for (i, &id) in self.dynamics_rows.iter().enumerate() {
            let (forcing, known) = self.relations.forcing(i);
            let Some(row) = qp.push_row(id, known, known) else {
                return;
            };
            for (a, m) in row[..nv].iter_mut().zip(mass.column(i).iter()) {
                *a = *m;
            }
            for (a, s) in row[nv..n].iter_mut().zip(forcing) {
                *a = -s;
            }
        }
    }

    /// Adds a group's rows to the cost, by what their blocks leave zero.
    fn add_cost(&mut self, group: &Group, terms: &DynamicsTerms<'_>) {
        let (weights, alpha) = (group.weight.now(), group.alpha);
        let weight = |k: usize| weights[k] * alpha;
        let b = |k: usize| group.store.lower[k];
        let layout = &group.layout;
        let (rows, partition) = (layout.len(), &self.partition);
        let quadratic = &mut self.quadratic;
        match (&layout.vdot, &layout.effort, layout.forces.as_slice()) {
            (VdotBlock::Unit(velocities), None, []) => {
                for (k, &velocity) in velocities.iter().enumerate() {
                    quadratic.add_unit(partition.columns[velocity], weight(k), b(k));
                }
            }
            (VdotBlock::Frame(frame, directions), None, []) => {
                let (jacobian, carriers) = (&terms.frames[frame.0].J, &partition.frames[frame.0]);
                let a = |k: usize, i: usize| jacobian[(directions[k], carriers[i].velocity)];
                let columns = carriers.iter().map(|at| at.column);
                quadratic.add_rows(rows, columns, a, weight, b);
            }
            (VdotBlock::Contact(contact, directions), None, []) => {
                let contact = contact.index();
                let (jacobian, carriers) =
                    (&terms.contacts[contact].J, &partition.contacts[contact]);
                let a = |k: usize, i: usize| jacobian[(directions[k], carriers[i].velocity)];
                let columns = carriers.iter().map(|at| at.column);
                quadratic.add_rows(rows, columns, a, weight, b);
            }
            (VdotBlock::Dense, None, []) => {
                let (nv, velocities) = (partition.nv, &partition.velocities);
                let a = |k: usize, i: usize| group.store.vdot[k * nv + velocities[i]];
                quadratic.add_rows(rows, 0..nv, a, weight, b);
            }
            (VdotBlock::Absent, Some(Block::Unit(actuators)), []) => {
                for (k, &actuator) in actuators.iter().enumerate() {
                    match partition.efforts[actuator] {
                        EffortPlace::Kept(column) => quadratic.add_unit(column, weight(k), b(k)),
                        EffortPlace::Eliminated(t) => quadratic.add_torque(t, weight(k), b(k)),
                    }
                }
            }
            (VdotBlock::Absent, None, [(contact, Block::Unit(components))]) => {
                if let Some(start) = self.live.forces[contact.index()] {
                    for (k, &component) in components.iter().enumerate() {
                        quadratic.add_unit(start + component, weight(k), b(k));
                    }
                }
            }
            _ => self.add_mixed_cost(group, terms),
        }
    }

    /// Adds rows with several blocks, or dense ones on efforts and forces, to the cost.
    fn add_mixed_cost(&mut self, group: &Group, terms: &DynamicsTerms<'_>) {
        let (rows, n) = (group.layout.len(), self.live.n_physical);
        let mut block = std::mem::take(&mut self.block);
        let mut constants = std::mem::take(&mut self.constants);
        block[..rows * n].fill(0.0);
        let context = self.context(terms);
        for (k, row) in block.chunks_exact_mut(n).take(rows).enumerate() {
            constants[k] = context.natural_row(group, k, row);
        }
        if !matches!(group.layout.vdot, VdotBlock::Absent) {
            self.quadratic.couple();
        }
        let (weights, alpha) = (group.weight.now(), group.alpha);
        let is_there = |column: usize| (0..rows).any(|k| block[k * n + column] != 0.0);
        self.columns.clear();
        self.columns
            .extend((0..n).filter(|&column| is_there(column)));
        let columns = &self.columns;
        self.quadratic.add_rows(
            rows,
            columns.iter().copied(),
            |k, i| block[k * n + columns[i]],
            |k| weights[k] * alpha,
            |k| group.store.lower[k] - constants[k],
        );
        self.block = block;
        self.constants = constants;
    }

    /// Pushes a group's rows; false if they have numbers that cannot be.
    fn push_rows(
        &mut self,
        index: usize,
        group: &Group,
        treatment: Treatment,
        terms: &DynamicsTerms<'_>,
        qp: &mut Qp,
    ) -> bool {
        let (n, p) = (self.live.n, self.partition.substituted);
        let equality = is_equality(group);
        let mut row = std::mem::take(&mut self.row);
        let context = self.context(terms);
        let mut good = true;
        for k in 0..group.layout.len() {
            let y = &mut row[..n];
            y.fill(0.0);
            let constant = context.natural_row(group, k, y);
            let constant = constant + context.substitute(y);
            let (lower, upper) = (
                group.store.lower[k] - constant,
                group.store.upper[k] - constant,
            );
            // Infinite limits are legal, infinite right-hand sides are not; a NaN never is.
            let usable = |limit: f64| limit.is_finite() || (!equality && !limit.is_nan());
            if !(is_finite(group, &self.partition, k)
                && usable(lower)
                && (equality || usable(upper)))
            {
                good = false;
                break;
            }
            let x = &y[p..];
            if treatment == Treatment::Slack {
                let slack = self.live.slacks[index];
                for (side, id) in [(-1.0, group.rows[2 * k]), (1.0, group.rows[2 * k + 1])] {
                    let limits = if side < 0.0 {
                        (f64::NEG_INFINITY, upper)
                    } else {
                        (lower, f64::INFINITY)
                    };
                    if let Some(out) = qp.push_row(id, limits.0, limits.1) {
                        out.copy_from_slice(x);
                        if let Some(slack) = slack {
                            out[slack - p] = side;
                        }
                    }
                }
            } else {
                // Tasks and equalities write one right-hand side, into the lower limit.
                let upper = if equality { lower } else { upper };
                if let Some(out) = qp.push_row(group.rows[k], lower, upper) {
                    out.copy_from_slice(x);
                }
            }
        }
        self.row = row;
        if let (Treatment::Slack, Some(slack)) = (treatment, self.live.slacks[index]) {
            self.quadratic
                .add_slack(slack, group.slack_weight(), group.slack_penalty());
        }
        good
    }

    /// Pushes a group's bounds on eliminated efforts, which are rows; false if a limit is not a number.
    fn push_torque_bounds(&mut self, group: &Group, qp: &mut Qp) -> bool {
        let p = self.partition.substituted;
        for (b, (_, target)) in group.layout.bounds.iter().enumerate() {
            let BoundTarget::Effort(actuator) = *target else {
                continue;
            };
            let EffortPlace::Eliminated(index) = self.partition.efforts[actuator] else {
                continue;
            };
            let (lower, upper) = (group.store.bound_lower[b], group.store.bound_upper[b]);
            if lower.is_nan() || upper.is_nan() {
                return false;
            }
            if lower == f64::NEG_INFINITY && upper == f64::INFINITY {
                continue;
            }
            let (torque, known) = self.relations.torque(index);
            let (head, tail) = torque.split_at(p);
            let row = &mut self.row[..tail.len()];
            row.copy_from_slice(tail);
            let constant = known + self.relations.substitute(head, row);
            let limits = (lower - constant, upper - constant);
            if let Some(out) = qp.push_row(group.bounds[b], limits.0, limits.1) {
                out[..row.len()].copy_from_slice(row);
            }
        }
        true
    }

    /// Whether what a group wrote for the cost is finite.
    fn is_cost_finite(&self, group: &Group) -> bool {
        group.cost_start.is_none()
            || (0..group.layout.len())
                .all(|k| group.store.lower[k].is_finite() && is_finite(group, &self.partition, k))
    }

    /// `w_ε ‖(u, f)‖²` with `w_ε` relative to the largest weight that is on.
    fn regularise(&mut self, groups: &[Group]) {
        let on = groups.iter().filter(|g| g.cost_start.is_some());
        let largest = on.map(Group::largest_weight).fold(0.0, f64::max);
        self.largest_weight = if largest > 0.0 { largest } else { 1.0 };
        let weight = self.regularisation * self.largest_weight;
        self.regularisation_weight = weight;
        for column in self.partition.nv..self.live.n_physical {
            self.quadratic.add_unit(column, weight, 0.0);
        }
        for torque in 0..self.partition.torques.len() {
            self.quadratic.add_torque(torque, weight, 0.0);
        }
    }

    /// Intersects the bounds of all live groups and remembers whose are the tightest.
    fn add_bounds(
        &mut self,
        terms: &DynamicsTerms<'_>,
        groups: &[Group],
        qp: &mut Qp,
    ) -> Result<(), Fault> {
        let (n, p) = (qp.n(), self.partition.substituted);
        self.bound_owner[..n].fill([None; 2]);
        let (lower, upper) = qp.bounds_mut();
        for slack in self.live.slacks.iter().flatten() {
            lower[slack - p] = 0.0;
        }
        for (c, contact) in terms.contacts.iter().enumerate() {
            if let Some(start) = self.live.forces[c] {
                let at = start - p + contact.kind.normal();
                [lower[at], upper[at]] = contact.force_limits;
                self.bound_owner[at] = [Some(self.normal_rows[c]); 2];
            }
        }
        for (index, group) in groups.iter().enumerate().filter(|(_, g)| g.live) {
            for (b, (_, target)) in group.layout.bounds.iter().enumerate() {
                let Some(at) = self.position(*target).filter(|&at| at < n) else {
                    continue;
                };
                let (l, u) = (group.store.bound_lower[b], group.store.bound_upper[b]);
                if l.is_nan() || u.is_nan() {
                    return Err(Fault::Rows(index));
                }
                if l > lower[at] {
                    lower[at] = l;
                    self.bound_owner[at][0] = Some(group.bounds[b]);
                }
                if u < upper[at] {
                    upper[at] = u;
                    self.bound_owner[at][1] = Some(group.bounds[b]);
                }
            }
        }
        Ok(())
    }

    /// Where a bounded variable stands in the problem, if it is one and live.
    pub(super) fn position(&self, target: BoundTarget) -> Option<usize> {
        let column = match target {
            BoundTarget::Effort(i) => match self.partition.efforts[i] {
                EffortPlace::Kept(column) => Some(column),
                EffortPlace::Eliminated(_) => None,
            },
            BoundTarget::Force(contact, i) => {
                self.live.forces[contact.index()].map(|start| start + i)
            }
        };
        column.map(|column| column - self.partition.substituted)
    }

    /// Takes a solution of the problem.
    pub(crate) fn recover(&mut self, groups: &[Group], terms: &DynamicsTerms<'_>, x: &[f64]) {
        let Self {
            recovered,
            partition,
            relations,
            live,
            ..
        } = self;
        recovered.take(partition, relations, live, x);
        recovered.assess(groups, live, terms, partition, self.regularisation_weight);
    }

    /// `v̇` of the solution taken last.
    pub(crate) fn vdot(&self) -> &[f64] {
        &self.recovered.vdot
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
