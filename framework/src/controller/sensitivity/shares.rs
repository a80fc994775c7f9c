//! Whose the largest weight is, which the regularisation follows.

use crate::problem::{BoundEntry, Treatment};

/// How much of the largest weight is due to each row.
pub(super) struct Shares {
    largest: f64,
    /// So many entries have it.
    entries: usize,
}

impl Shares {
    pub(super) fn new(entries: &[BoundEntry]) -> Self {
        let costs = || {
            let is_cost = |e: &&BoundEntry| e.live && e.treatment_now() == Treatment::Cost;
            entries
                .iter()
                .filter(is_cost)
                .map(BoundEntry::largest_weight)
        };
        let largest = costs().fold(0.0, f64::max);
        Self {
            largest,
            entries: costs().filter(|w| *w == largest).count(),
        }
    }

    pub(super) fn of(&self, entry: &BoundEntry, row: usize) -> f64 {
        if self.largest > 0.0 && entry.largest_weight() == self.largest {
            Self::within(entry, row) / self.entries as f64
        } else {
            0.0
        }
    }

    /// Whether another entry has the same largest weight as this one.
    pub(super) fn is_tied(&self, entry: &BoundEntry) -> bool {
        let is_cost = entry.live && entry.treatment_now() == Treatment::Cost;
        self.entries > 1 && is_cost && entry.largest_weight() == self.largest
    }

    /// The same of the largest weight of the entry.
    pub(super) fn within(entry: &BoundEntry, row: usize) -> f64 {
        let (weights, largest) = (entry.weight.now(), entry.largest_weight());
        if weights[row] == largest {
            let count = weights.iter().filter(|w| **w == largest).count();
            1.0 / count as f64
        } else {
            0.0
        }
    }
}
