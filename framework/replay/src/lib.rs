//! Ticks that are recorded, dumped to a file, and run again bit by bit.
//!
//! # What a tick is a function of
//! The configuration, the measurement, the rows that the plug-ins wrote, and what the controller remembers: ramps,
//! filters, the observer, the last solution, velocity references, the level, the memory of the fallback law, and the
//! solvers' warm starts. A
//! [`Dump`](wbqp::controller::Dump) holds all of it and what came out. Running it again computes kinematics,
//! dynamics, problem, solution and command anew, from the recorded state and the recorded rows. The rows are data
//! because a plug-in may remember things of its own (an integral, a trajectory) that the framework cannot see; a
//! plug-in is tested with the crate `wbqp-testing`.
//!
//! # How
//! [`Controller::with_recorder`](wbqp::Controller::with_recorder) keeps the last ticks in storage made once; in a
//! tick, numbers are copied and nothing is allocated. Between two ticks
//! [`Controller::take_dump`](wbqp::Controller::take_dump) gives them as a [`Dump`](wbqp::controller::Dump) if the
//! level has changed since it was last asked, and [`Controller::dump`](wbqp::Controller::dump) gives them any time.
//! [`DumpFolder`] writes a bounded number of them to files, which are TOML: exact numbers that a person can read.
//! [`rerun`] runs a record again and compares command and solution, to the last digit.

mod dump_file;
mod folder;
mod rerun;
mod table;

pub use dump_file::{DumpError, load, save};
pub use folder::DumpFolder;
pub use rerun::{Difference, Replayed, rerun};
pub use table::{Matrices, ProblemTable};
