//! Experiment D, pushing away from a wall, against the same move far from it.

use std::process::ExitCode;

use anyhow::Result;
use wbqp_replication::push_away;

fn main() -> Result<ExitCode> {
    push_away::EXPERIMENT.main()
}
