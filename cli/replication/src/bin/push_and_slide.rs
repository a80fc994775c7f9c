//! Experiment C, push and slide, with and without friction compensation, and with a plant heavier than the model.

use std::process::ExitCode;

use anyhow::Result;
use wbqp_replication::push_and_slide;

fn main() -> Result<ExitCode> {
    push_and_slide::EXPERIMENT.main()
}
