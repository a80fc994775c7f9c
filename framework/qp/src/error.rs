//! How the solver can be misused. What happens on a robot is a [`Status`](crate::Status), never an error.

use crate::Capacity;

/// A problem or a solver that was put together wrongly.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum QpError {
    /// A setting outside what makes sense.
    #[error("`{key}` {problem}")]
    Setting {
        /// Its name.
        key: &'static str,
        /// What is wrong with it, and what it must be.
        problem: String,
    },
    /// The solver has no workspace yet.
    #[error(
        "the solver has no workspace: call `bind` with the capacity of the largest problem first"
    )]
    NotBound,
    /// A problem that is larger than what storage was made for.
    #[error(
        "{} variables and {} rows exceed the storage, which was made for {} and {}: make it with a larger capacity",
        needed.vars, needed.rows, capacity.vars, capacity.rows
    )]
    Capacity {
        /// The problem's size.
        needed: Capacity,
        /// The storage's.
        capacity: Capacity,
    },
    /// An array of the wrong length.
    #[error("`{name}` has {got} numbers, expected {expected}")]
    Shape {
        /// The argument.
        name: &'static str,
        /// Its length.
        got: usize,
        /// What the others' lengths ask for.
        expected: usize,
    },
    /// Identities that do not ascend, by which a warm start could not find them again.
    #[error("{what} {id} does not follow the one before: ids must ascend")]
    Order {
        /// `row` or `variable`.
        what: &'static str,
        /// The id.
        id: u32,
    },
}
