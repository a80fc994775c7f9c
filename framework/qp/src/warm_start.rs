//! What a solver remembers from one solve to the next.

use crate::{RowId, VarId};

/// Constraints to begin with, by identity, so that it survives rows being switched on and off.
#[derive(Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(transparent)
)]
pub struct WarmStart {
    held: Vec<Held>,
}

/// A constraint held at a limit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields)
)]
pub struct Held {
    /// Which.
    pub constraint: ConstraintId,
    /// +1 at the upper limit, −1 at the lower one.
    pub side: f64,
    /// Its multiplier, if it is known; else zero.
    #[cfg_attr(feature = "serde", serde(default))]
    pub multiplier: f64,
}

/// A row, or the bound of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum ConstraintId {
    /// A row.
    Row(RowId),
    /// The bound of a variable.
    Bound(VarId),
}

// Copies keep the room, which a copied `Vec` does not.
impl Clone for WarmStart {
    fn clone(&self) -> Self {
        let mut copy = Self::with_capacity(self.held.capacity());
        copy.held.extend_from_slice(&self.held);
        copy
    }
}

impl WarmStart {
    /// Room for this many constraints.
    pub fn with_capacity(constraints: usize) -> Self {
        Self {
            held: Vec::with_capacity(constraints),
        }
    }

    /// Nothing is held.
    pub fn clear(&mut self) {
        self.held.clear();
    }

    /// Adds a constraint; forgotten if there is no room, so that nothing is allocated.
    pub fn push(&mut self, held: Held) {
        if self.held.len() < self.held.capacity() {
            self.held.push(held);
        }
    }

    /// Takes another's constraints, as far as there is room.
    pub fn copy_from(&mut self, other: &Self) {
        self.clear();
        for held in other.iter() {
            self.push(held);
        }
    }

    /// The constraints, in the order in which they are held.
    pub fn iter(&self) -> impl Iterator<Item = Held> + '_ {
        self.held.iter().copied()
    }
}
