//! Who follows a run: to find the ticks to look at, and to look at them.

use std::{collections::BTreeMap, f64::consts::PI, ops::Range};

use wbqp::controller::{Controller, FallbackLevel, ParameterKind, Sensitivity, Snapshot};
use wbqp_log::{LogError, LogSink, TrueContact};
use wbqp_measures::number;
use wbqp_sim::Watcher;

use super::{Line, Told};

/// Parameters and limits that are told of a tick.
const MOST: usize = 6;
/// What is smaller than this share of what moves most is rounding.
const ROUNDING: f64 = 1e-10;

/// Errors of all tasks, tick by tick, and when contacts begin and end.
#[derive(Debug, Default)]
pub(super) struct Tracking {
    pub(super) times: Vec<f64>,
    /// Time and what happened.
    pub(super) switched: Vec<(f64, String)>,
    /// By task: the norm of its error in each tick.
    errors: Vec<Vec<f64>>,
    /// Of each tick, whether its command was its optimum.
    optimal: Vec<bool>,
    contacts: Vec<bool>,
}

impl Tracking {
    /// The tick at a time.
    pub(super) fn tick_at(&self, time: f64) -> Option<usize> {
        let next = self.times.partition_point(|t| *t < time - 1e-9);
        (next < self.times.len()).then_some(next)
    }

    /// The tick in which the tasks' errors are largest, each as a share of the root mean square that it has in the
    /// whole run, among those with an optimum; of all, if none has one.
    pub(super) fn worst(&self, during: Range<f64>) -> Option<usize> {
        let scales: Vec<f64> = self
            .errors
            .iter()
            .map(|errors| mean_square(errors))
            .collect();
        let size = |tick: usize| {
            let shares = self
                .errors
                .iter()
                .zip(&scales)
                .filter(|(_, scale)| **scale > 0.0);
            shares
                .map(|(errors, scale)| errors[tick].powi(2) / scale)
                .sum::<f64>()
        };
        let inside = |tick: &usize| during.contains(&self.times[*tick]);
        let ticks = || (0..self.times.len()).filter(inside);
        let by_size = |a: &usize, b: &usize| size(*a).total_cmp(&size(*b));
        let optimal = ticks().filter(|tick| self.optimal[*tick]).max_by(by_size);
        optimal.or_else(|| ticks().max_by(by_size))
    }
}

fn mean_square(errors: &[f64]) -> f64 {
    errors.iter().map(|e| e * e).sum::<f64>() / errors.len().max(1) as f64
}

impl Watcher for Tracking {
    fn begin(&mut self, controller: &Controller, _: &mut dyn LogSink) -> Result<(), LogError> {
        self.errors = controller.task_names().map(|_| Vec::new()).collect();
        Ok(())
    }

    fn after_tick(
        &mut self,
        controller: &mut Controller,
        _: &Snapshot,
        _: &[Option<TrueContact>],
        _: &mut dyn LogSink,
    ) -> Result<(), LogError> {
        let report = controller.report();
        self.times.push(report.time);
        self.optimal.push(report.level == FallbackLevel::Optimal);
        for (errors, task) in self.errors.iter_mut().zip(&report.tasks) {
            // What is off does not follow anything.
            let norm = task.error.iter().map(|e| e * e).sum::<f64>().sqrt();
            errors.push(if task.alpha > 0.0 && norm.is_finite() {
                norm
            } else {
                0.0
            });
        }
        let on: Vec<bool> = report.contacts.iter().map(|contact| contact.on).collect();
        for ((name, on), was) in controller.contact_names().zip(&on).zip(&self.contacts) {
            if on != was {
                let what = if *on { "on" } else { "off" };
                let what = format!("contact {name} {what}");
                self.switched.push((report.time, what));
            }
        }
        self.contacts = on;
        Ok(())
    }
}

/// Derivatives of some ticks.
#[derive(Debug)]
pub(super) struct Derivatives {
    wanted: BTreeMap<usize, Option<Told>>,
    sensitivity: Option<Sensitivity>,
    ticks: usize,
}

impl Derivatives {
    pub(super) fn at(ticks: impl Iterator<Item = usize>) -> Self {
        Self {
            wanted: ticks.map(|tick| (tick, None)).collect(),
            sensitivity: None,
            ticks: 0,
        }
    }

