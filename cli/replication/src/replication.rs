//! Runs experiments side by side. What a run does depends on its scenario and seed alone, not on what runs beside it.

use std::{path::Path, process::ExitCode};

use anyhow::{Context, Result};
use rayon::prelude::*;
use wbqp_log::{LogSink, McapLog};
use wbqp_measures::promises;
use wbqp_replay::DumpFolder;
use wbqp_sim::{LiveWatcher, RunOptions, Scenario, SceneWatcher};
use wbqp_terminal::{Common, ProgressBars, live_address, say, scenario_file};

use crate::{
    experiment::{Case, Experiment, Outcome, Recorded, Runs},
    results,
};

/// Runs, measures and draws experiments, all their cases side by side, and writes everything to `<out>/<name>/`.
///
/// # Errors
/// If a scenario is refused or a file cannot be written. A case that diverged is no error.
pub fn run(experiments: &[Experiment], args: &Common) -> Result<Vec<Outcome>> {
    let bars = ProgressBars::new(2);
    args.in_order(|| {
        experiments
            .par_iter()
            .map(|experiment| finish(experiment, args, None, &bars))
            .collect()
    })
}

/// [`run`] for one experiment, with another scenario than its own if one is given.
///
/// # Errors
/// See [`run`].
pub fn run_one(experiment: &Experiment, args: &Common, scenario: Option<&Path>) -> Result<Outcome> {
    args.in_order(|| finish(experiment, args, scenario, &ProgressBars::new(2)))
}

/// Says on standard output whether everything is as promised; the exit code says the same.
pub fn conclude(outcomes: &[Outcome]) -> ExitCode {
    let promised = outcomes.iter().flat_map(|o| &o.rows);
    let promised = promised.filter(|row| row.pass == Some(true)).count();
    let failed = outcomes.iter().filter(|o| !o.is_as_promised());
    let failed: Vec<&str> = failed.map(|o| o.experiment.measures.name).collect();
    if failed.is_empty() {
        say!("\nAll promised rows are met: {promised}.");
        ExitCode::SUCCESS
    } else {
        say!("\nNot as promised: {}.", failed.join(", "));
        ExitCode::FAILURE
    }
}

fn finish(
    experiment: &Experiment,
    args: &Common,
    scenario: Option<&Path>,
    bars: &ProgressBars,
) -> Result<Outcome> {
    let promises = promises::of(experiment.measures.name)?;
    let scenario = Scenario::from_file(&scenario_file(experiment.measures.name, scenario))?;
    let directory = args.out.join(experiment.measures.name);
    let names: Vec<&str> = scenario.cases().collect();
    let cases = names
        .par_iter()
        .map(|case| run_case(experiment, &scenario, case, args, bars))
        .collect::<Result<Vec<Case>>>()?;
    let runs = Runs::new(&directory, cases);
    let mut outcome = Outcome {
        experiment: *experiment,
        rows: Vec::new(),
        pictures: Vec::new(),
        breaches: Vec::new(),
        runs,
    };
    if outcome.completed() {
        outcome.rows = experiment.measure(&outcome.runs).context("measuring")?;
        outcome.pictures = (experiment.draw)(&outcome.runs).context("drawing")?;
        outcome.breaches = promises.breaches(&outcome.rows);
    }
    let path = directory.join("results.json");
    results::write_json(&outcome.rows, &path).with_context(|| path.display().to_string())?;
    Ok(outcome)
}

/// The most dumps of ticks that a case writes.
const MOST_DUMPS: usize = 4;

/// Runs a case into `<directory>/<case>.mcap`, and dumps of ticks in which the level changed beside it.
fn run_case(
    experiment: &Experiment,
    scenario: &Scenario,
    case: &str,
    args: &Common,
    bars: &ProgressBars,
) -> Result<Case> {
    let directory = args.out.join(experiment.measures.name);
    let path = directory.join(format!("{case}.mcap"));
    let mut log = McapLog::create(&path)?;
    let progress = bars.start(&format!("{}/{case}", experiment.measures.name));
    let mut dumps = DumpFolder::new(directory.join(case), MOST_DUMPS);
    let mut update = |fraction| progress.update(fraction);
    dumps.remove_old()?;
    let mut scene = SceneWatcher::default();
    let mut announce = |port| bars.say(&live_address(port));
    let mut live = args.live.map(|port| LiveWatcher::new(port, &mut announce));
    let options = RunOptions {
        progress: Some(&mut update),
        dumps: Some(&mut dumps),
        watchers: vec![&mut scene, &mut live],
    };
    let summary = wbqp_sim::run_with(scenario, case, args.seed, &mut log, options)?;
    for file in dumps.written() {
        bars.say(&format!(
            "the controller changed its level: {}",
            file.display()
        ));
    }
    log.finish()?;
    progress.finish();
    Ok(Case {
        name: case.to_owned(),
        log: Recorded::File(path),
        diverged: summary.diverged,
        ticks: (summary.ticks, summary.held),
    })
}
