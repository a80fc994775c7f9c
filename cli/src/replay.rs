//! Runs dumped ticks again and prints problem, rows by name, solution and active set.

use std::{
    path::{Path, PathBuf},
    process::ExitCode,
};

use anyhow::{Context, Result};
use clap::Args;
use wbqp::{
    ControllerConfig,
    controller::{Dump, FallbackLevel},
    input,
};
use wbqp_replay::{Matrices, ProblemTable};
use wbqp_terminal::{complain, say};

use crate::text::seconds;

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
        self.keep_files(&dump);
        let last = dump.len();
        let tick = self.tick.unwrap_or(last);
        let index = tick.checked_sub(1).filter(|&i| i < last);
        let index = index.with_context(|| {
            let file = self.file.display();
            match last {
                0 => format!("{file} has no ticks"),
                _ => format!("--tick: there is no tick {tick}, {file} has 1 to {last}"),
            }
        })?;
        let replayed = wbqp_replay::rerun(&dump, index, self.directory.as_deref());
        let replayed = replayed.with_context(|| {
            format!(
                "{}: `--directory DIR` is for files that are somewhere else here",
                self.file.display()
            )
        })?;
        let controller = &replayed.controller;
        let report = controller.report();
        say!(
            "tick {tick} of {last}, t = {} s, robot {}, {} Hz, written by wbqp {}",
            seconds(report.time),
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
        // A measurement that cannot be used leads to no problem.
        if controller.problem().n() > 0 {
            say!("{}", ProblemTable::new(controller, matrices));
        } else {
            say!("no problem was built in this tick\n");
        }
        say!("command{}", self.of_what(report.level, &dump)?);
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

    /// Robots' files that are not here are read from the dump.
    fn keep_files(&self, dump: &Dump) {
        // What is no configuration is told of where it is read.
        let table: toml::Table = dump.configuration.parse().unwrap_or_default();
        let robot = table.get("robot");
        let directory = self.directory.as_deref();
        let directory = directory.unwrap_or(Path::new(&dump.directory));
        // In the order in which a robot has them.
        let files = ["file", "rotors", "srdf"].into_iter();
        let files = files.filter_map(|key| robot?.get(key)?.as_str());
        for (file, source) in files.zip(&dump.robot) {
            let file = directory.join(file);
            let is_its_own = Path::new(&source.name).file_name() == file.file_name();
            if is_its_own && !file.exists() {
                complain!(
                    "note: {}: is not here; the text in the dump is taken",
                    file.display()
                );
                input::keep(&file, source.contents.clone().into_bytes());
            }
        }
    }

    /// What a command is, if not a solution.
    fn of_what(&self, level: FallbackLevel, dump: &Dump) -> Result<String> {
        Ok(match level {
            FallbackLevel::Extrapolated => ", the one before".to_owned(),
            FallbackLevel::Safe => {
                let config = ControllerConfig::from_dump(dump, self.directory.as_deref())?;
                format!(" of the fallback law `{}`", config.fallback.typetag_name())
            }
            _ => String::new(),
        })
    }
}
