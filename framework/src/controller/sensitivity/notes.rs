//! Where a tick's optimum is not differentiable.

use super::super::Side;
use crate::qp::RowId;

/// Where the optimum of a tick is not differentiable, or not all of it is known.
///
/// * At a limit that is touched without a multiplier, or is active with none: [`Touching`](Self::Touching).
/// * Where what a plug-in writes has a kink, a clamp or a smallest of several: [`Kink`](Self::Kink).
/// * Where limits become active or cease to be: the derivatives hold up to there, and the next ones are others.
/// * Where a tick has no optimum, or its command is not the optimum: that is an error.
/// * In the largest weight, which the regularisation follows, where several entries have it:
///   [`LargestWeight`](Self::LargestWeight). The same holds for the rows of one entry, if their largest weight is that
///   of several: each has its share, and the sum of their columns is right.
/// * In time: ramps, switches of tasks and contacts, and hard rows that become hard at the end of their ramp. At
///   the moment of a tick their state is given, and the derivatives are those with this state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Note {
    /// A limit is touched and does not push: one way it stays behind, the other way it becomes active. The derivatives
    /// are those without it.
    Touching {
        /// Whose; [`Controller::row`](crate::Controller::row) gives the name.
        row: RowId,
        /// Which side.
        side: Side,
    },
    /// What a row is made of has other slopes on the two sides of this parameter's value: a clamp, a smallest of
    /// several. The column is the mean of both.
    Kink {
        /// Position in [`Sensitivity::parameters`](super::Sensitivity::parameters).
        parameter: usize,
    },
    /// The regularisation follows the largest weight, which several tasks or softened constraints have: the columns of
    /// their weights are right if all of them change by the same factor.
    LargestWeight {
        /// One of them: position among all entries, tasks, then constraints.
        entry: usize,
    },
    /// A task or constraint does not say what it remembers from tick to tick, and is not asked again: its rows count as
    /// constant, and it has no columns but those of its weights.
    Unknown {
        /// Position among all entries: tasks, then constraints.
        entry: usize,
    },
}
