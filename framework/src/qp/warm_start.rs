//! What a solver remembers from one solve to the next.

use super::{RowId, VarId};

/// A constraint that was held at one of its limits at the end of a solve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Held {
    /// Which constraint.
    pub constraint: ConstraintId,
    /// At which limit.
    pub side: Side,
}

/// A row or the bound of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConstraintId {
    /// A row.
    Row(RowId),
    /// The bound of a variable.
    Bound(VarId),
}

/// One of a constraint's two limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The lower limit; multipliers are negative here.
    Lower,
    /// The upper limit; multipliers are positive here.
    Upper,
}
