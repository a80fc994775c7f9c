//! From the rows of the plug-ins to one quadratic program, and back.
//!
//! # Mathematics
//! With the forcing `F = [S  J_cᵀ]` and the known forces `k = Σ J_fᵀ f_f − h` the dynamics read `M v̇ = F (u, f) + k`.
//! Every formulation substitutes some accelerations `v̇_P` and some efforts `τ` from them ([`partition`]), and has the
//! rest as variables x:
//! ```text
//! v̇_P = B x + c        τ = T (v̇, u, f) + t
//! ```
//! ([`relations`]). Accelerations that hard contacts leave no choice of are substituted from the contacts' rows before
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

mod actuation;
mod asked;
mod assemble;
mod bounds;
mod cholesky;
mod constrain;
mod cost;
mod elastic;
mod expand;
mod group;
mod kernels;
mod live;
mod motions;
mod names;
mod partition;
mod quadratic;
mod recover;
mod relations;
mod support;
mod table;
mod weight;

pub(crate) use actuation::Actuation;
use asked::Asked;
pub(crate) use assemble::{Assembly, DynamicsTerms, is_equality};
pub(crate) use elastic::Elastic;
pub(crate) use group::{Group, GroupSpec, Treatment};
pub(crate) use live::Live;
pub(crate) use motions::Motions;
pub(crate) use names::{ProblemRows, VariableNames};
pub(crate) use partition::Partition;
use quadratic::Quadratic;
use recover::Recovered;
use relations::Relations;
use support::Support;
pub(crate) use table::Table;
pub use table::{RowInfo, VarInfo};
