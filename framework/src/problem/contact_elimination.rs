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

use std::array::from_fn;

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
        match self.own.len() {
            1 => self.solve_rows::<1>(contact, b),
            2 => self.solve_rows::<2>(contact, b),
            3 => self.solve_rows::<3>(contact, b),
            4 => self.solve_rows::<4>(contact, b),
            5 => self.solve_rows::<5>(contact, b),
            _ => self.solve_rows::<6>(contact, b),
        }
    }

    /// Column by column of `[J_D | −J_S | b]`: these lie in one piece, of a length that the compiler knows.
    fn solve_rows<const K: usize>(&mut self, contact: &ContactState, b: &[f64]) -> bool {
        let (jacobian, _) = contact.J.as_slice().as_chunks::<6>();
        let (columns, _) = self.work.as_chunks_mut::<K>();
        let directions: [usize; K] = from_fn(|k| self.directions[k]);
        let (own, rest) = columns.split_at_mut(self.own.len());
        let mut largest_of = [0.0_f64; K];
        for (column, &velocity) in own.iter_mut().zip(&self.own) {
            *column = directions.map(|direction| jacobian[velocity][direction]);
            for (largest, a) in largest_of.iter_mut().zip(column) {
                *largest = largest.max(a.abs());
            }
        }
        for (column, &velocity) in rest.iter_mut().zip(&self.others) {
            *column = directions.map(|direction| -jacobian[velocity][direction]);
        }
        for k in 0..K {
            rest[self.others.len()][k] = b[k];
            if !(largest_of[k] > 0.0 && b[k].is_finite()) {
                return false;
            }
        }
        let scale = largest_of.map(|largest| 1.0 / largest);
        for column in columns.iter_mut() {
            for (a, scale) in column.iter_mut().zip(scale) {
                *a *= scale;
            }
        }
        for step in 0..K {
            let (before, after) = columns.split_at_mut(step + 1);
            let pivots = &mut before[step];
            let best = largest(step..K, |row| pivots[row].abs());
            // Not `size <= SINGULAR`: a NaN must fail too.
            let regular = pivots[best].abs() > SINGULAR;
            if !regular {
                return false;
            }
            pivots.swap(step, best);
            let reciprocal = 1.0 / pivots[step];
            for column in after {
                column.swap(step, best);
                let pivot = column[step] * reciprocal;
                for (a, factor) in column.iter_mut().zip(&*pivots) {
                    *a -= factor * pivot;
                }
                column[step] = pivot;
            }
        }
        let solved = &columns[K..];
        let rows = self.relation.chunks_exact_mut(solved.len()).take(K);
        for (k, row) in rows.enumerate() {
            for (out, column) in row.iter_mut().zip(solved) {
                *out = column[k];
            }
        }
        true
    }
}
