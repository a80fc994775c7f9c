//! From a solution back to accelerations, efforts, residuals and the cost.
//!
//! # Mathematics
//! `v̇_P = B x + c`, `v̇_D = G v̇_S + g` and `τ = T y + t` give what is no variable. Residuals
//! `A_v v̇ + A_u u + Σ A_c f_c − b` are then those of the rows as the plug-ins wrote them, in every formulation, and
//! the cost is the sum of `w r²` over all soft rows, of slacks and regularisation.

use super::{
    ActiveVariables, BoundEntry, ContactElimination, DynamicsTerms, Partition, ReducedDynamics,
    SparsityPattern, kernels::dot, partition::EffortPlace,
};
use crate::plugin::layout::{Block, VdotBlock};

/// What a solution means, in storage made once.
#[derive(Clone, Debug)]
pub(crate) struct Recovered {
    /// Generalised acceleration, size nv.
    pub(crate) vdot: Vec<f64>,
    /// Efforts, size nu.
    pub(crate) effort: Vec<f64>,
    /// `Σ w r²` over the cost rows, plus slacks and regularisation.
    pub(crate) objective: f64,
    /// Residual and weight of every cost row, in the order of the entries' [`cost_start`](BoundEntry::cost_start).
    pub(crate) residuals: Vec<[f64; 2]>,
    y: Vec<f64>,
}

impl Recovered {
    /// For at most `rows` cost rows and `capacity` natural variables.
    pub(crate) fn new(partition: &Partition, rows: usize, capacity: usize) -> Self {
        Self {
            vdot: vec![0.0; partition.nv],
            effort: vec![0.0; partition.efforts.len()],
            objective: 0.0,
            residuals: Vec::with_capacity(rows),
            y: vec![0.0; capacity],
        }
    }

    /// Takes the accelerations and efforts of a solution.
    pub(crate) fn take(
        &mut self,
        partition: &Partition,
        motions: &ContactElimination,
        reduced: &ReducedDynamics,
        live: &ActiveVariables,
        x: &[f64],
    ) {
        let p = partition.substituted;
        let (head, tail) = self.y[..live.n].split_at_mut(p);
        tail.copy_from_slice(&x[..live.n - p]);
        for (y, value) in head.iter_mut().zip(reduced.substituted(x)) {
            *y = value;
        }
        for (&velocity, y) in partition.velocities.iter().zip(&self.y) {
            self.vdot[velocity] = *y;
        }
        for (_, motion) in motions.live() {
            for (row, &velocity) in motion.own().iter().enumerate() {
                let (relation, mut sum) = motion.row(row);
                for (g, &other) in relation.iter().zip(&motion.others) {
                    sum += g * self.vdot[other];
                }
                self.vdot[velocity] = sum;
            }
        }
        for (effort, place) in self.effort.iter_mut().zip(&partition.efforts) {
            *effort = match *place {
                EffortPlace::Kept(index) => self.y[partition.accelerations + index],
                EffortPlace::Eliminated(index) => {
                    let (torque, known) = reduced.torque(index);
                    dot(torque, &self.y) + known
                }
            };
        }
    }

    /// Takes residuals and cost; accelerations and efforts have been taken.
    pub(crate) fn assess(
        &mut self,
        entries: &[BoundEntry],
        live: &ActiveVariables,
        terms: &DynamicsTerms<'_>,
        partition: &Partition,
        regularisation: f64,
    ) {
        self.residuals.clear();
        let mut sum = 0.0;
        for entry in entries.iter().filter(|g| g.cost_start.is_some()) {
            let weights = entry.weight.now();
            for (k, weight) in weights.iter().enumerate() {
                let residual = self.value(entry, k, live, terms, partition) - entry.store.lower[k];
                let weight = weight * entry.alpha;
                sum += weight * residual * residual;
                self.residuals.push([residual, weight]);
            }
        }
        let forces = &self.y[partition.first_force()..live.n_physical];
        let inputs = self.effort.iter().chain(forces);
        sum += regularisation * inputs.map(|x| x * x).sum::<f64>();
        for (entry, slack) in entries.iter().zip(&live.slacks) {
            if let Some(slack) = slack {
                let s = self.y[*slack];
                sum += entry.slack_weight() * s * s + entry.slack_penalty() * s;
            }
        }
        self.objective = sum;
    }

    /// `A_v v̇ + A_u u + Σ A_c f_c` of a row.
    fn value(
        &self,
        entry: &BoundEntry,
        k: usize,
        live: &ActiveVariables,
        terms: &DynamicsTerms<'_>,
        partition: &Partition,
    ) -> f64 {
        let along =
            |jacobian: &nalgebra::Matrix6xX<f64>, row: usize, carriers: &SparsityPattern| -> f64 {
                let terms = carriers.velocities.iter();
                terms.map(|&v| jacobian[(row, v)] * self.vdot[v]).sum()
            };
        let mut sum = match &entry.layout.vdot {
            VdotBlock::Absent => 0.0,
            VdotBlock::Dense => dot(&entry.store.vdot[k * partition.nv..], &self.vdot),
            VdotBlock::Unit(velocities) => self.vdot[velocities[k]],
            VdotBlock::Frame(frame, rows) => along(
                &terms.frames[frame.0].J,
                rows[k],
                &partition.frames[frame.0],
            ),
            VdotBlock::Contact(contact, rows) => {
                let contact = contact.index();
                along(
                    &terms.contacts[contact].J,
                    rows[k],
                    &partition.contacts[contact],
                )
            }
        };
        sum += match &entry.layout.effort {
            None => 0.0,
            Some(Block::Dense) => dot(&entry.store.effort[k * self.effort.len()..], &self.effort),
            Some(Block::Unit(actuators)) => self.effort[actuators[k]],
        };
        for ((contact, block), source) in entry.layout.forces.iter().zip(&entry.store.forces) {
            let Some(start) = live.forces[contact.index()] else {
                continue;
            };
            let nf = partition.nf[contact.index()];
            let force = &self.y[start..start + nf];
            sum += match block {
                Block::Dense => dot(&source[k * nf..], force),
                Block::Unit(columns) => force[columns[k]],
            };
        }
        sum
    }

    /// Force components of a contact that is live.
    pub(crate) fn force(
        &self,
        live: &ActiveVariables,
        partition: &Partition,
        contact: usize,
    ) -> Option<&[f64]> {
        let start = live.forces[contact]?;
        Some(&self.y[start..start + partition.nf[contact]])
    }
}
