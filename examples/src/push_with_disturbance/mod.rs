//! Experiment B, pushing with disturbances (paper IV-B, Figs. 2 and 3).

pub mod measures;

use anyhow::{Context, Result};

use crate::{
    cli::Common,
    experiment::{self, Outcome},
    plots::push,
};

/// Name of the scenario and of its directory of results.
pub const NAME: &str = "push_with_disturbance";

/// Runs both cases, measures, draws, and writes everything to `<out>/push_with_disturbance/`.
///
/// # Errors
/// If the scenario is refused or a file cannot be written. A case that diverged is no error: its rows cannot
/// be measured then, and the outcome says so.
pub fn run(args: &Common) -> Result<Outcome> {
    let runs = experiment::run_cases(NAME, args)?;
    if runs.diverged() {
        return runs.without_rows();
    }
    let [with_ft, no_ft] = [runs.log("with_ft")?, runs.log("no_ft")?];
    let rows = measures::rows(&with_ft, &no_ft).context("measuring")?;
    push::draw(&with_ft, &no_ft, runs.directory()).context("drawing")?;
    runs.with_rows(rows)
}
