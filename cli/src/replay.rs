//! Runs dumped ticks again and prints problem, rows by name, solution and active set.

use std::{path::PathBuf, process::ExitCode};

use anyhow::{Context, Result};
use clap::Args;
use wbqp_replay::{Matrices, ProblemTable};
use wbqp_terminal::say;

/// Runs a dumped tick again, bit by bit, and prints it
#[derive(Args, Debug)]
pub struct Arguments {
    /// A file `….tick.toml`.
    file: PathBuf,
    /// Which of its ticks, from 1; the last if not given.
    #[arg(long)]
    tick: Option<usize>,
    /// Where relative paths of the configuration count from, if not where they did.
    #[arg(long)]
    directory: Option<PathBuf>,
    /// Prints all coefficients too.
    #[arg(long)]
    matrices: bool,
}

impl Arguments {
    /// Prints the tick. Succeeds if command and solution are what was recorded, bit by bit.
    ///
    /// # Errors
    /// A file that is no dump, a tick that it does not have, a configuration that is refused.
    pub fn run(&self) -> Result<ExitCode> {
        let dump = wbqp_replay::load(&self.file)?;
        let last = dump.len();
        let tick = self.tick.unwrap_or(last);
        let index = tick.checked_sub(1).filter(|&i| i < last);
        let index =
            index.with_context(|| format!("there is no tick {tick}, the file has 1 to {last}"))?;
        let replayed = wbqp_replay::rerun(&dump, index, self.directory.as_deref())?;
        let controller = &replayed.controller;
        let report = controller.report();
        say!(
            "tick {tick} of {last}, t = {} s, robot {}, {} Hz, written by wbqp {}",
            report.time,
            controller.robot().model.name(),
            controller.settings().rate,
            dump.wbqp,
        );
        if let Some(explanation) = controller.explain() {
            say!("{explanation}\n");
        } else {
            say!("{}\n", report.level.as_str());
        }
        let matrices = if self.matrices {
            Matrices::Shown
        } else {
            Matrices::Hidden
        };
        say!("{}", ProblemTable::new(controller, matrices));
        say!("command");
        for (actuator, effort) in controller
            .robot()
            .actuators
            .iter()
            .zip(&controller.command().effort)
        {
            say!("  {:20} {effort:.9}", actuator.name);
        }
        if replayed.differences.is_empty() {
            say!("\nthe same as recorded, to the bit");
            return Ok(ExitCode::SUCCESS);
        }
        say!("\nNOT the same as recorded:");
        for difference in &replayed.differences {
            say!("  {difference}");
        }
        Ok(ExitCode::FAILURE)
    }
}
