//! From the rows of the plug-ins to one quadratic program, and back.
//!
//! # Mathematics
//! With the forcing `F = [S  J_cᵀ]` and the known forces `k = Σ J_fᵀ f_f − h` the dynamics read `M v̇ = F (u, f) + k`.
//! Every formulation substitutes some accelerations `v̇_P` and some efforts `τ` from them ([`partition`]), and has the
//! rest as variables x:
//! ```text
//! v̇_P = B x + c        τ = T (v̇, u, f) + t
//! ```
//! ([`reduced`]). Accelerations that hard contacts leave no choice of are substituted from the contacts' rows before
//! that ([`motions`]). Each of the plug-ins' rows `A_v v̇ + A_u u + Σ A_c f_c` is then
//!
//! * a cost ([`cost`]): summed up over the *natural* variables `(v̇, kept u, f, slacks)`, where it is sparse, and taken
//!   to those of the problem once, for all rows together ([`quadratic`]). `H` is `2 Σ w aᵀa` and `g = −2 Σ w b aᵀ`;
//! * a row that must hold ([`constrain`]), over x ([`expand`]);
//! * a bound ([`bounds`]), which on an eliminated effort is a row.
//!
//! A solution goes the way back ([`recover`]): residuals and cost are those of the rows as they were written, in every
//! formulation.
#![allow(non_snake_case)]

mod active_variables;
mod asked;
mod assemble;
mod bounds;
mod constrain;
mod contact_elimination;
mod cost;
mod entry;
mod expand;
mod hessian;
mod kernels;
mod names;
mod partition;
mod recover;
mod reduced_dynamics;
mod relaxation;
mod sparsity;
mod table;
mod tree_cholesky;
mod weight;

pub(crate) use active_variables::ActiveVariables;
use asked::Asked;
pub(crate) use assemble::{DynamicsTerms, Problem, is_equality};
pub(crate) use contact_elimination::ContactElimination;
pub(crate) use entry::{BoundEntry, EntrySpec, Treatment};
use hessian::NaturalCost;
pub(crate) use names::{ProblemRows, VariableNames};
pub(crate) use partition::Partition;
use recover::Recovered;
use reduced_dynamics::ReducedDynamics;
pub(crate) use relaxation::Relaxation;
use sparsity::SparsityPattern;
pub(crate) use table::Table;
pub use table::{RowInfo, VarInfo};
