//! Which motions of a contact a surface forbids.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Index of a contact, in the order of the configuration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ContactId(pub(crate) u32);

impl ContactId {
    /// Position in the configuration's list.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// Which motions the surface forbids: the four kinds of the paper, section II-A.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ContactKind {
    /// Position and orientation: six constrained directions. Needs a constraint that limits its moments.
    Full,
    /// Position, the end effector may turn: a point with friction, three forces.
    Point,
    /// The normal translation alone: a frictionless (or sliding) point, one force.
    Normal,
    /// The normal translation and the two tilts: a foot that slides, one force and two moments. Needs a constraint
    /// that limits its moments.
    NormalTilt,
}

impl ContactKind {
    /// Rows of the six that are constrained (`S_c`): 0–2 translations, 3–5 rotations, C axes.
    pub fn constrained(self) -> &'static [usize] {
        match self {
            Self::Full => &[0, 1, 2, 3, 4, 5],
            Self::Point => &[0, 1, 2],
            Self::Normal => &[2],
            Self::NormalTilt => &[2, 3, 4],
        }
    }

    /// The complementary rows (`S_f`).
    pub fn free(self) -> &'static [usize] {
        match self {
            Self::Full => &[],
            Self::Point => &[3, 4, 5],
            Self::Normal => &[0, 1, 3, 4, 5],
            Self::NormalTilt => &[0, 1, 5],
        }
    }

    /// Whether moments are among the constrained components.
    pub fn has_moments(self) -> bool {
        self.constrained().iter().any(|&row| row > 2)
    }

    /// Position of the normal force among the constrained components.
    pub fn normal(self) -> usize {
        match self {
            Self::Full | Self::Point => 2,
            Self::Normal | Self::NormalTilt => 0,
        }
    }

    /// Positions of the two tangential forces among the constrained components, if they are constrained.
    pub fn tangential(self) -> Option<[usize; 2]> {
        match self {
            Self::Full | Self::Point => Some([0, 1]),
            Self::Normal | Self::NormalTilt => None,
        }
    }
}
