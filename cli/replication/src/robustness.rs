//! Whether the rows hold that are to hold with one thing at a time that is not as the controller believes.

use std::path::Path;

use anyhow::Result;
use comfy_table::{Cell, CellAlignment, Table, presets};
use rayon::prelude::*;
use wbqp_measures::{
    number,
    robust::{ROWS, Robust},
};
use wbqp_sim::{Perturbation, Scenario};
use wbqp_terminal::{ProgressBars, say, scenario_file};

use crate::{
    attempt::{Attempt, attempt},
    experiment::Experiment,
};

/// Which of the two variants of an experiment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variant {
    /// The paper's gains.
    Papers,
    /// The same with an observer of the unknown wrench.
    Robust,
}

impl Variant {
    fn words(self) -> &'static str {
        match self {
            Self::Papers => "With the paper's gains",
            Self::Robust => "With an observer",
        }
    }

    fn cases(self, robust: &Robust) -> &'static [&'static str] {
        match self {
            Self::Papers => robust.papers,
            Self::Robust => robust.robust,
        }
    }
}

/// What became of a variant of an experiment with one perturbation.
#[derive(Clone, Debug)]
pub struct Perturbed {
    /// The experiment's title.
    pub title: &'static str,
    /// Which of its variants.
    pub variant: Variant,
    /// What was varied.
    pub perturbation: Perturbation,
    /// Its rows, or why there are none.
    pub attempt: Attempt,
}

impl Perturbed {
    /// Whether all [rows that are to hold](ROWS) do.
    pub fn holds(&self) -> bool {
        match &self.attempt {
            Attempt::Measured(rows) => rows.iter().all(|row| row.pass == Some(true)),
            Attempt::Stopped(_) => false,
        }
    }
}

/// Runs a variant with a perturbation and measures the rows that are to hold.
///
/// # Errors
/// If the scenario as it ships is refused, or a recording lacks what its rows need.
pub fn perturbed(
    experiment: &Experiment,
    robust: &Robust,
    scenario: &Scenario,
    (variant, perturbation): (Variant, Perturbation),
    seed: u64,
) -> Result<Perturbed> {
    let cases = variant.cases(robust);
    let vary = |case: &&str| {
        let variation = perturbation.variation(scenario, case)?;
        Ok(((*case).to_owned(), variation))
    };
    let variations = cases.iter().map(vary).collect::<Result<Vec<_>>>()?;
    let attempt = attempt(scenario, &variations, seed, &|| (), |runs| {
        Ok(robust.rows(cases, &runs.logs(cases)?.cases())?)
    });
    Ok(Perturbed {
        title: experiment.measures.title,
        variant,
        perturbation,
        attempt: attempt?,
    })
}

/// Runs every perturbation of both variants of every experiment that has such rows, of another scenario than their own
/// if one is given.
///
/// # Errors
/// If a scenario as it ships is refused, or a recording lacks what its rows need.
pub fn run(
    experiments: &[Experiment],
    scenario: Option<&Path>,
    seed: u64,
) -> Result<Vec<Perturbed>> {
    let bars = ProgressBars::new(2);
    let progress = bars.start("robustness");
    let with_rows = experiments
        .iter()
        .filter_map(|experiment| Some((experiment, experiment.measures.robust?)));
    let read = |(experiment, robust): (&Experiment, Robust)| {
        let file = scenario_file(experiment.measures.name, scenario);
        Ok((*experiment, robust, Scenario::from_file(&file)?))
    };
    let with_rows = with_rows.map(read).collect::<Result<Vec<_>>>()?;
    let mut jobs = Vec::new();
    for variant in [Variant::Papers, Variant::Robust] {
        for one in &with_rows {
            jobs.extend(Perturbation::ALL.map(|perturbation| (one, (variant, perturbation))));
        }
    }
    let done = std::sync::atomic::AtomicUsize::new(0);
    let found = jobs
        .par_iter()
        .map(|((experiment, robust, scenario), what)| {
            let found = perturbed(experiment, robust, scenario, *what, seed)?;
            let count = 1 + done.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            progress.update(count as f64 / jobs.len() as f64);
            Ok(found)
        });
    let found: Result<Vec<Perturbed>> = found.collect();
    progress.finish();
    found
}

/// Runs, and prints the tables and how many hold.
///
/// # Errors
/// See [`run`].
pub fn print(experiments: &[Experiment], scenario: Option<&Path>, seed: u64) -> Result<()> {
    let found = run(experiments, scenario, seed)?;
    for same in found.chunk_by(|a, b| a.variant == b.variant) {
        let held = same.iter().filter(|one| one.holds()).count();
        let (words, rows) = (same[0].variant.words(), ROWS.join(", "));
        say!("\n{words}\n{}", text(same));
        say!("{words} all of {rows} hold in {held} of {}.", same.len());
    }
    Ok(())
}

/// A table per experiment for a terminal: a line per perturbation, a column per row.
fn text(found: &[Perturbed]) -> String {
    let mut text = String::new();
    for same in found.chunk_by(|a, b| a.title == b.title) {
        let mut table = Table::new();
        table.load_preset(presets::UTF8_FULL_CONDENSED);
        let mut lines: Vec<(String, Vec<String>)> = Vec::new();
        for (at, perturbed) in same.iter().enumerate() {
            let Attempt::Measured(rows) = &perturbed.attempt else {
                continue;
            };
            for row in rows {
                let Some(pass) = row.pass else { continue };
                let name = format!("{} {} [{}]", row.id, row.quantity, row.tolerance);
                let mark = if pass { "" } else { " ✗" };
                let cell = format!("{}{mark}", row.measured.map_or("–".into(), number));
                let known = lines.iter().position(|(known, _)| *known == name);
                let index = known.unwrap_or_else(|| {
                    lines.push((name, vec!["–".to_owned(); same.len()]));
                    lines.len() - 1
                });
                lines[index].1[at] = cell;
            }
        }
        let mut header = vec!["with".to_owned()];
        header.extend(lines.iter().map(|(name, _)| name.clone()));
        table.set_header(header);
        for (at, perturbed) in same.iter().enumerate() {
            let mut cells = vec![Cell::new(perturbed.perturbation.words())];
            match &perturbed.attempt {
                Attempt::Measured(_) => {
                    cells.extend(lines.iter().map(|(_, values)| {
                        Cell::new(&values[at]).set_alignment(CellAlignment::Right)
                    }));
                }
                Attempt::Stopped(why) => cells.push(Cell::new(why)),
            }
            table.add_row(cells);
        }
        text.push_str(&format!("\n{}\n{table}\n", same[0].title));
    }
    text
}
