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
        let (jacobian, _) = contact.J.as_slice().as_chunks::<6>();
        match self.own.len() {
            1 => self.solve_rows::<1>(jacobian, b),
            2 => self.solve_rows::<2>(jacobian, b),
            3 => self.solve_rows::<3>(jacobian, b),
            4 => self.solve_rows::<4>(jacobian, b),
            5 => self.solve_rows::<5>(jacobian, b),
            6 => self.solve_rows::<6>(jacobian, b),
            _ => false,
        }
    }

    /// Column by column of `[J_D | −J_S | b]`: these lie in one piece, of a length that the compiler knows.
    fn solve_rows<const K: usize>(&mut self, jacobian: &[[f64; 6]], b: &[f64]) -> bool {
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

#[cfg(test)]
mod tests {
    use super::EliminatedContact;

    /// A contact with these rows and joints of its own, of a robot with nine velocities.
    fn contact(directions: &[usize], own: &[usize]) -> EliminatedContact {
        let others: Vec<usize> = (0..9).filter(|v| !own.contains(v)).collect();
        EliminatedContact {
            entry: 0,
            contact: 0,
            directions: directions.to_vec(),
            own: own.to_vec(),
            others,
            leading: 0,
            live: false,
            relation: vec![0.0; directions.len() * 10],
            work: vec![0.0; directions.len() * 10],
        }
    }

    fn jacobian(seed: usize) -> Vec<[f64; 6]> {
        let entry = |v: usize, row: usize| {
            ((7 * v * v + 13 * row + 5 * v * row * row + 29 * seed) as f64).sin()
        };
        let column = |v: usize| std::array::from_fn(|row| entry(v, row));
        (0..9).map(column).collect()
    }

    #[test]
    fn what_is_determined_keeps_the_rows() {
        let own = [8, 3, 7, 1, 5, 2];
        let directions: [&[usize]; 7] = [
            &[2],
            &[2, 4],
            &[0, 1, 2],
            &[2, 3, 4],
            &[0, 2, 3, 5],
            &[1, 2, 3, 4, 5],
            &[0, 1, 2, 3, 4, 5],
        ];
        let mut checked = 0;
        for seed in 0..20 {
            let jacobian = jacobian(seed);
            let b: Vec<f64> = (0..6).map(|k| ((seed + 5 * k) as f64).cos()).collect();
            for directions in directions {
                let rows = directions.len();
                let mut contact = contact(directions, &own[..rows]);
                let is_regular = match rows {
                    1 => contact.solve_rows::<1>(&jacobian, &b),
                    2 => contact.solve_rows::<2>(&jacobian, &b),
                    3 => contact.solve_rows::<3>(&jacobian, &b),
                    4 => contact.solve_rows::<4>(&jacobian, &b),
                    5 => contact.solve_rows::<5>(&jacobian, &b),
                    _ => contact.solve_rows::<6>(&jacobian, &b),
                };
                if !is_regular {
                    continue;
                }
                checked += 1;
                let mut vdot: Vec<f64> = (0..9_usize).map(|v| (v as f64).cos()).collect();
                for (k, &velocity) in contact.own.iter().enumerate() {
                    let (relation, known) = contact.row(k);
                    let terms = relation.iter().zip(&contact.others);
                    vdot[velocity] = known + terms.map(|(g, &v)| g * vdot[v]).sum::<f64>();
                }
                for (&direction, b) in directions.iter().zip(&b) {
                    let terms = jacobian.iter().zip(&vdot);
                    let value: f64 = terms.map(|(column, v)| column[direction] * v).sum();
                    assert!(
                        (value - b).abs() < 1e-11,
                        "{seed} {directions:?} {value} {b}"
                    );
                }
            }
        }
        assert!(checked > 120, "{checked} of 140");
    }

    #[test]
    fn most_of_these_are_regular_and_none_that_is_singular_or_has_a_nan() {
        let regular = (0..20).filter(|&seed| {
            contact(&[0, 1, 2], &[8, 3, 7]).solve_rows::<3>(&jacobian(seed), &[0.0; 3])
        });
        assert!(regular.count() > 15);
        let mut same = jacobian(0);
        same[3] = same[8];
        assert!(!contact(&[0, 1, 2], &[8, 3, 7]).solve_rows::<3>(&same, &[0.0; 3]));
        let mut none = jacobian(0);
        none[3] = [f64::NAN; 6];
        assert!(!contact(&[0, 1, 2], &[8, 3, 7]).solve_rows::<3>(&none, &[0.0; 3]));
        let b = [0.0, f64::INFINITY, 0.0];
        assert!(!contact(&[0, 1, 2], &[8, 3, 7]).solve_rows::<3>(&jacobian(0), &b));
    }
}