    /// What was found in a tick; nothing if the run did not get there.
    pub(super) fn take(&mut self, tick: usize) -> Option<Told> {
        self.wanted.remove(&tick).flatten()
    }
}

impl Watcher for Derivatives {
    fn begin(&mut self, _: &Controller, _: &mut dyn LogSink) -> Result<(), LogError> {
        Ok(())
    }

    fn after_tick(
        &mut self,
        controller: &mut Controller,
        _: &Snapshot,
        _: &[Option<TrueContact>],
        _: &mut dyn LogSink,
    ) -> Result<(), LogError> {
        let made = || Sensitivity::new(controller);
        let sensitivity = self.sensitivity.get_or_insert_with(made);
        if let Some(told) = self.wanted.get_mut(&self.ticks) {
            *told = Some(tell(controller, sensitivity));
        }
        self.ticks += 1;
        Ok(())
    }
}

/// What matters in the last tick.
fn tell(controller: &mut Controller, sensitivity: &mut Sensitivity) -> Told {
    if let Err(error) = controller.sensitivity(sensitivity) {
        return Told {
            refused: Some(error.to_string()),
            ..Told::default()
        };
    }
    let effects = sensitivity.strongest_effects(MOST);
    let notes = sensitivity.notes_on(&effects);
    let effects = effects.iter().map(|effect| Line {
        name: format!("{} {}", effect.owner, effect.key),
        effort: effect.effort,
        strongest: effect.strongest.map(|most| {
            most.map_or(String::new(), |(output, slope)| {
                say(sensitivity, output, slope)
            })
        }),
    });
    Told {
        refused: None,
        effects: effects.collect(),
        references: references(sensitivity),
        limits: limits(controller),
        notes,
    }
}

/// `rotor_3 thrust: 0.52 N`.
fn say(sensitivity: &Sensitivity, output: usize, slope: f64) -> String {
    let about = sensitivity.outputs().get(output);
    about.map_or(String::new(), |about| {
        let name = match about.owner.as_str() {
            // The table's column says that.
            "acceleration" => about.label.clone(),
            owner => format!("{owner} {}", about.label),
        };
        format!("{name}: {} {}", number(slope), about.unit)
    })
}

/// How far off a reference is imagined, in its unit, and in words.
fn little(unit: &str) -> (f64, &'static str) {
    match unit {
        "m" => (0.01, "1 cm"),
        "rad" => (PI / 180.0, "1°"),
        "N" => (0.1, "0.1 N"),
        _ => (1.0, "1"),
    }
}

/// What a reference does that is a little off.
fn references(sensitivity: &Sensitivity) -> Vec<Line> {
    let (nv, nu) = (sensitivity.vdot().nrows(), sensitivity.effort().nrows());
    let total = sensitivity.outputs().len();
    let parameters = sensitivity.parameters().iter().enumerate();
    let values = parameters
        .filter(|(_, p)| p.kind == ParameterKind::Reference && p.label.starts_with("value"));
    let mut lines: Vec<Line> = values
        .map(|(j, parameter)| {
            let (step, words) = little(&parameter.unit);
            let column = step * sensitivity.derivatives().column(j);
            let least = ROUNDING * column.amax();
            let strongest = [0..nv, nv..nv + nu, nv + nu..total].map(|block| {
                let numbers = block.filter(|i| column[*i].abs() > least);
                let most = numbers.max_by(|a, b| column[*a].abs().total_cmp(&column[*b].abs()));
                most.map_or(String::new(), |i| say(sensitivity, i, column[i]))
            });
            Line {
                name: format!("{} {}, {words}", parameter.owner, parameter.label),
                effort: column.rows(nv, nu).norm(),
                strongest,
            }
        })
        .filter(|line| line.effort > 0.0)
        .collect();
    lines.sort_by(|a, b| b.effort.total_cmp(&a.effort));
    lines.truncate(MOST);
    lines
}

/// What holds the optimum back, the most expensive first.
fn limits(controller: &Controller) -> Vec<String> {
    let holding = controller.report().holding().into_iter();
    holding
        .take(MOST)
        .filter_map(|row| {
            Some(format!(
                "{}, {}",
                controller.row(row.row)?,
                row.side.as_str()
            ))
        })
        .collect()
}
