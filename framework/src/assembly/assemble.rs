//! Expands the rows of all live groups over the packed variables and fills the [`Qp`].

use super::{Actuation, Group, Live, Table, Treatment, condensed::Condensed, live::Variables};
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
    pub(crate) actuation: &'a Actuation,
}

/// Workspace of the assembly.
#[derive(Clone, Debug)]
pub(crate) struct Assembly {
    formulation: Formulation,
    regularisation: f64,
    variables: Variables,
    dynamics_rows: Vec<RowId>,
    /// The bound on each contact's normal force, which every contact brings.
    pub(super) normal_rows: Vec<RowId>,
    pub(crate) live: Live,
    condensed: Condensed,
    /// Cost rows, row-major over the packed variables; their right-hand sides and weights.
    stack: Vec<f64>,
    stack_b: Vec<f64>,
    stack_w: Vec<f64>,
    stack_rows: usize,
    row: Vec<f64>,
    /// Who set the lower and the upper bound of each packed variable.
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
    /// Gives the physical variables, the dynamics rows and the slacks their ids.
    pub(crate) fn new(
        formulation: Formulation,
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
        let nv = names.accelerations.len();
        let nu = names.efforts.len();
        let mut first_vdot = 0;
        for (i, (label, unit)) in names.accelerations.iter().enumerate() {
            let id = table.add_var("acceleration", label, unit);
            if i == 0 {
                first_vdot = id.0;
            }
        }
        let mut first_effort = table.vars.len() as u32;
        for (i, (name, unit)) in names.efforts.iter().enumerate() {
            let id = table.add_var(name, "effort", unit);
            if i == 0 {
                first_effort = id.0;
            }
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
        let nf: Vec<usize> = names.contacts.iter().map(|(_, d)| d.len()).collect();
        let capacity = table.vars.len();
        let stack_capacity: usize = groups.iter().map(|g| g.layout.len()).sum();
        Self {
            formulation,
            regularisation,
            dynamics_rows,
            normal_rows,
            live: Live::new(nf.len(), groups.len(), capacity),
            condensed: Condensed::new(nv, nu + nf.iter().sum::<usize>()),
            variables: Variables {
                nv,
                nu,
                nf,
                first_vdot,
                first_effort,
                first_force,
            },
            stack: vec![0.0; stack_capacity * capacity],
            stack_b: vec![0.0; stack_capacity],
            stack_w: vec![0.0; stack_capacity],
            stack_rows: 0,
            row: vec![0.0; capacity],
            bound_owner: vec![[None; 2]; capacity],
            largest_weight: 1.0,
            regularisation_weight: 0.0,
        }
    }

    /// Whether a row is one of the equations of motion.
    pub(crate) fn is_dynamics(&self, id: RowId) -> bool {
        self.dynamics_rows.contains(&id)
    }

    /// The largest problem that can come up.
    pub(crate) fn capacity(&self, groups: &[Group], table: &Table) -> Capacity {
        let rows: usize = groups.iter().map(Group::row_capacity).sum();
        let vdot = match self.formulation {
            Formulation::Condensed => self.variables.nv,
            Formulation::Explicit => 0,
        };
        Capacity {
            vars: table.vars.len() - vdot,
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
        let explicit = self.formulation == Formulation::Explicit;
        let live_slack = |g: usize| groups[g].live.then_some(groups[g].slack).flatten();
        self.live.refresh(
            &self.variables,
            explicit,
            |c| terms.contacts[c].live,
            live_slack,
        );
        qp.reset(self.live.vars.iter().copied());
        self.condensed.load(terms, &self.live);
        if explicit {
            self.push_dynamics(terms, qp);
        } else if !self.condensed.solve(terms) {
            return Err(Fault::MassMatrix);
        }
        self.stack_rows = 0;
        for (index, group) in groups.iter_mut().enumerate() {
            group.stack_start = None;
            if group.live && !self.add_group(index, group, terms, qp) {
                return Err(Fault::Rows(index));
            }
        }
        self.add_cost(qp);
        self.regularise(groups, qp);
        self.add_bounds(terms, groups, qp)
    }

    /// `M v̇ − [S J_cᵀ] (u, f) = Σ J_fᵀ f_f − h`.
    fn push_dynamics(&self, terms: &DynamicsTerms<'_>, qp: &mut Qp) {
        let (nv, n) = (self.variables.nv, self.live.n_physical);
        let mass = terms.data.mass_matrix();
        for (i, &id) in self.dynamics_rows.iter().enumerate() {
            let (forcing, known) = self.condensed.forcing(i);
            let Some(row) = qp.push_row(id, known, known) else {
                return;
            };
            for (j, a) in row[..nv].iter_mut().enumerate() {
                *a = mass[(i, j)];
            }
            for (a, s) in row[nv..n].iter_mut().zip(forcing) {
                *a = -s;
            }
        }
    }

    fn add_group(
        &mut self,
        index: usize,
        group: &mut Group,
        terms: &DynamicsTerms<'_>,
        qp: &mut Qp,
    ) -> bool {
        let n = qp.n();
        let treatment = group.treatment_now(is_equality(group));
        if treatment == Treatment::Cost {
            group.stack_start = Some(self.stack_rows);
        }
        for k in 0..group.layout.len() {
            let shift = self.expand(group, k, terms, n);
            let (lower, upper) = (group.store.lower[k] - shift, group.store.upper[k] - shift);
            // Infinite limits are legal, infinite right-hand sides are not; a NaN never is.
            let one_sided = treatment != Treatment::Cost && !is_equality(group);
            let usable = |limit: f64| limit.is_finite() || (one_sided && !limit.is_nan());
            let coefficients = self.row[..n].iter().all(|a| a.is_finite());
            if !(coefficients && usable(lower) && (is_equality(group) || usable(upper))) {
                return false;
            }
            match treatment {
                Treatment::Cost => {
                    let s = self.stack_rows;
                    self.stack[s * n..(s + 1) * n].copy_from_slice(&self.row[..n]);
                    self.stack_b[s] = lower;
                    self.stack_w[s] = group.weight.now()[k] * group.alpha;
                    self.stack_rows += 1;
                }
                Treatment::Hard => {
                    // Tasks and equalities write one right-hand side, into the lower limit.
                    let upper = if is_equality(group) { lower } else { upper };
                    if let Some(row) = qp.push_row(group.rows[k], lower, upper) {
                        row.copy_from_slice(&self.row[..n]);
                    }
                }
                Treatment::Slack => {
                    let slack = self.live.slacks[index];
                    for (side, id) in [(-1.0, group.rows[2 * k]), (1.0, group.rows[2 * k + 1])] {
                        let limits = if side < 0.0 {
                            (f64::NEG_INFINITY, upper)
                        } else {
                            (lower, f64::INFINITY)
                        };
                        if let Some(row) = qp.push_row(id, limits.0, limits.1) {
                            row.copy_from_slice(&self.row[..n]);
                            if let Some(slack) = slack {
                                row[slack] = side;
                            }
                        }
                    }
                }
            }
        }
        if let (Treatment::Slack, Some(s)) = (treatment, self.live.slacks[index]) {
            let (h, g) = qp.cost_mut();
            h[s * n + s] += 2.0 * group.slack_weight();
            g[s] += group.slack_penalty();
        }
        true
    }

    /// Row `k` of a group over the packed variables, into `self.row`; returns `A_v c`.
    fn expand(&mut self, group: &Group, k: usize, terms: &DynamicsTerms<'_>, n: usize) -> f64 {
        let row = &mut self.row[..n];
        row.fill(0.0);
        let mut shift = 0.0;
        let nv = self.variables.nv;
        let explicit = self.live.vdot.is_some();
        let condensed = &self.condensed;
        let mut add_vdot = |row: &mut [f64], column: usize, a: f64| {
            if a == 0.0 {
                return;
            }
            if explicit {
                row[column] += a;
            } else {
                let (b, c) = condensed.response(column);
                for (r, b) in row.iter_mut().zip(b) {
                    *r += a * b;
                }
                shift += a * c;
            }
        };
        match &group.layout.vdot {
            VdotBlock::Absent => {}
            VdotBlock::Dense => {
                for (j, &a) in group.store.vdot[k * nv..(k + 1) * nv].iter().enumerate() {
                    add_vdot(row, j, a);
                }
            }
            VdotBlock::Unit(columns) => add_vdot(row, columns[k], 1.0),
            VdotBlock::Frame(frame, rows) => {
                for (j, column) in terms.frames[frame.0].J.column_iter().enumerate() {
                    add_vdot(row, j, column[rows[k]]);
                }
            }
            VdotBlock::Contact(contact, rows) => {
                let jacobian = &terms.contacts[contact.index()].J;
                for (j, column) in jacobian.column_iter().enumerate() {
                    add_vdot(row, j, column[rows[k]]);
                }
            }
        }
        let effort = self.live.effort;
        match &group.layout.effort {
            None => {}
            Some(Block::Dense) => {
                let nu = self.variables.nu;
                let source = &group.store.effort[k * nu..(k + 1) * nu];
                for (r, a) in row[effort..effort + nu].iter_mut().zip(source) {
                    *r += a;
                }
            }
            Some(Block::Unit(columns)) => row[effort + columns[k]] += 1.0,
        }
        for ((contact, block), source) in group.layout.forces.iter().zip(&group.store.forces) {
            let Some(start) = self.live.forces[contact.index()] else {
                continue;
            };
            let nf = self.variables.nf[contact.index()];
            match block {
                Block::Dense => {
                    let source = &source[k * nf..(k + 1) * nf];
                    for (r, a) in row[start..start + nf].iter_mut().zip(source) {
                        *r += a;
                    }
                }
                Block::Unit(columns) => row[start + columns[k]] += 1.0,
            }
        }
        shift
    }

    /// `H += 2 Σ w aᵀa` (upper triangle, then mirrored), `g −= 2 Σ w b aᵀ`.
    fn add_cost(&self, qp: &mut Qp) {
        let n = qp.n();
        let (h, g) = qp.cost_mut();
        for s in 0..self.stack_rows {
            let a = &self.stack[s * n..(s + 1) * n];
            let (w, b) = (2.0 * self.stack_w[s], self.stack_b[s]);
            for i in 0..n {
                let wa = w * a[i];
                if wa == 0.0 {
                    continue;
                }
                g[i] -= wa * b;
                for (h, a) in h[i * n + i..(i + 1) * n].iter_mut().zip(&a[i..]) {
                    *h += wa * a;
                }
            }
        }
        for i in 1..n {
            for j in 0..i {
                h[i * n + j] = h[j * n + i];
            }
        }
    }

    /// `w_ε ‖(u, f)‖²` with `w_ε` relative to the largest weight that is on.
    fn regularise(&mut self, groups: &[Group], qp: &mut Qp) {
        let on = groups.iter().filter(|g| g.stack_start.is_some());
        let largest = on.map(Group::largest_weight).fold(0.0, f64::max);
        self.largest_weight = if largest > 0.0 { largest } else { 1.0 };
        self.regularisation_weight = self.regularisation * self.largest_weight;
        let n = qp.n();
        let h = qp.h_mut();
        for i in self.live.effort..self.live.n_physical {
            h[i * n + i] += 2.0 * self.regularisation_weight;
        }
    }

    /// Intersects the bounds of all live groups and remembers whose are the tightest.
    fn add_bounds(
        &mut self,
        terms: &DynamicsTerms<'_>,
        groups: &[Group],
        qp: &mut Qp,
    ) -> Result<(), Fault> {
        let n = qp.n();
        self.bound_owner[..n].fill([None; 2]);
        let (lower, upper) = qp.bounds_mut();
        for slack in self.live.slacks.iter().flatten() {
            lower[*slack] = 0.0;
        }
        for (c, contact) in terms.contacts.iter().enumerate() {
            if let Some(start) = self.live.forces[c] {
                let p = start + contact.kind.normal();
                [lower[p], upper[p]] = contact.force_limits;
                self.bound_owner[p] = [Some(self.normal_rows[c]); 2];
            }
        }
        for (index, group) in groups.iter().enumerate().filter(|(_, g)| g.live) {
            for (b, (_, target)) in group.layout.bounds.iter().enumerate() {
                let Some(p) = self.position(*target).filter(|&p| p < n) else {
                    continue;
                };
                let (l, u) = (group.store.bound_lower[b], group.store.bound_upper[b]);
                if l.is_nan() || u.is_nan() {
                    return Err(Fault::Rows(index));
                }
                if l > lower[p] {
                    lower[p] = l;
                    self.bound_owner[p][0] = Some(group.bounds[b]);
                }
                if u < upper[p] {
                    upper[p] = u;
                    self.bound_owner[p][1] = Some(group.bounds[b]);
                }
            }
        }
        Ok(())
    }

    /// Where a bounded variable stands, if it is live.
    pub(super) fn position(&self, target: BoundTarget) -> Option<usize> {
        match target {
            BoundTarget::Effort(i) => Some(self.live.effort + i),
            BoundTarget::Force(contact, i) => {
                self.live.forces[contact.index()].map(|start| start + i)
            }
        }
    }

    /// `v̇` of a solution.
    pub(crate) fn vdot(&self, x: &[f64], out: &mut nalgebra::DVector<f64>) {
        for i in 0..self.variables.nv {
            out[i] = if let Some(start) = self.live.vdot {
                x[start + i]
            } else {
                let (b, c) = self.condensed.response(i);
                let mut sum = c;
                for (b, x) in b.iter().zip(x) {
                    sum += b * x;
                }
                sum
            };
        }
    }

    /// The efforts of a solution.
    pub(crate) fn effort<'x>(&self, x: &'x [f64]) -> &'x [f64] {
        &x[self.live.effort..self.live.effort + self.variables.nu]
    }

