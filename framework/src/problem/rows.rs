//! The rows of the entries over the natural variables of this tick.
//!
//! # Mathematics
//! A row is `A_v v̇ + A_u u + Σ A_c f_c` over accelerations, efforts and forces. Over the natural variables y
//! ([`Partition`]) it is the same, but for eliminated efforts, `a τ = a (T y + t)`, and accelerations
//! that contacts determine, `a v̇_D = a (G v̇_S + g)`. What does not depend on y, `a t` and `a g`, is the row's
//! constant.
//!
//! A row that is one component of v̇, u or a force is kept as that ([`Single`]); others are written out where they are
//! not zero. Cost, constraints and residuals come from here; hard rows of contacts that [are
//! eliminated](super::contact_elimination) alone do not.

use super::{
    ActiveVariables, BoundEntry, ContactElimination, DynamicsTerms, NaturalCost, Partition,
    ReducedDynamics, SparsityPattern,
    hessian::{BLOCK, Slots},
    solution::Solved,
    variables::{EffortPlace, Place},
};
use crate::plugin::{
    Layout,
    layout::{Block, VdotBlock},
    rows::{MotionMatrix, Variable},
};

/// What rows are expanded with.
#[derive(Clone, Copy)]
pub(super) struct Context<'a> {
    pub(super) partition: &'a Partition,
    pub(super) elimination: &'a ContactElimination,
    pub(super) reduced: &'a ReducedDynamics,
    pub(super) active: &'a ActiveVariables,
    pub(super) terms: DynamicsTerms<'a>,
}

impl Context<'_> {
    /// Turns a row over y, whose first part is on `v̇_P`, into one over x, in place of the rest; returns what the
    /// constant part grows by.
    pub(super) fn substitute(&self, row: &mut [f64]) -> f64 {
        let (head, tail) = row.split_at_mut(self.partition.substituted);
        if head.iter().all(|a| *a == 0.0) {
            return 0.0;
        }
        self.reduced.substitute(head, tail)
    }

    /// Adds `a τ` of an eliminated effort to a row over y; returns its constant.
    fn add_torque(&self, torque: usize, a: f64, row: &mut [f64]) -> f64 {
        let (torque, known) = self.reduced.torque(torque);
        for (row, t) in row.iter_mut().zip(torque) {
            *row += a * t;
        }
        a * known
    }

    /// Adds `a v̇_D`, of a joint whose acceleration a contact determines, to a row over y; returns its constant.
    fn add_determined(&self, elimination: usize, joint: usize, a: f64, row: &mut [f64]) -> f64 {
        let contact = self.elimination.get(elimination);
        let (relation, known) = contact.row(joint);
        for (g, &velocity) in relation.iter().zip(&contact.others) {
            if let Place::Column(column) = self.partition.places[velocity] {
                row[column] += a * g;
            }
        }
        a * known
    }
}

/// Where a row that is one component is.
#[derive(Clone, Copy, Debug)]
pub(super) enum Single {
    /// A natural variable.
    Column(usize),
    /// An eliminated effort: which, and of which actuator.
    Torque { torque: usize, actuator: usize },
    /// An acceleration that a contact determines: by this elimination, as this one of its joints.
    Determined {
        velocity: usize,
        elimination: usize,
        joint: usize,
    },
    /// A force of a contact that is off: zero.
    Nothing,
}

/// How the rows of an entry are expanded: by its layout, once and for all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Each is one component.
    Single,
    /// On accelerations alone.
    Motion,
    /// On the forces of contacts alone.
    Forces,
    /// Anything else. (An entry without rows counts as on forces.)
    Mixed,
}

/// The rows of an entry in storage made once.
#[derive(Clone, Debug)]
pub(super) struct NaturalRows {
    pub(super) kind: Kind,
    pub(super) count: usize,
    pub(super) singles: Vec<Single>,
    /// Natural variables with coefficients other than zero, ascending.
    pub(super) columns: Vec<usize>,
    /// Their coefficients, see [`Slots`]; of rows on forces alone row by row.
    pub(super) values: Vec<f64>,
    /// Rows over all natural variables.
    pub(super) dense: Vec<f64>,
    /// What does not depend on the variables.
    pub(super) constants: Vec<f64>,
}

