//! The variables of a tick: which accelerations, efforts and forces are variables, and where each stands.
//!
//! # Mathematics
//! The rows of the dynamics are split into those of the **substituted** accelerations `P` and of the **kept** ones `A`,
//! the efforts into those that are **eliminated** and those that are kept:
//!
//! | formulation | P | eliminated efforts | rows of the dynamics in the problem |
//! |---|---|---|---|
//! | condensed | all | none | none |
//! | torque-eliminated | those that no joint motor drives | joint motors', one per joint | none |
//! | explicit | none | none | all |
//!
//! In the torque-eliminated form accelerations that hard contacts *determine* are substituted too
//! ([`ContactElimination`]), as long as the contact is on. They are neither in P nor in A: each tick's
//! [`Partition::arrange`] says where the others are.
//!
//! *Natural* variables are `y = (v̇_P, v̇_A, kept u, live f, live slacks)`; those of the problem are `x`, the same
//! without `v̇_P`.
//!
//! # Notation
//! By *velocity* an acceleration is numbered as in `v̇`, by *column* as in y of this tick.

use super::ContactElimination;
use crate::qp::VarId;

/// Where an actuator's effort is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EffortPlace {
    /// A variable: this one of [`Partition::kept`].
    Kept(usize),
    /// Eliminated: this one of [`Partition::torques`].
    Eliminated(usize),
}

/// An effort that is given by the dynamics' row of its joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Torque {
    /// The joint's velocity.
    pub(crate) velocity: usize,
    /// The motor, in the order of u.
    pub(crate) actuator: usize,
}

/// Where an acceleration is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    /// At this column of y.
    Column(usize),
    /// Determined by this motion of a contact, as this one of its joints.
    Determined(usize, usize),
}

/// Eliminated efforts whose rows have their nonzero coefficients in the same columns.
#[derive(Clone, Debug)]
pub(crate) struct Branch {
    /// Indices into [`Partition::torques`].
    pub(crate) torques: Vec<usize>,
    /// The accelerations.
    pub(crate) pattern: SparsityPattern,
    /// The kept efforts, of [`Partition::kept`].
    pub(crate) efforts: Vec<usize>,
    /// The contacts.
    pub(crate) contacts: Vec<usize>,
}

/// The split. What depends on the contacts that are on is arranged anew when they change.
#[derive(Clone, Debug)]
pub(crate) struct Partition {
    pub(crate) nv: usize,
    /// Size of `P`: the first columns of y.
    pub(crate) substituted: usize,
    /// Accelerations in y, this tick.
    pub(crate) accelerations: usize,
    /// Their velocities, by column of y.
    pub(crate) velocities: Vec<usize>,
    /// By velocity.
    pub(crate) places: Vec<Place>,
    /// By actuator.
    pub(crate) efforts: Vec<EffortPlace>,
    /// The actuators that are variables, in the order of their columns.
    pub(crate) kept: Vec<usize>,
    pub(crate) torques: Vec<Torque>,
    pub(crate) branches: Vec<Branch>,
    /// For each column of `P`, the columns of `P` that carry it, nearest first.
    pub(crate) ancestors: Vec<Vec<usize>>,
    /// Number of force components of each contact.
    pub(crate) nf: Vec<usize>,
    /// What carries each contact.
    pub(crate) contacts: Vec<SparsityPattern>,
    /// What carries each requested frame.
    pub(crate) frames: Vec<SparsityPattern>,
    /// All accelerations.
    pub(crate) all: SparsityPattern,
}

impl Partition {
    /// Finds the accelerations that no contact determines this tick, and where they are in y.
    pub(crate) fn arrange(&mut self, elimination: &ContactElimination) {
        self.velocities.truncate(self.substituted);
        self.places.fill(Place::Column(usize::MAX));
        for (index, motion) in elimination.live() {
            for (row, &velocity) in motion.own().iter().enumerate() {
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
        let places = std::mem::take(&mut self.places);
        self.patterns_mut()
            .for_each(|s| s.arrange(&places, elimination));
        self.places = places;
    }

    pub(super) fn patterns_mut(&mut self) -> impl Iterator<Item = &mut SparsityPattern> {
        let branches = self.branches.iter_mut().map(|branch| &mut branch.pattern);
        let frames = self.contacts.iter_mut().chain(&mut self.frames);
        frames.chain(branches).chain([&mut self.all])
    }

    /// The column of an acceleration that is in y.
    pub(crate) fn column(&self, velocity: usize) -> Option<usize> {
        match self.places[velocity] {
            Place::Column(column) => Some(column),
            Place::Determined(..) => None,
        }
    }

    /// Columns of y before the forces.
    pub(crate) fn first_force(&self) -> usize {
        self.accelerations + self.kept.len()
    }
}

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

/// Columns of y of the live variables, see [`Partition`]; the packed problem has those that are not substituted, in id
/// order. The layout depends on what is on and not on history.
#[derive(Clone, Debug)]
pub(crate) struct ActiveVariables {
    /// First force component of each contact that is live.
    pub(crate) forces: Vec<Option<usize>>,
    /// Slack of each entry that has a live one.
    pub(crate) slacks: Vec<Option<usize>>,
    /// Columns before the slacks.
    pub(crate) n_physical: usize,
    /// All columns.
    pub(crate) n: usize,
    /// Identities of the problem's variables, ascending.
    pub(crate) vars: Vec<VarId>,
}

/// First ids of the blocks of variables.
#[derive(Clone, Debug)]
pub(crate) struct FirstIds {
    pub(crate) vdot: u32,
    pub(crate) effort: u32,
    /// First id of each contact's force.
    pub(crate) force: Vec<u32>,
}

impl ActiveVariables {
    /// Lays out the live variables; true if forces are elsewhere than in the last tick.
    pub(crate) fn refresh(
        &mut self,
        partition: &Partition,
        first: &FirstIds,
        contact_is_live: impl Fn(usize) -> bool,
        live_slack: impl Fn(usize) -> Option<VarId>,
    ) -> bool {
        self.vars.clear();
        let kept = &partition.velocities[partition.substituted..];
        self.vars
            .extend(kept.iter().map(|&v| VarId::new(first.vdot + v as u32)));
        let efforts = &partition.kept;
        self.vars
            .extend(efforts.iter().map(|&u| VarId::new(first.effort + u as u32)));
        let mut column = partition.first_force();
        let mut changed = false;
        for (contact, force) in self.forces.iter_mut().enumerate() {
            let now = contact_is_live(contact).then_some(column);
            changed |= *force != now;
            *force = now;
            if force.is_some() {
                let (id, count) = (first.force[contact], partition.nf[contact]);
                self.vars.extend((id..id + count as u32).map(VarId::new));
                column += count;
            }
        }
        self.n_physical = column;
        for (entry, slack) in self.slacks.iter_mut().enumerate() {
            let id = live_slack(entry);
            *slack = id.map(|_| column);
            if let Some(id) = id {
                self.vars.push(id);
                column += 1;
            }
        }
        self.n = column;
        changed
    }
}
