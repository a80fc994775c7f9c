//! Experiment E, force control with an under-actuated base.

use std::process::ExitCode;

use anyhow::Result;
use wbqp_replication::under_actuated;

fn main() -> Result<ExitCode> {
    under_actuated::EXPERIMENT.main()
}