impl NaturalRows {
    /// Finds where the rows are, after variables have come or gone.
    pub(super) fn arrange(&mut self, layout: &Layout, context: &Context<'_>) {
        match self.kind {
            Kind::Single => self.place(layout, context),
            Kind::Motion => {
                self.columns.clear();
                self.columns
                    .extend(&pattern(layout, context.partition).columns);
            }
            Kind::Forces => self.find_forces(layout, context),
            Kind::Mixed => {}
        }
    }

    /// Takes what the plug-in wrote in this tick.
    pub(super) fn expand(&mut self, entry: &BoundEntry, context: &Context<'_>) {
        match self.kind {
            Kind::Single => {}
            Kind::Motion => self.expand_motion(entry, context),
            Kind::Forces => self.expand_forces(entry, context),
            Kind::Mixed => self.expand_mixed(entry, context),
        }
    }

    fn place(&mut self, layout: &Layout, context: &Context<'_>) {
        let Context {
            partition, active, ..
        } = context;
        self.singles.clear();
        match (&layout.vdot, &layout.effort, layout.forces.as_slice()) {
            (VdotBlock::Unit(velocities), ..) => {
                self.singles
                    .extend(velocities.iter().map(|&v| match partition.places[v] {
                        Place::Column(column) => Single::Column(column),
                        Place::Determined(elimination, joint) => Single::Determined {
                            velocity: v,
                            elimination,
                            joint,
                        },
                    }));
            }
            (_, Some(Block::Unit(actuators)), _) => {
                self.singles
                    .extend(actuators.iter().map(|&u| match partition.efforts[u] {
                        EffortPlace::Kept(index) => Single::Column(partition.accelerations + index),
                        EffortPlace::Eliminated(torque) => Single::Torque {
                            torque,
                            actuator: u,
                        },
                    }));
            }
            (.., [(contact, Block::Unit(components))]) => {
                let start = active.forces[contact.index()];
                self.singles.extend(components.iter().map(|component| {
                    start.map_or(Single::Nothing, |start| Single::Column(start + component))
                }));
            }
            _ => {}
        }
    }

    fn expand_motion(&mut self, entry: &BoundEntry, context: &Context<'_>) {
        let DynamicsTerms {
            frames, contacts, ..
        } = context.terms;
        let Some(matrix) = entry.store.motion_matrix(&entry.layout, frames, contacts) else {
            return;
        };
        let pattern = pattern(&entry.layout, context.partition);
        let width = self.columns.len();
        self.values.resize(self.count * width, 0.0);
        if pattern.determined.is_empty() {
            self.constants.fill(0.0);
            for k in 0..self.count {
                let slots = Slots::of_row(k, self.count, width);
                for (position, at) in pattern.coordinates.iter().enumerate() {
                    self.values[slots.at(position)] = matrix.get(k, at.velocity);
                }
            }
        } else {
            self.expand_determined(&matrix, pattern, context.elimination);
        }
    }

    /// Rows on accelerations of which contacts determine some.
    fn expand_determined(
        &mut self,
        matrix: &MotionMatrix<'_>,
        pattern: &SparsityPattern,
        elimination: &ContactElimination,
    ) {
        let width = self.columns.len();
        self.values.fill(0.0);
        for (k, constant) in self.constants.iter_mut().enumerate() {
            let slots = Slots::of_row(k, self.count, width);
            let values = &mut self.values;
            for at in &pattern.coordinates {
                values[slots.at(at.position)] = matrix.get(k, at.velocity);
            }
            *constant = 0.0;
            for at in &pattern.determined {
                let (relation, known) = elimination.get(at.motion).row(at.row);
                let a = matrix.get(k, at.velocity);
                for (&position, g) in pattern.positions[at.motion].iter().zip(relation) {
                    values[slots.at(position)] += a * g;
                }
                *constant += a * known;
            }
        }
    }

