//! From the rows of the plug-ins to one quadratic program, and back.
//!
//! # Mathematics
//! With `B = M⁻¹ [S  J_cᵀ]` and `c = M⁻¹ (Σ J_fᵀ f_f − h)` the dynamics read `v̇ = B (u, f) + c`. A row
//! `A_v v̇ + A_u u + A_f f = b` becomes `(A_v B + [A_u A_f]) (u, f) = b − A_v c` in the **condensed**
//! formulation (the paper's (8)), and stays as it is in the **explicit** one, where the dynamics
//! `M v̇ − S u − J_cᵀ f = Σ J_fᵀ f_f − h` are equality rows. Cost rows add `2 w aᵀa` to `H` and `−2 w aᵀb` to
//! `g`; slacks of soft inequalities follow the force components.
#![allow(non_snake_case)]

mod actuation;
mod assemble;
mod cholesky;
mod elastic;
mod expand;
mod group;
mod kernels;
mod live;
mod partition;
mod quadratic;
mod recover;
mod relations;
mod table;
mod weight;

pub(crate) use actuation::Actuation;
pub(crate) use assemble::{Assembly, DynamicsTerms, ProblemRows, VariableNames, is_equality};
pub(crate) use elastic::Elastic;
pub(crate) use group::{Group, GroupSpec, Treatment};
pub(crate) use live::Live;
pub(crate) use partition::Partition;
use quadratic::Quadratic;
use recover::Recovered;
use relations::Relations;
pub(crate) use table::Table;
pub use table::{RowInfo, VarInfo};
