//! What all experiments share: run the cases of a scenario into logs, then measure and draw from the logs alone.

use std::{
    path::{Path, PathBuf},
    process::ExitCode,
};

use anyhow::{Context, Result, bail};
use clap::Parser;
use wbqp::log::{LogSink, McapLog};
use wbqp_sim::Scenario;

use crate::{
    cli::{Common, Progress, scenario_file},
    log_reader::Log,
    results::{self, Row},
};

/// One experiment of the paper.
#[derive(Clone, Copy, Debug)]
pub struct Experiment {
    /// Name of its scenario, and of its directory of results.
    pub name: &'static str,
    /// What a reader sees, with the paper's section.
    pub title: &'static str,
    /// Measures the logs.
    pub measure: fn(&Runs) -> Result<Vec<Row>>,
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
    /// Runs all cases, measures, draws, and writes everything to `<out>/<name>/`.
    ///
    /// # Errors
    /// If the scenario is refused or a file cannot be written. A case that diverged is no error: its rows cannot
    /// be measured then, and the outcome says so.
    pub fn run(&self, args: &Common) -> Result<Outcome> {
        let runs = run_cases(self.name, args)?;
        let (rows, pictures) = if runs.diverged() {
            (Vec::new(), Vec::new())
        } else {
            (
                (self.measure)(&runs).context("measuring")?,
                (self.draw)(&runs).context("drawing")?,
            )
        };
        runs.finish(rows, pictures)
    }

    /// The binary of this experiment.
    ///
    /// # Errors
    /// See [`Experiment::run`].
    pub fn main(&self) -> Result<ExitCode> {
        let arguments = Arguments::parse();
        let outcome = self.run(&arguments.common)?;
        Ok(if outcome.completed() {
            ExitCode::SUCCESS
        } else {
            ExitCode::FAILURE
        })
    }
}

/// Runs one experiment of the paper: logs, figures and a table of results
#[derive(Parser, Debug)]
#[command(version)]
struct Arguments {
    #[command(flatten)]
    common: Common,
}

/// The finished cases of a scenario.
#[derive(Debug)]
pub struct Runs {
    directory: PathBuf,
    cases: Vec<Case>,
}

#[derive(Debug)]
struct Case {
    name: String,
    log: PathBuf,
    diverged: Option<f64>,
}

/// What an experiment leaves behind.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Measured rows; empty if a case diverged.
    pub rows: Vec<Row>,
    /// Figures; none if a case diverged.
    pub pictures: Vec<Picture>,
    /// Cases that diverged, with the time, s.
    pub diverged: Vec<(String, f64)>,
}

impl Outcome {
    /// Whether every case ran to its end.
    pub fn completed(&self) -> bool {
        self.diverged.is_empty()
    }
}

/// Runs every case of a scenario into `<out>/<name>/<case>.mcap`.
fn run_cases(name: &str, args: &Common) -> Result<Runs> {
    let file = scenario_file(name, args.scenario.as_deref());
    let scenario = Scenario::from_file(&file)?;
    let directory = args.out.join(name);
    let mut cases = Vec::new();
    for case in scenario.cases() {
        let path = directory.join(format!("{case}.mcap"));
        let mut log = McapLog::create(&path)?;
        let progress = Progress::new(&format!("{name}/{case}"));
        let summary = wbqp_sim::run(&scenario, case, args.seed, &mut log, &mut |fraction| {
            progress.update(fraction);
        })?;
        log.finish()?;
        progress.finish();
        if summary.held > 0 {
            eprintln!(
                "{name}/{case}: {} of {} ticks kept the last command",
                summary.held, summary.ticks
            );
        }
        if let Some(time) = summary.diverged {
            eprintln!("{name}/{case}: diverged at {time:.3} s");
        }
        cases.push(Case {
            name: case.to_owned(),
            log: path,
            diverged: summary.diverged,
        });
    }
    Ok(Runs { directory, cases })
}

impl Runs {
    /// Where logs, figures and results go.
    pub fn directory(&self) -> &Path {
        &self.directory
    }

    /// Whether any case diverged.
    pub fn diverged(&self) -> bool {
        self.cases.iter().any(|c| c.diverged.is_some())
    }

    /// Reads the log of a case.
    ///
    /// # Errors
    /// If the scenario has no such case or the log cannot be read.
    pub fn log(&self, case: &str) -> Result<Log> {
        let Some(found) = self.cases.iter().find(|c| c.name == case) else {
            let known: Vec<&str> = self.cases.iter().map(|c| c.name.as_str()).collect();
            bail!(
                "the experiment needs a case `{case}`, the scenario has {}",
                known.join(", ")
            );
        };
        Log::open(&found.log).with_context(|| format!("log {}", found.log.display()))
    }

    /// Writes `results.json` and prints the table.
    fn finish(&self, rows: Vec<Row>, pictures: Vec<Picture>) -> Result<Outcome> {
        let path = self.directory.join("results.json");
        results::write_json(&rows, &path).with_context(|| path.display().to_string())?;
        println!("{}", results::table(&rows));
        println!("logs, figures and results: {}", self.directory.display());
        Ok(Outcome {
            rows,
            pictures,
            diverged: self.diverged_cases(),
        })
    }

    fn diverged_cases(&self) -> Vec<(String, f64)> {
        let diverged = |c: &Case| Some((c.name.clone(), c.diverged?));
        self.cases.iter().filter_map(diverged).collect()
    }
}
