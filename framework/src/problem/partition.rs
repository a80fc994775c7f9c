//! How a formulation splits a robot's accelerations and efforts into variables and what follows from them.
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
    /// What contacts determine; nothing before the entries are known.
    pub(crate) elimination: ContactElimination,
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
