//! Accelerations that contacts which do not move leave no choice of.
//!
//! # Notation
//! `C` is a contact; `J_D` are the columns of its Jacobian, in contact axes, of the joints `D`, `J_S` those of all
//! other velocities that carry it.
//!
//! # Mathematics
//! A contact whose motion is a hard row, (10e) `J_C v̇ = b`
//! ([`VdotBlock::Contact`](crate::plugin::layout::VdotBlock::Contact)), determines as many accelerations as it has
//! rows. Those of the joints D, which carry this contact and no other, are substituted from it:
//! ```text
//! v̇_D = G v̇_S + g      G = −J_D⁻¹ J_S,   g = J_D⁻¹ b
//! ```
//! by Gauss–Jordan elimination with row pivoting. `J_D` is small and square, there is one per contact, and the rows are
//! no longer in the problem: a quadruped on four feet has six accelerations left. Where J_D is singular (a stretched
//! leg), or close to it, the contact keeps its rows and its joints' accelerations for this tick: the optimum is the
//! same.
//!
//! D is chosen once, at home ([`eliminable`](super::eliminable)).

use super::{
    BoundEntry, Treatment,
    eliminable::{ContactElimination, EliminatedContact},
    linear_algebra::largest,
};
use crate::contact::ContactState;

/// Pivots below this share of the largest coefficient of their row on `v̇_D` are as good as none.
const SINGULAR: f64 = 1e-2;

impl ContactElimination {
    /// Takes the contacts' rows of this tick; true if other contacts are substituted than in the last one.
    pub(crate) fn update(&mut self, entries: &[BoundEntry], contacts: &[ContactState]) -> bool {
        let mut changed = false;
        for motion in &mut self.list {
            let entry = &entries[motion.entry];
            let live = entry.live
                && entry.treatment_now() == Treatment::Hard
                && motion.solve(&contacts[motion.contact], &entry.store.lower);
            changed |= live != motion.live;
            motion.live = live;
        }
        changed
    }

    /// Whether an entry's rows hold by substitution.
    pub(crate) fn hold(&self, entry: usize) -> bool {
        self.list.iter().any(|m| m.live && m.entry == entry)
    }

    /// Whether any are substituted.
    pub(crate) fn any(&self) -> bool {
        self.list.iter().any(|m| m.live)
    }

    pub(crate) fn get(&self, index: usize) -> &EliminatedContact {
        &self.list[index]
    }

    /// Those that are substituted.
    pub(crate) fn live(&self) -> impl Iterator<Item = (usize, &EliminatedContact)> {
        self.list.iter().enumerate().filter(|(_, m)| m.live)
    }
}

impl EliminatedContact {
    /// Row `k` of G, and `g_k`.
    pub(crate) fn row(&self, k: usize) -> (&[f64], f64) {
        let n = self.others.len();
        let row = &self.relation[k * (n + 1)..(k + 1) * (n + 1)];
        (&row[..n], row[n])
    }

    /// Writes `[G | g]`; false if `J_D` is next to singular or a number is not finite.
    fn solve(&mut self, contact: &ContactState, b: &[f64]) -> bool {
        let (rows, others) = (self.own.len(), self.others.len());
        let stride = rows + others + 1;
        let (jacobian, _) = contact.J.as_slice().as_chunks::<6>();
        for (k, &direction) in self.directions.iter().enumerate() {
            let row = &mut self.work[k * stride..(k + 1) * stride];
            let mut largest = 0.0_f64;
            for (out, &velocity) in row.iter_mut().zip(&self.own) {
                *out = jacobian[velocity][direction];
                largest = largest.max(out.abs());
            }
            for (out, &velocity) in row[rows..].iter_mut().zip(&self.others) {
                *out = -jacobian[velocity][direction];
            }
            row[stride - 1] = b[k];
            if !(largest > 0.0 && b[k].is_finite()) {
                return false;
            }
            let scale = 1.0 / largest;
            for a in row {
                *a *= scale;
            }
        }
        for step in 0..rows {
            let size = |row: usize| self.work[row * stride + step].abs();
            let best = largest(step..rows, size);
            // Not `size <= SINGULAR`: a NaN must fail too.
            let regular = size(best) > SINGULAR;
            if !regular {
                return false;
            }
            let (above, below) = self.work.split_at_mut((step + 1) * stride);
            let pivot_row = &mut above[step * stride..];
            if best > step {
                let at = (best - step - 1) * stride;
                pivot_row.swap_with_slice(&mut below[at..at + stride]);
            }
            let reciprocal = 1.0 / pivot_row[step];
            for a in &mut pivot_row[step + 1..] {
                *a *= reciprocal;
            }
            let (before, pivot_row) = above.split_at_mut(step * stride);
            let pivot_tail = &pivot_row[step + 1..];
            let before = before.chunks_exact_mut(stride);
            let below = below.chunks_exact_mut(stride);
            for row in before.chain(below).take(rows - 1) {
                let factor = row[step];
                for (a, pivot) in row[step + 1..].iter_mut().zip(pivot_tail) {
                    *a -= factor * pivot;
                }
            }
        }
        for (out, row) in self
            .relation
            .chunks_exact_mut(others + 1)
            .zip(self.work.chunks_exact(stride))
        {
            out.copy_from_slice(&row[rows..]);
        }
        true
    }
}
