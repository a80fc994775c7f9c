//! From a solution of the problem back to accelerations, efforts and forces, residuals and the cost; and what tasks
//! asked of single accelerations.
//!
//! # Mathematics
//! `v̇_P = B x + c`, `v̇_D = G v̇_S + g` and `τ = T y + t` give what is no variable. Residuals
//! `A_v v̇ + A_u u + Σ A_c f_c − b` are those of the rows as the plug-ins wrote them, in every formulation, and the
//! cost is the sum of `w r²` over all soft rows, of slacks and regularisation.

use std::ops::Range;

use super::{
    ActiveVariables, BoundEntry, Partition, ReducedDynamics, Treatment, linear_algebra::dot,
    partition::EffortPlace, rows::NaturalRows,
};
use crate::plugin::layout::VdotBlock;

/// What a solution means, in storage made once.
#[derive(Clone, Debug)]
pub(crate) struct Solved {
    /// Generalised acceleration, size nv.
    pub(crate) vdot: Vec<f64>,
    /// Efforts, size nu.
    pub(crate) effort: Vec<f64>,
    /// `Σ w r²` over the cost rows, plus slacks and regularisation.
    pub(crate) objective: f64,
    /// Natural variables.
    pub(super) y: Vec<f64>,
    /// Values of an entry's rows.
    pub(super) values: Vec<f64>,
    /// Residual `a x − b` and weight of every row of a cost or a task, entry by entry.
    pub(super) residuals: Vec<[f64; 2]>,
    /// Where the residuals of each entry are.
    pub(super) ranges: Vec<Range<usize>>,
}

impl Solved {
    /// Takes the accelerations and efforts of a solution.
    pub(super) fn take(
        &mut self,
        partition: &Partition,
        reduced: &ReducedDynamics,
        active: &ActiveVariables,
        x: &[f64],
    ) {
        let p = partition.substituted;
        let (head, tail) = self.y[..active.n].split_at_mut(p);
        tail.copy_from_slice(&x[..active.n - p]);
        for (y, value) in head.iter_mut().zip(reduced.substituted(x)) {
            *y = value;
        }
        for (&velocity, y) in partition.velocities.iter().zip(&self.y) {
            self.vdot[velocity] = *y;
        }
        for (_, contact) in partition.elimination.live() {
            for (row, &velocity) in contact.own.iter().enumerate() {
                let (relation, mut sum) = contact.row(row);
                for (g, &other) in relation.iter().zip(&contact.others) {
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
    pub(super) fn assess(
        &mut self,
        entries: &[BoundEntry],
        rows: &[NaturalRows],
        active: &ActiveVariables,
        first_force: usize,
        regularisation: f64,
    ) {
        let mut residuals = std::mem::take(&mut self.residuals);
        residuals.clear();
        let mut sum = 0.0;
        for (index, (entry, rows)) in entries.iter().zip(rows).enumerate() {
            let start = residuals.len();
            self.ranges[index] = start..start;
            if !(rows.is_cost || rows.is_expanded && entry.is_task) {
                continue;
            }
            // Rows of tasks that are hard cost nothing, and hold unless they were given up.
            let alpha = if rows.is_cost { entry.alpha } else { 0.0 };
            let weights = entry.weight.now();
            let mut values = std::mem::take(&mut self.values);
            values[..weights.len()].fill(0.0);
            rows.evaluate(self, active, &mut values[..weights.len()]);
            let each = weights.iter().zip(&values).zip(&entry.store.lower);
            residuals.extend(each.map(|((weight, value), b)| {
                let (residual, weight) = (value - b, weight * alpha);
                sum += weight * residual * residual;
                [residual, weight]
            }));
            self.values = values;
            self.ranges[index].end = residuals.len();
        }
        self.residuals = residuals;
        let forces = &self.y[first_force..active.n_physical];
        let inputs = self.effort.iter().chain(forces);
        sum += regularisation * inputs.map(|x| x * x).sum::<f64>();
        for (entry, slack) in entries.iter().zip(&active.slacks) {
            if let Some(slack) = slack {
                let s = self.y[*slack];
                sum += entry.slack_weight() * s * s + entry.slack_penalty() * s;
            }
        }
        self.objective = sum;
    }

    /// Residuals `a x − b` and weights of an entry's rows; none if it is neither a task nor a cost.
    pub(crate) fn residuals(&self, entry: usize) -> &[[f64; 2]] {
        &self.residuals[self.ranges[entry].clone()]
    }
}

/// Per component of `v̇` the sum of what is asked by weight, and of the weights: infinite once a hard row has asked.
#[derive(Clone, Debug)]
pub(crate) struct Asked {
    pub(super) sums: Vec<[f64; 2]>,
}

impl Asked {
    /// Writes what the live entries ask of each component of `v̇` by rows on it alone: their mean by weight, or the
    /// first hard one's; zero if none asks.
    pub(crate) fn collect(&mut self, entries: &[BoundEntry], out: &mut [f64]) {
        self.sums.fill([0.0; 2]);
        for entry in entries.iter().filter(|g| g.live) {
            let layout = &entry.layout;
            let VdotBlock::Unit(columns) = &layout.vdot else {
                continue;
            };
            if layout.effort.is_some() || !layout.forces.is_empty() {
                continue;
            }
            let hard = entry.treatment_now() == Treatment::Hard;
            let rows = entry.store.lower.iter().zip(entry.weight.now());
            for (&column, (&asked, weight)) in columns.iter().zip(rows) {
                let [sum, total] = &mut self.sums[column];
                if *total == f64::INFINITY {
                    continue;
                }
                if hard {
                    (*sum, *total) = (asked, f64::INFINITY);
                } else {
                    let weight = weight * entry.alpha;
                    *sum += weight * asked;
                    *total += weight;
                }
            }
        }
        for (out, &[sum, total]) in out.iter_mut().zip(&self.sums) {
            *out = if total == f64::INFINITY {
                sum
            } else if total > 0.0 {
                sum / total
            } else {
                0.0
            };
        }
    }
}
