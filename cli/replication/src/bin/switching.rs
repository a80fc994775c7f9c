//! What switching contacts, tasks, weights and set points does to the commands.

use std::process::ExitCode;

use anyhow::Result;
use wbqp_replication::switching;

fn main() -> Result<ExitCode> {
    switching::EXPERIMENT.main()
}
