//! How the rows hold up when the robot, the wall or a gain is not what the scenario says.
//!
//! Every variation runs all cases of all experiments in memory, several at a time; what comes out depends on the plan
//! and on the seed, not on how many.

mod factor;
mod plan;
mod summary;

use std::{
    fs,
    path::{Path, PathBuf},
    sync::atomic::{AtomicUsize, Ordering},
};

use anyhow::{Context, Result};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use wbqp::{input, serde_json};
use wbqp_measures::Row;
use wbqp_sim::{Scenario, Variation};
use wbqp_terminal::{Progress, ProgressBars, say, scenario_file};

use crate::{
    attempt::{Attempt, attempt},
    experiment::{Experiment, Outcome},
};

pub use factor::Factor;
use factor::Nominal;
pub use plan::{Point, percent, plan};
pub use summary::{Worst, text};

/// What a sweep found: `sweep.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sweep {
    /// Seed of the sensors' noise, the same in all runs.
    pub seed: u64,
    /// Simulated cases.
    pub runs: usize,
    /// The variations. The first is none.
    pub points: Vec<Point>,
    /// What came of them.
    pub experiments: Vec<Swept>,
}

/// What became of one experiment. Lists have an entry per point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Swept {
    /// Its name.
    pub name: String,
    /// What a reader sees.
    pub title: String,
    /// Why there are no rows at a point, where there are none: a case diverged or was refused.
    pub stopped: Vec<Option<String>>,
    /// The judged rows.
    pub rows: Vec<SweptRow>,
}

/// A judged row at all points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SweptRow {
    /// Row of the acceptance table.
    pub id: String,
    /// What is measured.
    pub quantity: String,
    /// Its unit.
    pub unit: String,
    /// What is accepted.
    pub tolerance: String,
    /// Values; `null` where there is none.
    pub measured: Vec<Option<f64>>,
    /// Whether it holds; it does not where the experiment stopped.
    pub holds: Vec<bool>,
}

/// Runs all points of all experiments.
///
/// # Errors
/// If a scenario as it ships is refused, or a log lacks what its rows need.
pub fn run(experiments: &[Experiment], points: &[Point], seed: u64) -> Result<Sweep> {
    let mut prepared = Vec::new();
    for experiment in experiments {
        prepared.push(Prepared::new(experiment)?);
    }
    let per_point: usize = prepared.iter().map(|p| p.cases.len()).sum();
    let runs = per_point * points.len();
    say!(
        "\nSweep: {} variations, {runs} runs. One quantity at a time, and random combinations: {}.",
        points.len(),
        points.iter().filter(|p| p.is_combination()).count()
    );
    let bars = ProgressBars::new(10);
    let done = Done {
        of: runs,
        count: AtomicUsize::new(0),
        bar: bars.start("sweep"),
    };
    let jobs: Vec<(&Prepared<'_>, &Point)> = prepared
        .iter()
        .flat_map(|p| points.iter().map(move |point| (p, point)))
        .collect();
    let attempts: Vec<Attempt> = jobs
        .par_iter()
        .map(|(prepared, point)| prepared.attempt(point, seed, &done))
        .collect::<Result<_>>()?;
    done.bar.finish();
    let swept = prepared.iter().zip(attempts.chunks(points.len().max(1)));
    Ok(Sweep {
        seed,
        runs,
        points: points.to_vec(),
        experiments: swept.map(|(p, a)| Swept::new(p.experiment, a)).collect(),
    })
}

struct Done {
    of: usize,
    count: AtomicUsize,
    bar: Progress,
}

impl Done {
    fn one_more(&self) {
        let count = 1 + self.count.fetch_add(1, Ordering::Relaxed);
        self.bar.update(count as f64 / self.of as f64);
    }
}

/// An experiment with what its variations start from.
struct Prepared<'a> {
    experiment: &'a Experiment,
    scenario: Scenario,
    cases: Vec<(String, Nominal)>,
}

impl<'a> Prepared<'a> {
    fn new(experiment: &'a Experiment) -> Result<Self> {
        let scenario = Scenario::from_file(&scenario_file(experiment.measures.name, None))?;
        let mut cases = Vec::new();
        for case in scenario.cases() {
            cases.push((case.to_owned(), Nominal::of(&scenario, case)?));
        }
        Ok(Self {
            experiment,
            scenario,
            cases,
        })
    }

