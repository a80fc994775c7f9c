//! The coefficients of a group's row over the natural variables, and over those of the problem.
//!
//! # Mathematics
//! A row is `A_v v̇ + A_u u + Σ A_c f_c` over accelerations, efforts and forces. In y it is the same, but for eliminated
//! efforts, `a τ = a (T y + t)`; in x the part on `v̇_P` is `a_P (B x + c)` in addition. What is constant, `a t` and `a_P c`,
//! goes to the limits.

use super::{DynamicsTerms, Group, Live, Partition, Relations, partition::EffortPlace};
use crate::layout::{Block, Layout, VdotBlock};

/// Everything that a row is expanded with.
#[derive(Clone, Copy)]
pub(crate) struct Context<'a> {
    pub(crate) partition: &'a Partition,
    pub(crate) relations: &'a Relations,
    pub(crate) live: &'a Live,
    pub(crate) terms: DynamicsTerms<'a>,
}

/// What a coefficient belongs to.
#[derive(Clone, Copy)]
pub(crate) enum Place {
    /// A natural variable.
    Column(usize),
    /// An eliminated effort.
    Torque(usize),
}

impl Context<'_> {
    /// Hands out the coefficients of a group's row.
    pub(crate) fn coefficients(&self, group: &Group, k: usize, mut add: impl FnMut(Place, f64)) {
        let Self {
            partition,
            live,
            terms,
            ..
        } = self;
        let columns = &partition.columns;
        match &group.layout.vdot {
            VdotBlock::Absent => {}
            VdotBlock::Dense => {
                let nv = partition.nv;
                let row = &group.store.vdot[k * nv..(k + 1) * nv];
                for (&column, &a) in columns.iter().zip(row) {
                    add(Place::Column(column), a);
                }
            }
            VdotBlock::Unit(velocities) => add(Place::Column(columns[velocities[k]]), 1.0),
            VdotBlock::Frame(frame, rows) => {
                let jacobian = &terms.frames[frame.0].J;
                for at in &partition.frames[frame.0] {
                    add(Place::Column(at.column), jacobian[(rows[k], at.velocity)]);
                }
            }
            VdotBlock::Contact(contact, rows) => {
                let jacobian = &terms.contacts[contact.index()].J;
                for at in &partition.contacts[contact.index()] {
                    add(Place::Column(at.column), jacobian[(rows[k], at.velocity)]);
                }
            }
        }
        match &group.layout.effort {
            None => {}
            Some(Block::Dense) => {
                let nu = partition.efforts.len();
                let row = &group.store.effort[k * nu..(k + 1) * nu];
                for (actuator, &a) in row.iter().enumerate() {
                    if a != 0.0 {
                        add(self.effort(actuator), a);
                    }
                }
            }
            Some(Block::Unit(actuators)) => add(self.effort(actuators[k]), 1.0),
        }
        for ((contact, block), source) in group.layout.forces.iter().zip(&group.store.forces) {
            let Some(start) = live.forces[contact.index()] else {
                continue;
            };
            let nf = partition.nf[contact.index()];
            match block {
                Block::Dense => {
                    for (i, &a) in source[k * nf..(k + 1) * nf].iter().enumerate() {
                        add(Place::Column(start + i), a);
                    }
                }
                Block::Unit(columns) => add(Place::Column(start + columns[k]), 1.0),
            }
        }
    }

    /// Where an actuator's effort is.
    pub(crate) fn effort(&self, actuator: usize) -> Place {
        match self.partition.efforts[actuator] {
            EffortPlace::Kept(column) => Place::Column(column),
            EffortPlace::Eliminated(torque) => Place::Torque(torque),
        }
    }

    /// Writes a group's row over y into `row` (zeroed); returns the constant part.
    pub(crate) fn natural_row(&self, group: &Group, k: usize, row: &mut [f64]) -> f64 {
        let mut constant = 0.0;
        self.coefficients(group, k, |place, a| match place {
            Place::Column(column) => row[column] += a,
            Place::Torque(index) => {
                let (torque, known) = self.relations.torque(index);
                for (row, t) in row.iter_mut().zip(torque) {
                    *row += a * t;
                }
                constant += a * known;
            }
        });
        constant
    }

    /// Turns a row over y, whose first part is on `v̇_P`, into one over x, in place of the rest; returns what the constant
    /// part grows by.
    pub(crate) fn substitute(&self, row: &mut [f64]) -> f64 {
        let (head, tail) = row.split_at_mut(self.partition.substituted);
        if head.iter().all(|a| *a == 0.0) {
            return 0.0;
        }
        self.relations.substitute(head, tail)
    }
}

/// Whether a row's dense coefficients, which the plug-in wrote, are all finite.
pub(crate) fn is_finite(group: &Group, partition: &Partition, k: usize) -> bool {
    let Layout {
        vdot,
        effort,
        forces,
        ..
    } = &group.layout;
    let row = |data: &[f64], n: usize| data[k * n..(k + 1) * n].iter().all(|a| a.is_finite());
    let vdot = !matches!(vdot, VdotBlock::Dense) || row(&group.store.vdot, partition.nv);
    let effort =
        !matches!(effort, Some(Block::Dense)) || row(&group.store.effort, partition.efforts.len());
    vdot && effort
        && forces
            .iter()
            .zip(&group.store.forces)
            .all(|((contact, block), data)| {
                !matches!(block, Block::Dense) || row(data, partition.nf[contact.index()])
            })
}
