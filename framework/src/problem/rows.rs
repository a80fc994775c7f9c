//! The rows of the entries over the natural variables of this tick.
//!
//! # Mathematics
//! A row is `A_v v̇ + A_u u + Σ A_c f_c` over accelerations, efforts and forces. Over the natural variables y
//! ([`Partition`]) it is the same, but for eliminated efforts, `a τ = a (T y + t)`, and accelerations
//! that contacts determine, `a v̇_D = a (G v̇_S + g)`. What does not depend on y, `a t` and `a g`, is the row's
//! constant.
//!
//! A row that is one component of v̇, u or a force is kept as that ([`Variable`]); others are written out where they
//! are not zero. Cost, constraints and residuals come from here; hard rows of contacts that [are
//! eliminated](super::contact_elimination) alone do not.

use super::{
    ActiveVariables, BoundEntry, DynamicsTerms, NaturalCost, Partition, ReducedDynamics,
    hessian::{BLOCK, Slots},
    linear_algebra::add_row,
    partition::{EffortPlace, Place, SparsityPattern},
    solution::Solved,
};
use crate::plugin::{Layout, layout::VdotBlock, storage::Variable};

/// What rows are expanded with.
#[derive(Clone, Copy)]
pub(super) struct Context<'a> {
    pub(super) partition: &'a Partition,
    pub(super) reduced: &'a ReducedDynamics,
    pub(super) active: &'a ActiveVariables,
}

impl Context<'_> {
    /// Adds a coefficient to a row over y; returns what it adds to the row's constant.
    fn add(&self, variable: Variable, a: f64, row: &mut [f64]) -> f64 {
        let partition = self.partition;
        match variable {
            Variable::Acceleration(velocity) => match partition.places[velocity] {
                Place::Column(column) => row[column] += a,
                Place::Determined(elimination, joint) => {
                    let contact = partition.elimination.get(elimination);
                    let (relation, known) = contact.row(joint);
                    for (g, &other) in relation.iter().zip(&contact.others) {
                        if let Place::Column(column) = partition.places[other] {
                            row[column] += a * g;
                        }
                    }
                    return a * known;
                }
            },
            Variable::Effort(actuator) => match partition.efforts[actuator] {
                EffortPlace::Kept(index) => row[partition.accelerations + index] += a,
                EffortPlace::Eliminated(torque) => {
                    let (torque, known) = self.reduced.torque(torque);
                    add_row(&mut row[..torque.len()], a, torque);
                    return a * known;
                }
            },
            Variable::Force(contact, component) => {
                if let Some(start) = self.active.forces[contact.index()] {
                    row[start + component] += a;
                }
            }
        }
        0.0
    }
}

/// How the rows of an entry are expanded: by its layout, once and for all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Each is one component.
    Single,
    /// On accelerations alone.
    Motion,
    /// Inequalities on the forces of contacts alone: no cost, and variables of the problem as they are.
    Forces,
    /// Anything else.
    Mixed,
}

/// The rows of an entry in storage made once.
#[derive(Clone, Debug)]
pub(super) struct NaturalRows {
    pub(super) kind: Kind,
    pub(super) count: usize,
    /// Whether they have been expanded, and whether they are a cost, this tick.
    pub(super) is_expanded: bool,
    pub(super) is_cost: bool,
    /// Whether they have coefficients on accelerations and others.
    pub(super) couples: bool,
    /// What each row is, if it is one component; fixed.
    pub(super) singles: Vec<Variable>,
    /// Natural variables with coefficients other than zero, ascending.
    pub(super) columns: Vec<usize>,
    /// Their coefficients, see [`Slots`].
    pub(super) values: Vec<f64>,
    /// Rows over all natural variables.
    pub(super) dense: Vec<f64>,
    /// What does not depend on the variables.
    pub(super) constants: Vec<f64>,
}

impl NaturalRows {
    /// Finds where the rows are, after variables have come or gone.
    pub(super) fn arrange(&mut self, layout: &Layout, partition: &Partition) {
        if self.kind == Kind::Motion {
            self.columns.clear();
            self.columns.extend(&pattern(layout, partition).columns);
        }
    }

    /// Takes what the plug-in wrote in this tick.
    pub(super) fn expand(
        &mut self,
        entry: &BoundEntry,
        context: &Context<'_>,
        terms: &DynamicsTerms<'_>,
    ) {
        match self.kind {
            Kind::Single | Kind::Forces => {}
            Kind::Motion => self.expand_motion(entry, context.partition, terms),
            Kind::Mixed => self.expand_mixed(entry, context, terms),
        }
    }

