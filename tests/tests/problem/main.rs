//! The quadratic program of a tick and its solution: properties in all formulations, contacts that determine
//! accelerations, the solver by certificates, and the files in which problems are given to others.
//!
//! What the solver promises of any problem is tested in `framework/qp/tests`.

mod active_set;
mod hard_contacts;
mod properties;
mod qp_ticks;
mod soft_rows;
