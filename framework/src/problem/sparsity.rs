//! In which accelerations the rows of a frame, a contact or a branch of the tree are not zero, and where they are.
//!
//! # Notation
//! By *velocity* an acceleration is numbered as in `v̇`, by *column* as in y of this tick, see
//! [`Partition`](super::Partition).

use super::{ContactElimination, partition::Place};

/// An acceleration in y.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Coordinate {
    pub(crate) velocity: usize,
    pub(crate) column: usize,
    /// Where its column is in [`SparsityPattern::columns`].
    pub(crate) position: usize,
}

/// An acceleration that a contact determines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Determined {
    pub(crate) velocity: usize,
    /// By which contact's motion.
    pub(crate) motion: usize,
    /// Which of its accelerations.
    pub(crate) row: usize,
}

/// Accelerations, and how they are found in y.
#[derive(Clone, Debug, Default)]
pub(crate) struct SparsityPattern {
    /// All of them; never changes.
    pub(crate) velocities: Vec<usize>,
    /// Those in y, by column.
    pub(crate) coordinates: Vec<Coordinate>,
    /// Those that are not.
    pub(crate) determined: Vec<Determined>,
    /// Columns of y that they come down to, ascending.
    pub(crate) columns: Vec<usize>,
    /// Where the columns of each motion's other accelerations are in `columns`, for the motions in `determined`.
    pub(crate) positions: Vec<Vec<usize>>,
}

impl SparsityPattern {
    /// To be arranged.
    pub(crate) fn new(velocities: Vec<usize>) -> Self {
        Self {
            velocities,
            ..Self::default()
        }
    }

    /// Makes room for every arrangement.
    pub(crate) fn reserve(&mut self, nv: usize, motions: usize) {
        let count = self.velocities.len();
        self.coordinates.reserve(count);
        self.determined.reserve(count);
        self.columns.reserve(count + motions * nv);
        self.positions.clear();
        self.positions
            .resize_with(motions, || Vec::with_capacity(nv));
    }

    /// Finds the accelerations where they are now. `places` is by velocity.
    pub(crate) fn arrange(&mut self, places: &[Place], elimination: &ContactElimination) {
        self.coordinates.clear();
        self.determined.clear();
        self.columns.clear();
        for positions in &mut self.positions {
            positions.clear();
        }
        let column = |velocity: usize| match places[velocity] {
            Place::Column(column) => Some(column),
            Place::Determined(..) => None,
        };
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
