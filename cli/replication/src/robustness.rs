//! Whether the rows hold with one thing at a time that is not as the controller believes.
//!
//! What is varied is in the plant and the sensors alone: masses, thrusts, a constant error of the force sensor,
//! differences between rotors, velocities that are estimated from positions, stiffer and softer walls, faster and
//! slower servos.

use std::path::Path;

use anyhow::Result;
use comfy_table::{Cell, CellAlignment, Table, presets};
use rayon::prelude::*;
use toml::Value;
use wbqp_measures::{
    Row, number,
    robust::{ROWS, is_papers, is_robust},
};
use wbqp_sim::{Scenario, Variation};
use wbqp_terminal::{ProgressBars, say, scenario_file};

use crate::{
    attempt::{Attempt, attempt},
    experiment::Experiment,
};

/// One thing that is not as the controller believes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Perturbation {
    /// Nothing: as it ships.
    None,
    /// Factor on every mass and inertia.
    Mass(f64),
    /// Factor on the thrust of every rotor.
    Thrust(f64),
    /// Constant error of the force sensors along each of their axes, N.
    ForceBias(f64),
    /// Rotors are stronger and weaker by this share, in turn.
    RotorsInTurn(f64),
    /// The first half of the rotors is stronger, the other weaker by this share.
    RotorsByHalves(f64),
    /// All velocities are differences of measured positions through a low-pass with this cut-off, Hz.
    EstimatedVelocities(f64),
    /// Stiffness of the walls, N/m.
    Wall(f64),
    /// Factor on the time constant of the joints' servos.
    Servo(f64),
}

/// All that is tried.
pub const ALL: [Perturbation; 15] = [
    Perturbation::None,
    Perturbation::Mass(0.95),
    Perturbation::Mass(1.05),
    Perturbation::Thrust(0.95),
    Perturbation::Thrust(1.05),
    Perturbation::ForceBias(-0.2),
    Perturbation::ForceBias(0.2),
    Perturbation::RotorsInTurn(0.02),
    Perturbation::RotorsByHalves(0.02),
    Perturbation::EstimatedVelocities(30.0),
    Perturbation::Wall(5e3),
    Perturbation::Wall(2e4),
    Perturbation::Wall(1e5),
    Perturbation::Servo(0.5),
    Perturbation::Servo(1.5),
];

impl Perturbation {
    /// In words.
    pub fn words(self) -> String {
        match self {
            Self::None => "as it ships".to_owned(),
            Self::Mass(scale) => format!("mass × {scale}"),
            Self::Thrust(scale) => format!("thrust × {scale}"),
            Self::ForceBias(bias) => format!("force bias {bias} N"),
            Self::RotorsInTurn(share) => format!("rotors ± {} % in turn", 100.0 * share),
            Self::RotorsByHalves(share) => format!("rotors ± {} % by halves", 100.0 * share),
            Self::EstimatedVelocities(cutoff) => format!("velocities estimated, {cutoff} Hz"),
            Self::Wall(stiffness) => format!("wall {} kN/m", stiffness / 1e3),
            Self::Servo(scale) => format!("servo time × {scale}"),
        }
    }

    /// What a case is changed by.
    ///
    /// # Errors
    /// If the scenario has no such case, or its robot cannot be loaded.
    pub fn variation(self, scenario: &Scenario, case: &str) -> Result<Variation> {
        let none = Variation::new();
        let found = scenario.case(case)?;
        let plant = found.plant();
        let rotors = |scale: &dyn Fn(usize, usize) -> f64| -> Result<Variation> {
            let config = scenario.controller_config(case)?;
            let count = config.robot.load(&config.directory)?.rotors().count();
            let scales = (0..count).map(|i| Value::from(scale(i, count)));
            let scales = Value::Array(scales.collect());
            Ok(Variation::new().change("plant.mismatch.rotor_scales", scales))
        };
        Ok(match self {
            Self::None => none,
            Self::Mass(scale) => {
                let own = plant.mismatch.mass_scale;
                none.change("plant.mismatch.mass_scale", scale * own)
            }
            Self::Thrust(scale) => {
                let own = plant.mismatch.thrust_scale;
                none.change("plant.mismatch.thrust_scale", scale * own)
            }
            Self::ForceBias(bias) => {
                let sensors = found.sensors().force_torque.iter();
                sensors.fold(none, |variation, sensor| {
                    let biased = sensor.force_bias.map(|own| Value::from(own + bias));
                    let path = format!("sensors.force_torque.{}.force_bias", sensor.frame);
                    variation.change(&path, Value::Array(biased.to_vec()))
                })
            }
            Self::RotorsInTurn(share) => {
                rotors(&|i, _| if i % 2 == 0 { 1.0 + share } else { 1.0 - share })?
            }
            Self::RotorsByHalves(share) => {
                rotors(&|i, n| if 2 * i < n { 1.0 + share } else { 1.0 - share })?
            }
            Self::EstimatedVelocities(cutoff) => none
                .change("sensors.base.velocity_cutoff", cutoff)
                .change("sensors.joints.velocity_cutoff", cutoff),
            Self::Wall(stiffness) => plant.walls.iter().fold(none, |variation, wall| {
                let path = format!("plant.wall.{}.stiffness", wall.name);
                variation.change(&path, stiffness)
            }),
            Self::Servo(scale) => {
                let own = plant.servo.time_constant;
                none.change("plant.servo.time_constant", scale * own)
            }
        })
    }
}

