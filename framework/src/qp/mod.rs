//! The quadratic program of one tick and the solvers for it.
//!
//! # Mathematics
//! ```text
//! minimise   ½ xᵀ H x + gᵀ x
//! subject to row_lower ≤ A x ≤ row_upper,   lower ≤ x ≤ upper
//! ```
//! with `H = 2 Σ AᵀWA` and `g = −2 Σ AᵀWb` over the task rows. Multipliers are signed: **positive on an
//! active upper side, negative on an active lower side**, so that at the optimum
//! `H x + g + Aᵀ y + z = 0`.

mod active_set;
mod clarabel;
mod optimality;
mod polish;
mod problem;
mod scaling;
mod solver;
mod warm_start;

pub use active_set::ActiveSet;
pub use clarabel::Clarabel;
pub use optimality::Optimality;
pub use problem::{Capacity, Qp, RowId, VarId};
pub use solver::{QpSolver, Solution, Status};
pub use warm_start::{ConstraintId, Held, WarmStart};