    fn find_forces(&mut self, layout: &Layout, context: &Context<'_>) {
        self.columns.clear();
        for (contact, _) in &layout.forces {
            if let Some(start) = context.active.forces[contact.index()] {
                let nf = context.partition.nf[contact.index()];
                self.columns.extend(start..start + nf);
            }
        }
    }

    fn expand_forces(&mut self, entry: &BoundEntry, context: &Context<'_>) {
        let (layout, store) = (&entry.layout, &entry.store);
        let (partition, active) = (context.partition, context.active);
        let width = self.columns.len();
        self.values.resize(self.count * width, 0.0);
        if width == 0 {
            return;
        }
        let mut first = 0;
        for ((contact, block), source) in layout.forces.iter().zip(&store.forces) {
            if active.forces[contact.index()].is_none() {
                continue;
            }
            let nf = partition.nf[contact.index()];
            for (k, row) in self.values.chunks_exact_mut(width).enumerate() {
                let row = &mut row[first..first + nf];
                match block {
                    Block::Dense => row.copy_from_slice(&source[k * nf..(k + 1) * nf]),
                    Block::Unit(components) => {
                        row.fill(0.0);
                        row[components[k]] = 1.0;
                    }
                }
            }
            first += nf;
        }
    }

    fn expand_mixed(&mut self, entry: &BoundEntry, context: &Context<'_>) {
        let (partition, active) = (context.partition, context.active);
        let DynamicsTerms {
            frames, contacts, ..
        } = context.terms;
        let store = &entry.store;
        let n = active.n_physical;
        self.dense[..self.count * n].fill(0.0);
        for k in 0..self.count {
            let row = &mut self.dense[k * n..(k + 1) * n];
            let mut constant = 0.0;
            store.for_each_coefficient(&entry.layout, k, frames, contacts, |variable, a| {
                match variable {
                    Variable::Acceleration(velocity) => match partition.places[velocity] {
                        Place::Column(column) => row[column] += a,
                        Place::Determined(elimination, joint) => {
                            constant += context.add_determined(elimination, joint, a, row);
                        }
                    },
                    Variable::Effort(actuator) => match partition.efforts[actuator] {
                        EffortPlace::Kept(index) => row[partition.accelerations + index] += a,
                        EffortPlace::Eliminated(torque) => {
                            constant += context.add_torque(torque, a, row);
                        }
                    },
                    Variable::Force(contact, component) => {
                        if let Some(start) = active.forces[contact.index()] {
                            row[start + component] += a;
                        }
                    }
                }
            });
            self.constants[k] = constant;
        }
        self.drop_zero_columns(n);
    }

    /// Keeps the columns of `n` in which a row is not zero.
    fn drop_zero_columns(&mut self, n: usize) {
        let (dense, count) = (&self.dense, self.count);
        let is_there = |column: usize| (0..count).any(|k| dense[k * n + column] != 0.0);
        self.columns.clear();
        self.columns
            .extend((0..n).filter(|&column| is_there(column)));
        let width = self.columns.len();
        self.values.clear();
        self.values.resize(count * width, 0.0);
        for k in 0..count {
            let slots = Slots::of_row(k, count, width);
            for (i, &column) in self.columns.iter().enumerate() {
                self.values[slots.at(i)] = dense[k * n + column];
            }
        }
    }

    /// Adds `Σ w_k (row_k − b_k)²` to the cost.
    pub(super) fn add_cost(&self, entry: &BoundEntry, cost: &mut NaturalCost) {
        let (weights, alpha) = (entry.weight.now(), entry.alpha);
        let weight = |k: usize| weights[k] * alpha;
        let b = &entry.store.lower;
        match self.kind {
            Kind::Single => {
                for (k, single) in self.singles.iter().enumerate() {
                    match *single {
                        Single::Column(column) => cost.add_unit(column, weight(k), b[k]),
                        Single::Torque { torque, .. } => cost.add_torque(torque, weight(k), b[k]),
                        Single::Determined {
                            elimination, joint, ..
                        } => cost.add_determined(elimination, joint, weight(k), b[k]),
                        Single::Nothing => {}
                    }
                }
            }
            kind => {
                let weights = |k: usize| {
                    let quadratic = 2.0 * weight(k);
                    (quadratic, -quadratic * (b[k] - self.constants[k]))
                };
                if kind == Kind::Forces {
                    cost.add_plain_rows(&self.columns, &self.values, self.count, weights);
                } else {
                    cost.add_rows(&self.columns, &self.values, self.count, weights);
                }
            }
        }
    }

