//! What all experiments share: run the cases of a scenario, then measure and draw from the logs alone.

use std::{
    path::{Path, PathBuf},
    process::ExitCode,
};

use anyhow::{Context, Result, bail};
use clap::Parser;
use wbqp_measures::{Cases, Recording, Row, log::Log, promises::Breach};
use wbqp_terminal::{Common, complain, say};

use crate::{replication, results, robustness};

/// One experiment of the paper, with its figures.
#[derive(Clone, Copy, Debug)]
pub struct Experiment {
    /// Its name, its cases, and how its rows are measured.
    pub measures: wbqp_measures::Experiment,
    /// Draws the figures into [`Runs::directory`].
    pub draw: fn(&Runs) -> Result<Vec<Picture>>,
}

/// A figure in the directory of an experiment.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// File name.
    pub file: String,
    /// What it shows, and which of the paper's figures it corresponds to.
    pub caption: String,
}

impl Picture {
    /// A figure with its caption.
    pub fn new(file: &str, caption: &str) -> Self {
        Self {
            file: file.to_owned(),
            caption: caption.to_owned(),
        }
    }
}

impl Experiment {
    /// The rows of finished runs.
    ///
    /// # Errors
    /// A log that cannot be read or lacks what its rows need.
    pub fn measure(&self, runs: &Runs) -> Result<Vec<Row>> {
        let logs = runs.logs(self.measures.cases)?;
        Ok(self.measures.rows(&logs.cases())?)
    }

    /// Runs all cases, measures, draws, and writes everything to `<out>/<name>/`.
    ///
    /// # Errors
    /// If the scenario is refused or a file cannot be written. A case that diverged is no error: its rows cannot
    /// be measured then, and the outcome says so.
    pub fn run(&self, args: &Common) -> Result<Outcome> {
        replication::run_one(self, args, None)
    }

    /// The binary of this experiment: succeeds if all promised rows are met.
    ///
    /// # Errors
    /// See [`Experiment::run`].
    pub fn main(&self) -> Result<ExitCode> {
        let arguments = Arguments::parse();
        let outcome = replication::run_one(self, &arguments.common, arguments.scenario.as_deref())?;
        outcome.print();
        if arguments.robustness {
            let scenario = arguments.scenario.as_deref();
            robustness::print(&[*self], scenario, arguments.common.seed)?;
        }
        Ok(replication::conclude(&[outcome]))
    }
}

/// Runs one experiment of the paper: logs, figures and a table of results
#[derive(Parser, Debug)]
#[command(version)]
struct Arguments {
    #[command(flatten)]
    common: Common,
    /// Then with one thing at a time that the controller does not know
    #[arg(long)]
    robustness: bool,
    /// Scenario file instead of the one that ships
    #[arg(long, value_name = "FILE")]
    scenario: Option<PathBuf>,
}

/// The finished cases of a scenario.
#[derive(Debug)]
pub struct Runs {
    directory: PathBuf,
    cases: Vec<Case>,
}

/// A finished case.
#[derive(Debug)]
pub(crate) struct Case {
    pub(crate) name: String,
    pub(crate) log: Recorded,
    /// Time at which the plant diverged, s, if it did.
    pub(crate) diverged: Option<f64>,
    /// Ticks, and how many of them kept the last command.
    pub(crate) ticks: (usize, usize),
}

/// Where a log is.
#[derive(Debug)]
pub(crate) enum Recorded {
    /// In an MCAP file.
    File(PathBuf),
    /// In memory.
    Memory(Log),
}

impl Runs {
    pub(crate) fn new(directory: &Path, cases: Vec<Case>) -> Self {
        Self {
            directory: directory.to_owned(),
            cases,
        }
    }

    /// Where logs, figures and results go.
    pub fn directory(&self) -> &Path {
        &self.directory
    }

    /// Names of the cases, in the scenario's order.
    pub fn cases(&self) -> impl Iterator<Item = &str> {
        self.cases.iter().map(|c| c.name.as_str())
    }

