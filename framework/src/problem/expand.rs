//! The coefficients of a entry's row over the natural variables, and over those of the problem.
//!
//! # Mathematics
//! A row is `A_v v̇ + A_u u + Σ A_c f_c` over accelerations, efforts and forces. In y it is the same, but for
//! eliminated efforts, `a τ = a (T y + t)`, and accelerations that contacts determine, `a v̇_D = a (G v̇_S + g)`; in x
//! the part on `v̇_P` is `a_P (B x + c)` in addition. What is constant, `a t`, `a g` and `a_P c`, goes to the limits.

use super::{
    ActiveVariables, BoundEntry, ContactElimination, DynamicsTerms, Partition, ReducedDynamics,
    partition::{EffortPlace, Place},
};
use crate::plugin::{
    Layout,
    layout::{Block, VdotBlock},
};

/// Everything that a row is expanded with.
#[derive(Clone, Copy)]
pub(crate) struct Context<'a> {
    pub(crate) partition: &'a Partition,
    pub(crate) motions: &'a ContactElimination,
    pub(crate) reduced: &'a ReducedDynamics,
    pub(crate) live: &'a ActiveVariables,
    pub(crate) terms: DynamicsTerms<'a>,
}

/// What a coefficient belongs to.
#[derive(Clone, Copy)]
pub(crate) enum Target {
    /// A natural variable.
    Column(usize),
    /// An eliminated effort.
    Torque(usize),
    /// An acceleration that is determined by this motion of a contact, as this one of its joints.
    Determined(usize, usize),
}

impl Context<'_> {
    /// Hands out the coefficients of a entry's row.
    pub(crate) fn coefficients(
        &self,
        entry: &BoundEntry,
        k: usize,
        mut add: impl FnMut(Target, f64),
    ) {
        let Self {
            partition,
            live,
            terms,
            ..
        } = self;
        let target = |velocity: usize| match partition.places[velocity] {
            Place::Column(column) => Target::Column(column),
            Place::Determined(motion, row) => Target::Determined(motion, row),
        };
        match &entry.layout.vdot {
            VdotBlock::Absent => {}
            VdotBlock::Dense => {
                let nv = partition.nv;
                let row = &entry.store.vdot[k * nv..(k + 1) * nv];
                for (velocity, &a) in row.iter().enumerate() {
                    add(target(velocity), a);
                }
            }
            VdotBlock::Unit(velocities) => add(target(velocities[k]), 1.0),
            VdotBlock::Frame(frame, rows) => {
                let jacobian = &terms.frames[frame.0].J;
                for &velocity in &partition.frames[frame.0].velocities {
                    add(target(velocity), jacobian[(rows[k], velocity)]);
                }
            }
            VdotBlock::Contact(contact, rows) => {
                let jacobian = &terms.contacts[contact.index()].J;
                for &velocity in &partition.contacts[contact.index()].velocities {
                    add(target(velocity), jacobian[(rows[k], velocity)]);
                }
            }
        }
        match &entry.layout.effort {
            None => {}
            Some(Block::Dense) => {
                let nu = partition.efforts.len();
                let row = &entry.store.effort[k * nu..(k + 1) * nu];
                for (actuator, &a) in row.iter().enumerate() {
                    if a != 0.0 {
                        add(self.effort(actuator), a);
                    }
                }
            }
            Some(Block::Unit(actuators)) => add(self.effort(actuators[k]), 1.0),
        }
        for ((contact, block), source) in entry.layout.forces.iter().zip(&entry.store.forces) {
            let Some(start) = live.forces[contact.index()] else {
                continue;
            };
            let nf = partition.nf[contact.index()];
            match block {
                Block::Dense => {
                    for (i, &a) in source[k * nf..(k + 1) * nf].iter().enumerate() {
                        add(Target::Column(start + i), a);
                    }
                }
                Block::Unit(columns) => add(Target::Column(start + columns[k]), 1.0),
            }
        }
    }

    /// Where an actuator's effort is.
    pub(crate) fn effort(&self, actuator: usize) -> Target {
        match self.partition.efforts[actuator] {
            EffortPlace::Kept(index) => Target::Column(self.partition.accelerations + index),
            EffortPlace::Eliminated(torque) => Target::Torque(torque),
        }
    }

    /// Writes a entry's row over y into `row` (zeroed); returns the constant part.
    pub(crate) fn natural_row(&self, entry: &BoundEntry, k: usize, row: &mut [f64]) -> f64 {
        let mut constant = 0.0;
        self.coefficients(entry, k, |target, a| match target {
            Target::Column(column) => row[column] += a,
            Target::Determined(motion, index) => {
                let motion = self.motions.get(motion);
                let (relation, known) = motion.row(index);
                for (g, &velocity) in relation.iter().zip(&motion.others) {
                    if let Place::Column(column) = self.partition.places[velocity] {
                        row[column] += a * g;
                    }
                }
                constant += a * known;
            }
            Target::Torque(index) => {
                let (torque, known) = self.reduced.torque(index);
                for (row, t) in row.iter_mut().zip(torque) {
                    *row += a * t;
                }
                constant += a * known;
            }
        });
        constant
    }

    /// Turns a row over y, whose first part is on `v̇_P`, into one over x, in place of the rest; returns what the
    /// constant part grows by.
    pub(crate) fn substitute(&self, row: &mut [f64]) -> f64 {
        let (head, tail) = row.split_at_mut(self.partition.substituted);
        if head.iter().all(|a| *a == 0.0) {
            return 0.0;
        }
        self.reduced.substitute(head, tail)
    }
}

/// Whether a row's dense coefficients, which the plug-in wrote, are all finite.
pub(crate) fn is_finite(entry: &BoundEntry, partition: &Partition, k: usize) -> bool {
    let Layout {
        vdot,
        effort,
        forces,
        ..
    } = &entry.layout;
    let row = |data: &[f64], n: usize| data[k * n..(k + 1) * n].iter().all(|a| a.is_finite());
    let vdot = !matches!(vdot, VdotBlock::Dense) || row(&entry.store.vdot, partition.nv);
    let effort =
        !matches!(effort, Some(Block::Dense)) || row(&entry.store.effort, partition.efforts.len());
    vdot && effort
        && forces
            .iter()
            .zip(&entry.store.forces)
            .all(|((contact, block), data)| {
                !matches!(block, Block::Dense) || row(data, partition.nf[contact.index()])
            })
}
