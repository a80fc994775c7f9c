//! What tasks ask of single accelerations.

use super::{BoundEntry, Treatment};
use crate::plugin::layout::VdotBlock;

/// Per component of `v̇` the sum of what is asked by weight, and of the weights: infinite once a hard row has asked.
#[derive(Clone, Debug)]
pub(crate) struct Asked {
    sums: Vec<[f64; 2]>,
}

impl Asked {
    /// For nv components.
    pub(crate) fn new(nv: usize) -> Self {
        Self {
            sums: vec![[0.0; 2]; nv],
        }
    }

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