    /// Cases that diverged, with the time, s.
    pub fn diverged(&self) -> Vec<(String, f64)> {
        let diverged = |c: &Case| Some((c.name.clone(), c.diverged?));
        self.cases.iter().filter_map(diverged).collect()
    }

    /// Reads the log of a case.
    ///
    /// # Errors
    /// If the scenario has no such case or the log cannot be read.
    pub fn log(&self, case: &str) -> Result<Log> {
        match self.recorded(case)? {
            Recorded::Memory(log) => Ok(log.clone()),
            Recorded::File(path) => {
                Log::open(path).with_context(|| format!("log {}", path.display()))
            }
        }
    }

    /// Reads the logs of some cases.
    ///
    /// # Errors
    /// As [`Runs::log`].
    pub fn logs(&self, cases: &[&'static str]) -> Result<Logs> {
        let read = |case: &&'static str| Ok((*case, self.log(case)?));
        Ok(Logs(cases.iter().map(read).collect::<Result<_>>()?))
    }

    /// The log of a case without its messages: metadata and attachments.
    ///
    /// # Errors
    /// As [`Runs::log`].
    pub fn header(&self, case: &str) -> Result<Log> {
        match self.recorded(case)? {
            Recorded::Memory(log) => Ok(log.clone()),
            Recorded::File(path) => {
                Log::open_header(path).with_context(|| format!("log {}", path.display()))
            }
        }
    }

    fn recorded(&self, case: &str) -> Result<&Recorded> {
        let Some(found) = self.cases.iter().find(|c| c.name == case) else {
            let known: Vec<&str> = self.cases().collect();
            bail!(
                "the experiment needs a case `{case}`, the scenario has {}",
                known.join(", ")
            );
        };
        Ok(&found.log)
    }

    /// Ticks that kept the last command, in words, for each case that has any.
    fn held(&self) -> impl Iterator<Item = String> {
        let held = self.cases.iter().filter(|c| c.ticks.1 > 0);
        held.map(|c| {
            let (ticks, held) = c.ticks;
            format!("{}: {held} of {ticks} ticks kept the last command", c.name)
        })
    }
}

/// Logs of cases, in memory.
#[derive(Debug)]
pub struct Logs(Vec<(&'static str, Log)>);

impl Logs {
    /// By name, for what measures them.
    pub fn cases(&self) -> Cases<'_> {
        let all = self.0.iter();
        all.map(|(name, log)| (*name, log as &dyn Recording))
            .collect()
    }
}

/// What an experiment leaves behind.
#[derive(Debug)]
pub struct Outcome {
    /// The experiment.
    pub experiment: Experiment,
    /// Its logs.
    pub runs: Runs,
    /// Measured rows; empty if a case diverged.
    pub rows: Vec<Row>,
    /// Figures; none if a case diverged.
    pub pictures: Vec<Picture>,
    /// In what the rows differ from what is promised; nothing if a case diverged.
    pub breaches: Vec<Breach>,
}

impl Outcome {
    /// Whether every case ran to its end.
    pub fn completed(&self) -> bool {
        self.runs.diverged().is_empty()
    }

    /// Whether every case ran to its end and all rows are as promised.
    pub fn is_as_promised(&self) -> bool {
        self.completed() && self.breaches.is_empty()
    }

    /// Prints title and table, and what went wrong on standard error.
    pub fn print(&self) {
        let name = self.experiment.measures.name;
        say!("\n{}", self.experiment.measures.title);
        say!("{}", results::table(&self.rows));
        for held in self.runs.held() {
            complain!("{name}/{held}");
        }
        for (case, time) in self.runs.diverged() {
            complain!("{name}/{case}: diverged at {time:.3} s");
        }
        for breach in &self.breaches {
            complain!("{name}: {breach}");
        }
        say!(
            "logs, figures and results: {}",
            self.runs.directory().display()
        );
    }
}
