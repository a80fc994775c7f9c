//! Dense quadratic programs of a control period, and a solver for them that allocates nothing.
//!
//! # Mathematics
//! ```text
//! minimise   ½ xᵀ H x + gᵀ x
//! subject to row_lower ≤ A x ≤ row_upper,   lower ≤ x ≤ upper
//! ```
//! with H symmetric and positive semidefinite. Limits may be infinite; equal limits make an equality. Multipliers are
//! signed: **positive on an active upper side, negative on an active lower side**, so that at the optimum
//! `H x + g + Aᵀ y + z = 0`.
//!
//! # Example
//! ```
//! use wbqp_qp::{Status, solve};
//!
//! // The point of x₁ + x₂ ≥ 3 with x₁ ≤ 1 that is nearest to zero.
//! let inf = f64::INFINITY;
//! let (h, g) = ([1.0, 0.0, 0.0, 1.0], [0.0, 0.0]);
//! let solution = solve(&h, &g, &[1.0, 1.0], (&[3.0], &[inf]), (&[-inf, -inf], &[1.0, inf]))?;
//! assert_eq!(solution.status, Status::Optimal);
//! assert!((solution.x[0] - 1.0).abs() < 1e-12 && (solution.x[1] - 2.0).abs() < 1e-12);
//! # Ok::<(), wbqp_qp::QpError>(())
//! ```
//! In a loop, make [`Qp`], [`ActiveSet`] and [`Solution`] once for the largest [`Capacity`] and use them again: each
//! solve begins with the constraints that were active in the one before.

/// The readme's examples.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

mod active_set;
mod budget;
mod error;
mod optimality;
mod problem;
mod solver;
mod status;
mod validity;
mod warm_start;

pub use active_set::ActiveSet;
pub use budget::{Budget, Stopwatch};
pub use error::QpError;
pub use optimality::Optimality;
pub use problem::{Capacity, Qp, RowId, VarId};
pub use solver::{QpSolver, Solution};
pub use status::{Defect, Status};
pub use warm_start::{ConstraintId, Held, WarmStart};

/// Solves one problem from dense data, as in [`Qp::dense`]: allocates, and starts cold.
///
/// # Errors
/// [`QpError::Shape`] naming the argument of the wrong length.
pub fn solve(
    h: &[f64],
    g: &[f64],
    a: &[f64],
    rows: (&[f64], &[f64]),
    bounds: (&[f64], &[f64]),
) -> Result<Solution, QpError> {
    let qp = Qp::dense(h, g, a, rows, bounds)?;
    let mut solver = ActiveSet::default();
    solver.bind(qp.capacity())?;
    let mut solution = Solution::new(qp.capacity());
    solver.solve(&qp, Budget::Configured, &mut solution)?;
    Ok(solution)
}
