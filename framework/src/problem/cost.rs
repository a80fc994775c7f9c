//! Rows that are a cost, and the regularisation.

use super::{
    BoundEntry, DynamicsTerms, Problem,
    expand::is_finite,
    partition::{EffortPlace, Place},
};
use crate::plugin::layout::{Block, VdotBlock};

impl Problem {
    /// Adds a entry's rows to the cost, by what their blocks leave zero.
    pub(super) fn add_cost(&mut self, entry: &BoundEntry, terms: &DynamicsTerms<'_>) {
        let (weights, alpha) = (entry.weight.now(), entry.alpha);
        let weight = |k: usize| weights[k] * alpha;
        let b = |k: usize| entry.store.lower[k];
        let layout = &entry.layout;
        let (rows, partition) = (layout.len(), &self.partition);
        let (quadratic, motions) = (&mut self.quadratic, &self.motions);
        match (&layout.vdot, &layout.effort, layout.forces.as_slice()) {
            (VdotBlock::Unit(velocities), None, []) => {
                for (k, &velocity) in velocities.iter().enumerate() {
                    match partition.places[velocity] {
                        Place::Column(column) => quadratic.add_unit(column, weight(k), b(k)),
                        Place::Determined(motion, row) => {
                            quadratic.add_determined(motion, row, weight(k), b(k));
                        }
                    }
                }
            }
            (VdotBlock::Frame(frame, directions), None, []) => {
                let jacobian = &terms.frames[frame.0].J;
                let a = |k: usize, velocity: usize| jacobian[(directions[k], velocity)];
                let pattern = &partition.frames[frame.0];
                quadratic.add_motion_rows(rows, pattern, motions, a, weight, b);
            }
            (VdotBlock::Contact(contact, directions), None, []) => {
                let jacobian = &terms.contacts[contact.index()].J;
                let a = |k: usize, velocity: usize| jacobian[(directions[k], velocity)];
                let pattern = &partition.contacts[contact.index()];
                quadratic.add_motion_rows(rows, pattern, motions, a, weight, b);
            }
            (VdotBlock::Dense, None, []) => {
                let nv = partition.nv;
                let a = |k: usize, velocity: usize| entry.store.vdot[k * nv + velocity];
                quadratic.add_motion_rows(rows, &partition.all, motions, a, weight, b);
            }
            (VdotBlock::Absent, Some(Block::Unit(actuators)), []) => {
                for (k, &actuator) in actuators.iter().enumerate() {
                    match partition.efforts[actuator] {
                        EffortPlace::Kept(index) => {
                            quadratic.add_unit(partition.accelerations + index, weight(k), b(k));
                        }
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
            _ => self.add_mixed_cost(entry, terms),
        }
    }

    /// Adds rows with several blocks, or dense ones on efforts and forces, to the cost.
    fn add_mixed_cost(&mut self, entry: &BoundEntry, terms: &DynamicsTerms<'_>) {
        let (rows, n) = (entry.layout.len(), self.live.n_physical);
        let mut block = std::mem::take(&mut self.block);
        let mut constants = std::mem::take(&mut self.block_constants);
        block[..rows * n].fill(0.0);
        let context = self.context(terms);
        for (k, row) in block.chunks_exact_mut(n).take(rows).enumerate() {
            constants[k] = context.natural_row(entry, k, row);
        }
        // Efforts that are not kept are given by accelerations, too.
        let no_vdot = matches!(entry.layout.vdot, VdotBlock::Absent);
        if !no_vdot {
            self.quadratic.couple();
        }
        let first = if no_vdot && self.partition.torques.is_empty() {
            self.partition.accelerations
        } else {
            0
        };
        let (weights, alpha) = (entry.weight.now(), entry.alpha);
        let is_there = |column: usize| (0..rows).any(|k| block[k * n + column] != 0.0);
        self.columns.clear();
        self.columns
            .extend((first..n).filter(|&column| is_there(column)));
        let columns = &self.columns;
        self.quadratic.add_rows(
            rows,
            columns.iter().copied(),
            |k, i| block[k * n + columns[i]],
            |k| weights[k] * alpha,
            |k| entry.store.lower[k] - constants[k],
        );
        self.block = block;
        self.block_constants = constants;
    }

    /// Whether what a entry wrote for the cost is finite.
    pub(super) fn is_cost_finite(&self, entry: &BoundEntry) -> bool {
        entry.cost_start.is_none()
            || (0..entry.layout.len())
                .all(|k| entry.store.lower[k].is_finite() && is_finite(entry, &self.partition, k))
    }

    /// `w_ε ‖(u, f)‖²` with `w_ε` relative to the largest weight that is on.
    pub(super) fn regularise(&mut self, entries: &[BoundEntry]) {
        let on = entries.iter().filter(|g| g.cost_start.is_some());
        let largest = on.map(BoundEntry::largest_weight).fold(0.0, f64::max);
        self.largest_weight = if largest > 0.0 { largest } else { 1.0 };
        let weight = self.regularisation * self.largest_weight;
        self.regularisation_weight = weight;
        for column in self.partition.accelerations..self.live.n_physical {
            self.quadratic.add_unit(column, weight, 0.0);
        }
        for torque in 0..self.partition.torques.len() {
            self.quadratic.add_torque(torque, weight, 0.0);
        }
    }
}
