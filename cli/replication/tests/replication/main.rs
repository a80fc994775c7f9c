//! The replication: figures, exit codes, report and sweep.

mod figures;
mod runs;
#[path = "../../../../simulation/measures/tests/stories/mod.rs"]
mod stories;
