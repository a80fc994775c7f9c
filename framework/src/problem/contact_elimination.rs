//! Accelerations that contacts which do not move leave no choice of.
//!
//! # Notation
//! `C` is a contact; `J_D` are the columns of its Jacobian, in contact axes, of the joints `D`, `J_S` those of all
//! other velocities that carry it.
//!
//! # Mathematics
//! A contact whose motion is a hard row, `J_C v̇ = b` ([`VdotBlock::Contact`]), determines as many accelerations as it
//! has rows. Those of the joints D, which carry this contact and no other, are substituted from it:
//! ```text
//! v̇_D = G v̇_S + g      G = −J_D⁻¹ J_S,   g = J_D⁻¹ b
//! ```
//! by Gauss–Jordan elimination with row pivoting. `J_D` is small and square, there is one per contact, and the rows are
//! no longer in the problem: a quadruped on four feet has six accelerations left. Where J_D is singular (a stretched
//! leg), or close to it, the contact keeps its rows and its joints' accelerations for this tick: the optimum is the
//! same.
//!
//! D is chosen once, at home: of the joints that qualify, those with the largest pivots.

use super::{BoundEntry, Treatment, partition::Partition};
use crate::{contact::ContactState, plugin::layout::VdotBlock};

/// Pivots below this share of the largest coefficient of their row on `v̇_D` are as good as none.
const SINGULAR: f64 = 1e-2;

/// One contact's.
#[derive(Clone, Debug)]
pub(crate) struct EliminatedContact {
    /// Whose rows.
    entry: usize,
    pub(crate) contact: usize,
    /// Rows of the contact's Jacobian.
    directions: Vec<usize>,
    /// D, by velocity; before it is chosen, the joints that qualify.
    own: Vec<usize>,
    /// S, by velocity, in the order of columns of y.
    pub(crate) others: Vec<usize>,
    /// So many of S are in the first columns of y, in their order: those of the base.
    pub(crate) leading: usize,
    /// This tick: whether the accelerations are substituted.
    pub(crate) live: bool,
    /// `[G | g]`, row-major.
    relation: Vec<f64>,
    /// `[J_D | −J_S | b]`.
    work: Vec<f64>,
}

/// All of them.
#[derive(Clone, Debug)]
pub(crate) struct ContactElimination {
    list: Vec<EliminatedContact>,
}

impl ContactElimination {
    /// One for each contact that has hard rows on its acceleration and enough joints of its own with motors whose
    /// efforts are eliminated.
    pub(crate) fn new(partition: &Partition, entries: &[BoundEntry]) -> Self {
        let mut list: Vec<EliminatedContact> = Vec::new();
        for (index, entry) in entries.iter().enumerate() {
            let VdotBlock::Contact(contact, directions) = &entry.layout.vdot else {
                continue;
            };
            let contact = contact.index();
            let is_motion = entry.treatment == Treatment::Hard
                && entry.is_equality()
                && entry.layout.effort.is_none()
                && entry.layout.forces.is_empty();
            if !is_motion || list.iter().any(|motion| motion.contact == contact) {
                continue;
            }
            let carriers = &partition.contacts[contact].velocities;
            let is_own = |velocity: usize| {
                let others = partition.contacts.iter().enumerate();
                let mut others = others.filter(|(other, _)| *other != contact);
                partition.torques.iter().any(|t| t.velocity == velocity)
                    && !others.any(|(_, pattern)| pattern.velocities.contains(&velocity))
            };
            let own: Vec<usize> = carriers.iter().copied().filter(|&v| is_own(v)).collect();
            if own.len() < directions.len() {
                continue;
            }
            let (rows, columns) = (directions.len(), carriers.len() + 1);
            list.push(EliminatedContact {
                entry: index,
                contact,
                directions: directions.clone(),
                own,
                others: Vec::with_capacity(carriers.len()),
                leading: 0,
                live: false,
                relation: vec![0.0; rows * columns],
                work: vec![0.0; rows * columns],
            });
        }
        Self { list }
    }

    /// Chooses D, at home.
    pub(crate) fn choose(&mut self, partition: &Partition, contacts: &[ContactState]) {
        for motion in &mut self.list {
            let jacobian = &contacts[motion.contact].J;
            motion.choose_own(|row, velocity| jacobian[(row, velocity)]);
            let carriers = &partition.contacts[motion.contact].velocities;
            let others = carriers.iter().filter(|v| !motion.own.contains(v));
            motion.others.clear();
            motion.others.extend(others);
            motion
                .others
                .sort_unstable_by_key(|&v| (!partition.is_always_substituted(v), v));
            let base = &partition.velocities[..partition.substituted];
            let same = motion.others.iter().zip(base).take_while(|(a, b)| a == b);
            motion.leading = same.count();
        }
    }

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

    /// Substitutes none; true if some were.
    pub(crate) fn keep_all(&mut self) -> bool {
        let mut changed = false;
        for motion in &mut self.list {
            changed |= std::mem::replace(&mut motion.live, false);
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

    /// Rows of each.
    pub(crate) fn sizes(&self) -> impl ExactSizeIterator<Item = usize> {
        self.list.iter().map(|motion| motion.directions.len())
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
    /// D: the accelerations that are substituted, by velocity.
    pub(crate) fn own(&self) -> &[usize] {
        &self.own
    }

    /// Row `k` of G, and `g_k`.
    pub(crate) fn row(&self, k: usize) -> (&[f64], f64) {
        let n = self.others.len();
        let row = &self.relation[k * (n + 1)..(k + 1) * (n + 1)];
        (&row[..n], row[n])
    }

    /// Keeps as many joints as there are rows: in each step of an elimination the one with the largest pivot.
    fn choose_own(&mut self, jacobian: impl Fn(usize, usize) -> f64) {
        let (rows, columns) = (self.directions.len(), self.own.len());
        let mut a: Vec<f64> = Vec::with_capacity(rows * columns);
        for &direction in &self.directions {
            a.extend(self.own.iter().map(|&v| jacobian(direction, v)));
        }
        let mut free_rows: Vec<usize> = (0..rows).collect();
        let mut free: Vec<usize> = (0..columns).collect();
        let mut chosen = Vec::with_capacity(rows);
        while !free_rows.is_empty() {
            let size = |(r, c): (usize, usize)| a[free_rows[r] * columns + free[c]].abs();
            let mut best = (0, 0);
            for r in 0..free_rows.len() {
                for c in 0..free.len() {
                    if size((r, c)) > size(best) {
                        best = (r, c);
                    }
                }
            }
            let (row, column) = (free_rows.swap_remove(best.0), free.remove(best.1));
            chosen.push(self.own[column]);
            let pivot = a[row * columns + column];
            if pivot == 0.0 {
                continue;
            }
            for &other in &free_rows {
                let factor = a[other * columns + column] / pivot;
                for &c in &free {
                    a[other * columns + c] -= factor * a[row * columns + c];
                }
            }
        }
        chosen.sort_unstable();
        self.own = chosen;
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
            let mut best = step;
            for row in step + 1..rows {
                if size(row) > size(best) {
                    best = row;
                }
            }
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