    fn expand_motion(
        &mut self,
        entry: &BoundEntry,
        partition: &Partition,
        terms: &DynamicsTerms<'_>,
    ) {
        let (layout, store) = (&entry.layout, &entry.store);
        let Some(matrix) = store.motion_matrix(layout, terms.frames, terms.contacts) else {
            return;
        };
        let pattern = pattern(layout, partition);
        let width = self.columns.len();
        self.values.resize(self.count * width, 0.0);
        if !pattern.determined.is_empty() {
            self.values.fill(0.0);
        }
        self.constants.fill(0.0);
        for (block, constants) in self.constants.chunks_mut(BLOCK).enumerate() {
            let (first, rows) = (block * BLOCK, constants.len());
            let values = &mut self.values[first * width..][..rows * width];
            for at in &pattern.coordinates {
                matrix.read(
                    first,
                    at.velocity,
                    &mut values[at.position * rows..][..rows],
                );
            }
            for at in &pattern.determined {
                let (relation, known) = partition.elimination.get(at.motion).row(at.row);
                let mut a = [0.0; BLOCK];
                matrix.read(first, at.velocity, &mut a[..rows]);
                for (&position, g) in pattern.positions[at.motion].iter().zip(relation) {
                    add_row(&mut values[position * rows..][..rows], *g, &a);
                }
                add_row(constants, known, &a);
            }
        }
    }

    fn expand_mixed(
        &mut self,
        entry: &BoundEntry,
        context: &Context<'_>,
        terms: &DynamicsTerms<'_>,
    ) {
        let (frames, contacts) = (terms.frames, terms.contacts);
        let store = &entry.store;
        let n = context.active.n_physical;
        self.dense[..self.count * n].fill(0.0);
        for k in 0..self.count {
            let row = &mut self.dense[k * n..(k + 1) * n];
            let mut constant = 0.0;
            store.for_each_coefficient(&entry.layout, k, frames, contacts, |variable, a| {
                constant += context.add(variable, a, row);
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
    pub(super) fn add_cost(
        &self,
        entry: &BoundEntry,
        context: &Context<'_>,
        cost: &mut NaturalCost,
    ) {
        let (weights, alpha) = (entry.weight.now(), entry.alpha);
        let b = &entry.store.lower;
        if self.kind == Kind::Single {
            for (k, &single) in self.singles.iter().enumerate() {
                cost.add_single(single, weights[k] * alpha, b[k], context);
            }
            return;
        }
        cost.is_coupled |= self.couples;
        cost.add_rows(&self.columns, &self.values, self.count, |k| {
            let quadratic = 2.0 * (weights[k] * alpha);
            (quadratic, -quadratic * (b[k] - self.constants[k]))
        });
    }

    /// Columns and coefficients of row `k`, which is written out.
    fn written(&self, k: usize) -> impl Iterator<Item = (usize, f64)> {
        let width = self.columns.len();
        let slots = Slots::of_row(k, self.count, width);
        let columns = self.columns.iter().enumerate();
        columns.map(move |(i, &column)| (column, self.values[slots.at(i)]))
    }

    /// Adds row `k` over y to `row`; returns its constant.
    pub(super) fn write(&self, k: usize, row: &mut [f64], context: &Context<'_>) -> f64 {
        if let Some(&single) = self.singles.get(k) {
            return context.add(single, 1.0, row);
        }
        for (column, a) in self.written(k) {
            row[column] += a;
        }
        self.constants[k]
    }

    /// Writes the values of all rows at a solution into `out`, which is zero.
    pub(super) fn evaluate(&self, solved: &Solved, active: &ActiveVariables, out: &mut [f64]) {
        for (out, single) in out.iter_mut().zip(&self.singles) {
            *out = match *single {
                Variable::Acceleration(velocity) => solved.vdot[velocity],
                Variable::Effort(actuator) => solved.effort[actuator],
                Variable::Force(contact, component) => {
                    let start = active.forces[contact.index()];
                    start.map_or(0.0, |start| solved.y[start + component])
                }
            };
        }
        let blocks = self.values.chunks((self.columns.len() * BLOCK).max(1));
        for (out, values) in out.chunks_mut(BLOCK).zip(blocks) {
            let rows = values.chunks_exact(out.len());
            for (&column, values) in self.columns.iter().zip(rows) {
                add_row(out, solved.y[column], values);
            }
        }
        for (out, constant) in out.iter_mut().zip(&self.constants) {
            *out += constant;
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
