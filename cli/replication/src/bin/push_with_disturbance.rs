//! Experiment B, pushing with disturbances, with and without force feedback.

use std::process::ExitCode;

use anyhow::Result;
use wbqp_replication::push_with_disturbance;

fn main() -> Result<ExitCode> {
    push_with_disturbance::EXPERIMENT.main()
}
