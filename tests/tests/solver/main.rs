//! The active-set solver as the controller uses it, judged by certificates; and the files in which problems are given
//! to others.

mod active_set;
mod qp_ticks;