/// What became of an experiment with one perturbation.
#[derive(Clone, Debug)]
pub struct Perturbed {
    /// The experiment's title.
    pub title: &'static str,
    /// What was varied.
    pub perturbation: Perturbation,
    /// Its rows, or why there are none.
    pub attempt: Attempt,
}

impl Perturbed {
    /// Whether all [rows that are to hold](ROWS) do in the robust variant.
    pub fn holds(&self) -> bool {
        self.holds_all(is_robust)
    }

    fn holds_all(&self, which: fn(&Row) -> bool) -> bool {
        match &self.attempt {
            Attempt::Measured(rows) => rows
                .iter()
                .filter(|row| which(row))
                .all(|row| row.pass == Some(true)),
            Attempt::Stopped(_) => false,
        }
    }
}

/// Runs every perturbation of every experiment that has such rows, of another scenario than their own if one is given.
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
    let read = |experiment: &Experiment| {
        Scenario::from_file(&scenario_file(experiment.measures.name, scenario))
    };
    let scenarios: Vec<Scenario> = experiments.iter().map(read).collect::<Result<_, _>>()?;
    let jobs: Vec<_> = experiments
        .iter()
        .zip(&scenarios)
        .flat_map(|pair| ALL.map(|perturbation| (pair, perturbation)))
        .collect();
    let done = std::sync::atomic::AtomicUsize::new(0);
    let found = jobs
        .par_iter()
        .map(|((experiment, scenario), perturbation)| {
            let variation = |case: &str| perturbation.variation(scenario, case);
            let cases = scenario.cases();
            let variations = cases
                .map(|case| Ok((case.to_owned(), variation(case)?)))
                .collect::<Result<Vec<_>>>()?;
            let attempt = attempt(experiment, scenario, &variations, seed, &|| ())?;
            let count = 1 + done.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            progress.update(count as f64 / jobs.len() as f64);
            Ok(Perturbed {
                title: experiment.measures.title,
                perturbation: *perturbation,
                attempt,
            })
        });
    let found: Result<Vec<Perturbed>> = found.collect();
    progress.finish();
    Ok(found?.into_iter().filter(is_judged).collect())
}

fn is_judged(perturbed: &Perturbed) -> bool {
    match &perturbed.attempt {
        Attempt::Measured(rows) => rows.iter().any(is_robust),
        Attempt::Stopped(_) => true,
    }
}

/// Runs, and prints the tables and how many hold.
///
/// # Errors
/// See [`run`].
pub fn print(experiments: &[Experiment], scenario: Option<&Path>, seed: u64) -> Result<()> {
    let found = run(experiments, scenario, seed)?;
    for (variant, which) in [
        ("With the paper's gains", is_papers as fn(&Row) -> bool),
        ("With an observer", is_robust),
    ] {
        let held = found.iter().filter(|one| one.holds_all(which)).count();
        say!("{}", text(&found, which));
        say!(
            "{variant} all of {} hold in {held} of {}.",
            ROWS.join(", "),
            found.len()
        );
    }
    Ok(())
}

/// A table per experiment for a terminal: a line per perturbation, a column per row.
fn text(found: &[Perturbed], which: fn(&Row) -> bool) -> String {
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
                if !which(row) {
                    continue;
                }
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
