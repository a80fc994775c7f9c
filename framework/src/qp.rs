//! The quadratic program of one tick and the solvers for it: the crate `wbqp-qp`, whose items are all here, and what
//! makes a solver one that configurations can name.
//!
//! # Mathematics
//! ```text
//! minimise   ½ xᵀ H x + gᵀ x
//! subject to row_lower ≤ A x ≤ row_upper,   lower ≤ x ≤ upper
//! ```
//! with `H = 2 Σ AᵀWA` and `g = −2 Σ AᵀWb` over the task rows.

use std::any::Any;

#[cfg(feature = "clarabel")]
#[doc(no_inline)]
pub use wbqp_clarabel::Clarabel;
#[doc(no_inline)]
pub use wbqp_qp::{
    ActiveSet, Budget, Capacity, ConstraintId, Defect, Held, Optimality, Qp, QpError, QpSolver,
    RowId, Solution, Status, VarId, WarmStart,
};

use crate::error::BindError;

/// A solver that a configuration names by `type`: registered by `#[wbqp::solver("tag")]` on its implementation, which
/// is empty.
///
/// ```
/// use wbqp::{
///     qp::{Budget, Capacity, Qp, QpError, QpSolver, Solution, Solver, Status},
///     schemars::JsonSchema,
///     serde::{Deserialize, Serialize},
/// };
///
/// /// Says of every problem that it was cut short.
/// #[derive(Debug, Serialize, Deserialize, JsonSchema)]
/// #[serde(crate = "wbqp::serde", deny_unknown_fields)]
/// #[schemars(crate = "wbqp::schemars")]
/// struct Idle {}
///
/// impl QpSolver for Idle {
///     fn bind(&mut self, _: Capacity) -> Result<(), QpError> {
///         Ok(())
///     }
///     fn memory(&self, _: Capacity) -> usize {
///         0
///     }
///     fn solve(&mut self, _: &Qp, _: Budget<'_>, out: &mut Solution) -> Result<Status, QpError> {
///         out.status = Status::IterationLimit;
///         Ok(out.status)
///     }
/// }
///
/// #[wbqp::solver("example.idle")]
/// impl Solver for Idle {}
///
/// assert!(wbqp::registry::find::<dyn Solver>("example.idle").is_some());
/// ```
#[typetag::serde(tag = "type")]
pub trait Solver: QpSolver + Any {}

#[wbqp::solver("active_set")]
impl Solver for ActiveSet {}

#[cfg(feature = "clarabel")]
#[wbqp::solver("clarabel")]
impl Solver for Clarabel {}

impl From<QpError> for BindError {
    fn from(error: QpError) -> Self {
        match error {
            QpError::Setting { key, problem } => Self::value(key, problem),
            other => Self::Other(other.to_string()),
        }
    }
}
