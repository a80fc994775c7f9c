//! The variables of a tick: which accelerations, efforts and forces are variables, and where each stands.
//!
//! *Natural* variables are `y = (v̇_P, v̇_A, kept u, live f, live slacks)`, see [`partition`](super::partition); those
//! of the problem are `x`, the same without `v̇_P`.
//!
//! # Notation
//! By *velocity* an acceleration is numbered as in `v̇`, by *column* as in y of this tick.

use std::ops::Range;

use super::{
    BoundEntry, ContactElimination,
    partition::{
        ActiveVariables, Coordinate, Determined, FirstIds, Partition, Place, SparsityPattern,
    },
};
use crate::{contact::ContactState, qp::VarId};

impl Partition {
    /// Finds the accelerations that no contact determines this tick, and where they are in y.
    pub(crate) fn arrange(&mut self) {
        self.velocities.truncate(self.substituted);
        self.places.fill(Place::Column(usize::MAX));
        for (index, motion) in self.elimination.live() {
            for (row, &velocity) in motion.own.iter().enumerate() {
                self.places[velocity] = Place::Determined(index, row);
            }
        }
        for (column, &velocity) in self.velocities.iter().enumerate() {
            self.places[velocity] = Place::Column(column);
        }
        for (velocity, place) in self.places.iter_mut().enumerate() {
            if *place == Place::Column(usize::MAX) {
                *place = Place::Column(self.velocities.len());
                self.velocities.push(velocity);
            }
        }
        self.accelerations = self.velocities.len();
        let branches = self.branches.iter_mut().map(|branch| &mut branch.pattern);
        let frames = self.contacts.iter_mut().chain(&mut self.frames);
        for pattern in frames.chain(branches).chain([&mut self.all]) {
            pattern.arrange(&self.places, &self.elimination);
        }
    }

    /// Columns of y before the forces.
    pub(crate) fn first_force(&self) -> usize {
        self.accelerations + self.kept.len()
    }
}

impl Place {
    /// The column of an acceleration that is in y.
    pub(crate) fn column(self) -> Option<usize> {
        match self {
            Self::Column(column) => Some(column),
            Self::Determined(..) => None,
        }
    }
}

impl SparsityPattern {
    /// Finds the accelerations where they are now. `places` is by velocity.
    pub(crate) fn arrange(&mut self, places: &[Place], elimination: &ContactElimination) {
        self.coordinates.clear();
        self.determined.clear();
        self.columns.clear();
        for positions in &mut self.positions {
            positions.clear();
        }
        let column = |velocity: usize| places[velocity].column();
        for &velocity in &self.velocities {
            match places[velocity] {
                Place::Column(column) => {
                    self.columns.push(column);
                    self.coordinates.push(Coordinate {
                        velocity,
                        column,
                        position: 0,
                    });
                }
                Place::Determined(motion, row) => {
                    self.determined.push(Determined {
                        velocity,
                        motion,
                        row,
                    });
                    let others = &elimination.get(motion).others;
                    let positions = &mut self.positions[motion];
                    if positions.is_empty() {
                        positions.resize(others.len(), 0);
                        self.columns
                            .extend(others.iter().filter_map(|&v| column(v)));
                    }
                }
            }
        }
        self.columns.sort_unstable();
        self.columns.dedup();
        self.coordinates.sort_unstable_by_key(|at| at.column);
        let columns = &self.columns;
        let find = |column: usize| columns.binary_search(&column).unwrap_or(0);
        for at in &mut self.coordinates {
            at.position = find(at.column);
        }
        for (motion, positions) in self.positions.iter_mut().enumerate() {
            let others = &elimination.get(motion).others;
            for (position, &velocity) in positions.iter_mut().zip(others) {
                *position = column(velocity).map_or(0, find);
            }
        }
    }
}

impl ActiveVariables {
    /// The columns of a contact's force; none while it is off.
    pub(crate) fn force(&self, partition: &Partition, contact: usize) -> Range<usize> {
        self.forces[contact].map_or(0..0, |start| start..start + partition.nf[contact])
    }

    /// Lays out the live variables; true if forces are elsewhere than in the last tick.
    pub(crate) fn refresh(
        &mut self,
        partition: &Partition,
        first: &FirstIds,
        contacts: &[ContactState],
        entries: &[BoundEntry],
    ) -> bool {
        let vars = &mut self.vars;
        vars.clear();
        let id = |first: u32, index: usize| VarId::new(first + index as u32);
        let kept = &partition.velocities[partition.substituted..];
        vars.extend(kept.iter().map(|&velocity| id(first.vdot, velocity)));
        vars.extend(
            partition
                .kept
                .iter()
                .map(|&actuator| id(first.effort, actuator)),
        );
        let mut column = partition.first_force();
        let mut changed = false;
        for (contact, force) in self.forces.iter_mut().enumerate() {
            let now = contacts[contact].live.then_some(column);
            changed |= *force != now;
            *force = now;
            if force.is_some() {
                let count = partition.nf[contact];
                vars.extend((0..count).map(|i| id(first.force[contact], i)));
                column += count;
            }
        }
        self.n_physical = column;
        for (entry, slack) in entries.iter().zip(&mut self.slacks) {
            let id = entry.slack.filter(|_| entry.live);
            *slack = id.map(|_| column);
            column += usize::from(id.is_some());
            vars.extend(id);
        }
        self.n = column;
        changed
    }
}
