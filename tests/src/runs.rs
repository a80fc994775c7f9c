//! Scenarios from their beginning to their end, and what became of them.

use std::time::Instant;

use wbqp::{Controller, controller::FallbackLevel, nalgebra::Vector3};
use wbqp_log::MemoryLog;
use wbqp_sim::{ClosedLoop, Scenario, Summary};

/// What became of a run.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Control periods.
    pub ticks: usize,
    /// Commands that were not the optimum, and the worst that they came from.
    pub not_optimal: usize,
    /// The worst that a command came from.
    pub worst: FallbackLevel,
    /// Root of the mean square of the error over the last tenth of the run, by task.
    pub errors: Vec<(String, f64)>,
    /// The largest error of the first task: the norm of its first three entries, m or rad.
    pub first_error: f64,
    /// The largest share of its limit that an effort took, and whose.
    pub share: (f64, String),
    /// How far a contact point moved after the first half second, m.
    pub slip: f64,
    /// Ticks after the first half second in which a contact point did not touch.
    pub lifted: usize,
    /// How long each tick took, s.
    pub times: Vec<f64>,
}

impl Outcome {
    /// Of a task that there is.
    pub fn error(&self, task: &str) -> Option<f64> {
        let found = self.errors.iter().find(|(name, _)| name == task);
        found.map(|(_, error)| *error)
    }

    /// Median time of a tick, s.
    pub fn median(&self) -> f64 {
        let mut times = self.times.clone();
        times.sort_by(f64::total_cmp);
        times.get(times.len() / 2).copied().unwrap_or(f64::NAN)
    }
}

/// Runs a case of a scenario with seed 1; its log is kept.
///
/// # Panics
/// If there is no such case, or it cannot be run.
pub fn logged(scenario: &Scenario, case: &str) -> (Summary, MemoryLog) {
    let mut log = MemoryLog::default();
    let summary = wbqp_sim::run(scenario, case, 1, &mut log, &mut |_| ());
    (summary.unwrap_or_else(|e| panic!("{case}: {e}")), log)
}

/// Runs the first case of a scenario to its end; events are not looked at.
///
/// # Panics
/// If it cannot be made or diverges.
pub fn run(scenario: &Scenario) -> Outcome {
    let name = scenario.cases().next().expect("has a case").to_owned();
    let case = scenario.case(&name).expect("is there");
    let config = case.controller_config().unwrap_or_else(|e| panic!("{e}"));
    let mut controller = Controller::new(config).unwrap_or_else(|e| panic!("{e}"));
    let mut closed_loop = ClosedLoop::new(case, &controller, 1).unwrap_or_else(|e| panic!("{e}"));
    let rate = controller.settings().rate;
    let limits: Vec<(String, f64, f64)> = controller
        .robot()
        .actuators
        .iter()
        .map(|a| (a.name.clone(), a.lower, a.upper))
        .collect();
    let tasks: Vec<String> = controller.task_names().map(str::to_owned).collect();
    let mut squares = vec![0.0; tasks.len()];
    let mut outcome = Outcome {
        worst: FallbackLevel::Optimal,
        ..Outcome::default()
    };
    let ticks = case.ticks(rate);
    let end = ticks - ticks / 10;
    let mut places: Vec<Vector3<f64>> = Vec::new();
    for tick in 0..ticks {
        let measurement = closed_loop.measure();
        let before = Instant::now();
        let (command, report) = controller.tick(measurement);
        outcome.times.push(before.elapsed().as_secs_f64());
        outcome.ticks += 1;
        outcome.not_optimal += usize::from(report.level != FallbackLevel::Optimal);
        outcome.worst = outcome.worst.max(report.level);
        let first = report.tasks.first().map(|task| &task.error);
        let squares_of_first = first.into_iter().flatten().take(3).map(|e| e * e);
        let first_error = squares_of_first.sum::<f64>().sqrt();
        outcome.first_error = outcome.first_error.max(first_error);
        if tick >= end {
            for (sum, task) in squares.iter_mut().zip(&report.tasks) {
                *sum += task.error.iter().map(|e| e * e).sum::<f64>();
            }
        }
        for (effort, (name, lower, upper)) in command.effort.iter().zip(&limits) {
            let limit = if *effort < 0.0 { lower } else { upper };
            let share = effort / limit;
            if limit.is_finite() && share > outcome.share.0 {
                outcome.share = (share, name.clone());
            }
        }
        let advanced = closed_loop.advance(command);
        advanced.unwrap_or_else(|e| panic!("tick {tick}: {e}"));
        let points = || closed_loop.plant().contacts().map(|(_, _, truth)| truth);
        // At home the contacts touch the ground without pressing on it.
        let settled = 0.5 * rate;
        if (tick as f64) < settled {
            continue;
        }
        if places.is_empty() {
            places = points().map(|truth| truth.p_WC).collect();
        }
        outcome.lifted += usize::from(points().any(|truth| !truth.in_contact));
        for (place, truth) in places.iter().zip(points()) {
            outcome.slip = outcome.slip.max((place - truth.p_WC).norm());
        }
    }
    let mean = |sum: f64| (sum / (ticks - end).max(1) as f64).sqrt();
    outcome.errors = tasks
        .into_iter()
        .zip(squares.into_iter().map(mean))
        .collect();
    outcome
}
