//! Which contacts may determine accelerations, and those of which joints: chosen once.
//!
//! Of the joints that qualify, see [`contact_elimination`](super::contact_elimination), those with the largest pivots
//! at home. And the problem of a tick in which none does.

use super::{BoundEntry, DynamicsTerms, Partition, Problem, Treatment};
use crate::{contact::ContactState, fault::Fault, plugin::layout::VdotBlock, qp::Qp};

/// One contact's.
#[derive(Clone, Debug)]
pub(crate) struct EliminatedContact {
    /// Whose rows.
    pub(super) entry: usize,
    pub(crate) contact: usize,
    /// Rows of the contact's Jacobian.
    pub(super) directions: Vec<usize>,
    /// D, by velocity; before it is chosen, the joints that qualify.
    pub(super) own: Vec<usize>,
    /// S, by velocity, in the order of columns of y.
    pub(crate) others: Vec<usize>,
    /// So many of S are in the first columns of y, in their order: those of the base.
    pub(crate) leading: usize,
    /// This tick: whether the accelerations are substituted.
    pub(crate) live: bool,
    /// `[G | g]`, row-major.
    pub(super) relation: Vec<f64>,
    /// `[J_D | −J_S | b]`, column by column.
    pub(super) work: Vec<f64>,
}

/// All of them.
#[derive(Clone, Debug, Default)]
pub(crate) struct ContactElimination {
    pub(super) list: Vec<EliminatedContact>,
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
            if !(1..=6).contains(&directions.len()) || own.len() < directions.len() {
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

    /// Rows of each.
    pub(crate) fn sizes(&self) -> impl ExactSizeIterator<Item = usize> {
        self.list.iter().map(|motion| motion.directions.len())
    }

    /// Substitutes none; true if some were.
    pub(crate) fn keep_all(&mut self) -> bool {
        let mut changed = false;
        for motion in &mut self.list {
            changed |= std::mem::replace(&mut motion.live, false);
        }
        changed
    }
}

impl EliminatedContact {
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
}

impl Problem {
    /// Builds the problem of this tick without substituting anything from contacts: all limits have a row or a bound.
    pub(crate) fn build_with_all_rows(
        &mut self,
        terms: &DynamicsTerms<'_>,
        entries: &[BoundEntry],
        qp: &mut Qp,
    ) -> Result<(), Fault> {
        if self.partition.elimination.keep_all() {
            self.arrange();
        }
        self.put_together(terms, entries, qp)
    }

    /// Whether contacts' rows hold by substitution in the problem built last.
    pub(crate) fn has_determined(&self) -> bool {
        self.partition.elimination.any()
    }
}