    fn attempt(&self, point: &Point, seed: u64, done: &Done) -> Result<Attempt> {
        let variation = |nominal: &Nominal| {
            let scales = point.scales.iter();
            scales.fold(Variation::new(), |variation, (factor, scale)| {
                nominal.scaled(variation, *factor, *scale)
            })
        };
        let cases = self.cases.iter();
        let variations: Vec<_> = cases
            .map(|(case, nominal)| (case.clone(), variation(nominal)))
            .collect();
        let ran = AtomicUsize::new(0);
        let counted = || {
            ran.fetch_add(1, Ordering::Relaxed);
            done.one_more();
        };
        let attempt = attempt(&self.scenario, &variations, seed, &counted, |runs| {
            self.experiment.measure(runs)
        });
        (ran.into_inner()..self.cases.len()).for_each(|_| done.one_more());
        attempt.with_context(|| point.words())
    }
}

impl Swept {
    fn new(experiment: &Experiment, attempts: &[Attempt]) -> Self {
        let mut rows: Vec<SweptRow> = Vec::new();
        let mut stopped = vec![None; attempts.len()];
        for (point, attempt) in attempts.iter().enumerate() {
            let measured = match attempt {
                Attempt::Measured(measured) => measured,
                Attempt::Stopped(why) => {
                    stopped[point] = Some(why.clone());
                    continue;
                }
            };
            for row in measured {
                let Some(holds) = row.pass else { continue };
                let known = rows.iter().position(|r| r.is(row));
                let index = known.unwrap_or_else(|| {
                    rows.push(SweptRow::nowhere(row, attempts.len()));
                    rows.len() - 1
                });
                rows[index].measured[point] = row.measured;
                rows[index].holds[point] = holds;
            }
        }
        Self {
            name: experiment.measures.name.to_owned(),
            title: experiment.measures.title.to_owned(),
            stopped,
            rows,
        }
    }
}

impl SweptRow {
    /// Not measured anywhere yet.
    fn nowhere(row: &Row, points: usize) -> Self {
        Self {
            id: row.id.clone(),
            quantity: row.quantity.clone(),
            unit: row.unit.clone(),
            tolerance: row.tolerance.clone(),
            measured: vec![None; points],
            holds: vec![false; points],
        }
    }

    fn is(&self, row: &Row) -> bool {
        self.id == row.id && self.quantity == row.quantity
    }
}

impl Sweep {
    /// The combinations with their numbers.
    pub fn combinations(&self) -> impl Iterator<Item = (usize, &Point)> {
        let points = self.points.iter().filter(|p| p.is_combination());
        points.enumerate().map(|(i, point)| (i + 1, point))
    }

    /// What a table calls a variation: what it scales, or the number of the combination.
    pub fn name(&self, point: usize) -> String {
        let Some(found) = self.points.get(point) else {
            return String::new();
        };
        if !found.is_combination() {
            return found.words();
        }
        let until = self.points.iter().take(point + 1);
        let number = until.filter(|p| p.is_combination()).count();
        format!("combination {number}")
    }

    /// The file in an output directory.
    pub fn file(out: &Path) -> PathBuf {
        out.join("sweep.json")
    }

    /// Writes `<out>/sweep.json`, and returns where that is.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&self, out: &Path) -> Result<PathBuf> {
        let path = Self::file(out);
        let mut text = serde_json::to_string(self)?;
        text.push('\n');
        fs::create_dir_all(out).with_context(|| out.display().to_string())?;
        fs::write(&path, text).with_context(|| path.display().to_string())?;
        Ok(path)
    }

    /// Reads `<out>/sweep.json` if there is a sweep that belongs to these outcomes: its runs without variation have the
    /// same rows. One of another seed, version or scenario does not.
    pub fn read_for(outcomes: &[Outcome], out: &Path) -> Option<Self> {
        let text = input::read(&Self::file(out), input::LARGEST_RECORD).ok()?;
        let sweep: Self = serde_json::from_slice(&text).ok()?;
        sweep.belongs_to(outcomes).then_some(sweep)
    }

    fn belongs_to(&self, outcomes: &[Outcome]) -> bool {
        let same = |(swept, outcome): (&Swept, &Outcome)| {
            let judged = outcome.rows.iter().filter(|row| row.pass.is_some());
            let plain = swept.rows.iter().map(|row| row.measured.first().copied());
            let measured = judged.clone().map(|row| Some(row.measured));
            swept.name == outcome.experiment.measures.name
                && plain.eq(measured)
                && swept.rows.iter().zip(judged).all(|(s, row)| s.is(row))
        };
        self.points.first().is_some_and(Point::is_plain)
            && self.experiments.len() == outcomes.len()
            && self.experiments.iter().zip(outcomes).all(same)
    }
}
