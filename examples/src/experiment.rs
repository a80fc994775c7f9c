//! What all experiments share: run the cases of a scenario into logs, then report.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use wbqp::log::{LogSink, McapLog};
use wbqp_sim::Scenario;

use crate::{
    cli::{Common, Progress, scenario_file},
    log_reader::Log,
    results::{self, Row},
};

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
///
/// # Errors
/// If the scenario is refused or a log cannot be written.
pub fn run_cases(name: &str, args: &Common) -> Result<Runs> {
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
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn with_rows(&self, rows: Vec<Row>) -> Result<Outcome> {
        let path = self.directory.join("results.json");
        results::write_json(&rows, &path).with_context(|| path.display().to_string())?;
        println!("{}", results::table(&rows));
        println!("logs, figures and results: {}", self.directory.display());
        Ok(Outcome {
            rows,
            diverged: self.diverged_cases(),
        })
    }

    /// The outcome of cases that cannot be measured: `results.json` is an empty list.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn without_rows(&self) -> Result<Outcome> {
        self.with_rows(Vec::new())
    }

    fn diverged_cases(&self) -> Vec<(String, f64)> {
        let diverged = |c: &Case| Some((c.name.clone(), c.diverged?));
        self.cases.iter().filter_map(diverged).collect()
    }
}