    /// The force components of a live contact.
    pub(crate) fn force<'x>(&self, x: &'x [f64], contact: usize) -> Option<&'x [f64]> {
        let start = self.live.forces[contact]?;
        Some(&x[start..start + self.variables.nf[contact]])
    }

    /// `Σ w r²` over the cost rows, plus slacks and regularisation.
    pub(crate) fn objective(&self, groups: &[Group], x: &[f64]) -> f64 {
        let n = self.live.vars.len();
        let mut sum = 0.0;
        for s in 0..self.stack_rows {
            let a = &self.stack[s * n..(s + 1) * n];
            let ax: f64 = a.iter().zip(x).map(|(a, x)| a * x).sum();
            sum += self.stack_w[s] * (ax - self.stack_b[s]).powi(2);
        }
        for x in &x[self.live.effort..self.live.n_physical] {
            sum += self.regularisation_weight * x * x;
        }
        for (group, slack) in groups.iter().zip(&self.live.slacks) {
            if let Some(slack) = slack {
                let s = x[*slack];
                sum += group.slack_weight() * s * s + group.slack_penalty() * s;
            }
        }
        sum
    }

    /// Residual `a x − b` and weight of a group's row `k`, if the group is a cost this tick.
    pub(crate) fn residual(&self, group: &Group, k: usize, x: &[f64]) -> Option<(f64, f64)> {
        let s = group.stack_start? + k;
        let n = self.live.vars.len();
        let a = &self.stack[s * n..(s + 1) * n];
        let ax: f64 = a.iter().zip(x).map(|(a, x)| a * x).sum();
        Some((ax - self.stack_b[s], self.stack_w[s]))
    }
}

/// Whether the rows have one right-hand side.
pub(crate) fn is_equality(group: &Group) -> bool {
    group.is_task || group.layout.relation == Relation::Equality
}