    /// Columns and coefficients of row `k`, which is written out.
    fn written(&self, k: usize) -> impl Iterator<Item = (usize, f64)> {
        let width = self.columns.len();
        let slots = match self.kind {
            Kind::Forces => Slots::of_plain_row(k, width),
            _ => Slots::of_row(k, self.count, width),
        };
        let columns = self.columns.iter().enumerate();
        columns.map(move |(i, &column)| (column, self.values[slots.at(i)]))
    }

    /// Writes row `k` straight into a row of zeros over x, behind `p` substituted accelerations, if [it is
    /// one](Self::is_over_x).
    pub(super) fn write_over_x(&self, k: usize, p: usize, row: &mut [f64]) {
        let width = self.columns.len();
        let values = &self.values[k * width..(k + 1) * width];
        for (&column, a) in self.columns.iter().zip(values) {
            row[column - p] = *a;
        }
    }

    /// Whether the rows are on forces alone, which are variables of the problem as they are.
    pub(super) fn is_over_x(&self) -> bool {
        self.kind == Kind::Forces
    }

    /// Adds row `k` over y to `row`; returns its constant.
    pub(super) fn write(&self, k: usize, row: &mut [f64], context: &Context<'_>) -> f64 {
        if self.kind != Kind::Single {
            for (column, a) in self.written(k) {
                row[column] += a;
            }
            return self.constants[k];
        }
        match self.singles[k] {
            Single::Column(column) => {
                row[column] += 1.0;
                0.0
            }
            Single::Torque { torque, .. } => context.add_torque(torque, 1.0, row),
            Single::Determined {
                elimination, joint, ..
            } => context.add_determined(elimination, joint, 1.0, row),
            Single::Nothing => 0.0,
        }
    }

    /// Writes the values of all rows at a solution into `out`, which is zero.
    pub(super) fn evaluate(&self, solved: &Solved, out: &mut [f64]) {
        match self.kind {
            Kind::Single => {
                for (out, single) in out.iter_mut().zip(&self.singles) {
                    *out = match *single {
                        Single::Column(column) => solved.y[column],
                        Single::Torque { actuator, .. } => solved.effort[actuator],
                        Single::Determined { velocity, .. } => solved.vdot[velocity],
                        Single::Nothing => 0.0,
                    };
                }
            }
            Kind::Forces => {
                for (k, out) in out.iter_mut().enumerate() {
                    let terms = self.written(k).map(|(column, a)| a * solved.y[column]);
                    *out = terms.sum();
                }
            }
            Kind::Motion | Kind::Mixed => {
                let width = self.columns.len();
                let blocks = out
                    .chunks_mut(BLOCK)
                    .zip(self.values.chunks(width.max(1) * BLOCK));
                for (out, values) in blocks {
                    let rows = values.chunks_exact(out.len());
                    for (&column, values) in self.columns.iter().zip(rows) {
                        let y = solved.y[column];
                        for (out, a) in out.iter_mut().zip(values) {
                            *out += a * y;
                        }
                    }
                }
                for (out, constant) in out.iter_mut().zip(&self.constants) {
                    *out += constant;
                }
            }
        }
    }
}

/// The accelerations that rows on accelerations alone may have coefficients on.
fn pattern<'p>(layout: &Layout, partition: &'p Partition) -> &'p SparsityPattern {
    match &layout.vdot {
        VdotBlock::Frame(frame, _) => &partition.frames[frame.0],
        VdotBlock::Contact(contact, _) => &partition.contacts[contact.index()],
        VdotBlock::Dense | VdotBlock::Unit(_) | VdotBlock::Absent => &partition.all,
    }
}
