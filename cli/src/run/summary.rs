//! What is told of a finished run, measured from its log.

use std::{collections::BTreeMap, fs, path::Path, thread, time::Duration};

use anyhow::{Context, Result};
use serde::Serialize;
use wbqp::{
    Controller,
    actuator::ActuatorKind,
    controller::FallbackLevel,
    input,
    serde_json::{self, Value},
};
use wbqp_log::{LogError, RunLock};
use wbqp_measures::{escaped, log::Log};
use wbqp_sim::{Held, Summary, scenario::Case};

use super::{
    attention,
    contacts::ContactSummary,
    solves::{LimitSummary, Solves},
    task_errors::ErrorOf,
    tasks::TaskSummary,
    traces::columns,
};
use crate::{
    check::effort_unit,
    text::{indented, number, per_cent, quantity, table},
};

/// Times that another run's summary is waited for, and for how long each time.
const PATIENCE: (u32, Duration) = (500, Duration::from_millis(10));

/// Writes the summary of a case into a file. Those of the scenario's other cases stay in it; `order` are all of the
/// scenario's.
///
/// # Errors
/// A file that cannot be read or written.
pub(super) fn write(file: &Path, summary: &CaseSummary, order: &[&str]) -> Result<()> {
    let rank = |name: &str| order.iter().position(|other| *other == name);
    let new = serde_json::to_value(summary)?;
    edit(file, |all| {
        all.retain(|old| case(old) != Some(&summary.case));
        all.push(new);
        all.retain(|summary| case(summary).and_then(rank).is_some());
        all.sort_by_key(|summary| case(summary).and_then(rank));
    })
}

/// Takes a case out that is run anew: if the run does not end, what stands there would be an older one's.
///
/// # Errors
/// A file that cannot be written.
pub(super) fn forget(file: &Path, name: &str) -> Result<()> {
    if !file.exists() {
        return Ok(());
    }
    edit(file, |all| all.retain(|old| case(old) != Some(name)))
}

fn case(summary: &Value) -> Option<&str> {
    summary.get("case").and_then(Value::as_str)
}

/// Changes the list of summaries that a file has. Without a file, and where its text is no list, it is empty.
fn edit(file: &Path, change: impl FnOnce(&mut Vec<Value>)) -> Result<()> {
    let _lock = lock(file)?;
    let mut all: Vec<Value> = if file.exists() {
        let text = input::read_text(file).with_context(|| file.display().to_string())?;
        serde_json::from_str(&text).unwrap_or_default()
    } else {
        Vec::new()
    };
    change(&mut all);
    let text = serde_json::to_string_pretty(&all)?;
    // A reader finds the old or the new file, never half of one.
    let new = file.with_extension("json.new");
    fs::write(&new, text)
        .and_then(|()| fs::rename(&new, file))
        .with_context(|| file.display().to_string())
}

fn lock(file: &Path) -> Result<RunLock, LogError> {
    let (times, pause) = PATIENCE;
    for _ in 0..times {
        match RunLock::take(file) {
            Err(LogError::Taken { .. }) => thread::sleep(pause),
            done => return done,
        }
    }
    RunLock::take(file)
}

/// Limits that are printed of those that were reached.
const SHOWN: usize = 2;
/// And of a list in an explanation.
const LISTED: usize = 3;

/// A finished case.
#[derive(Clone, Debug, Serialize)]
pub struct CaseSummary {
    /// Its name.
    pub case: String,
    /// Control periods that were run.
    pub ticks: usize,
    /// Ticks whose command was not the optimum.
    pub not_optimal: usize,
    /// How many of these had which level.
    pub levels: BTreeMap<&'static str, usize>,
    /// The first of these: when, s, and why.
    pub first_not_optimal: Option<Held>,
    /// The worst that a tick's command came from: `optimal`, `relaxed`, `extrapolated` or `safe`.
    pub worst_level: &'static str,
    /// Time at which the plant diverged, s.
    pub diverged: Option<f64>,
    /// Why there was no use in going on then, in words.
    pub divergence: Option<&'static str>,
    /// Where the last tick's command came from.
    pub last_level: FallbackLevel,
    /// Why it was not that tick's optimum.
    pub why: Option<String>,
    /// What it should be looked at for, a sentence each: a robot that fell, for example. Empty if there is nothing.
    pub attention: Vec<String>,
    /// In the configuration's order.
    pub tasks: Vec<TaskSummary>,
    /// In the order of `u`.
    pub efforts: Vec<EffortSummary>,
    /// Those that commands were held back by, the most frequent one first.
    pub limits: Vec<LimitSummary>,
    /// In the configuration's order.
    pub contacts: Vec<ContactSummary>,
    /// How long ticks took, µs.
    pub tick_time: TickTime,
}

/// How much an actuator was asked for.
#[derive(Clone, Debug, Serialize)]
pub struct EffortSummary {
    /// The actuator.
    pub actuator: String,
    /// `N·m` or `N`.
    pub unit: &'static str,
    /// The effort that was nearest to its limit, or the largest where there is no limit.
    pub peak: f64,
    /// Its share of the limit on its side; absent if there is none.
    pub share: Option<f64>,
}

/// Quantiles, µs.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct TickTime {
    /// Median.
    pub p50: f64,
    /// 99 %.
    pub p99: f64,
    /// The longest.
    pub max: f64,
}

impl CaseSummary {
    /// Measures a log.
    ///
    /// # Errors
    /// A log that cannot be read.
    pub(super) fn of(
        case: &Case,
        run: &Summary,
        log: &Log,
        controller: &Controller,
        solves: Solves,
    ) -> Result<Self> {
        let (tasks, contacts) = (
            TaskSummary::of_all(log, controller, case)?,
            ContactSummary::of_all(log, controller)?,
        );
        Ok(Self {
            attention: attention::of(run, log, controller, case, (&tasks, &contacts))?,
            case: case.name().to_owned(),
            ticks: run.ticks,
            not_optimal: run.held,
            levels: solves
                .counts()
                .into_iter()
                .map(|(level, count)| (level.as_str(), count))
                .collect(),
            first_not_optimal: run.first_held.clone(),
            worst_level: solves.worst_level().as_str(),
            diverged: run.diverged,
            divergence: run.divergence,
            last_level: run.last_level,
            why: run.why.clone(),
            tasks,
            efforts: efforts(log, controller)?,
            limits: solves.limits,
            contacts,
            tick_time: tick_time(log)?,
        })
    }

    /// Whether it ran to its end, and the controller had a solution there.
    pub fn completed(&self) -> bool {
        self.diverged.is_none() && self.last_level <= FallbackLevel::Relaxed
    }

    /// Tables for a terminal.
    pub fn text(&self) -> String {
        let mut out = match self.diverged {
            Some(time) => {
                let why = self
                    .divergence
                    .map_or(String::new(), |why| format!(": {why}"));
                format!("{}: DIVERGED at {time:.3} s{why}\n", self.case)
            }
            None if self.completed() => format!("{}: ran to its end\n", self.case),
            None => format!(
                "{}: FAILED: the controller ended without a solution\n",
                self.case
            ),
        };
        if let Some(why) = &self.why {
            out.push_str(&format!("  at the end: {}\n", shortened(why)));
        }
        for words in &self.attention {
            out.push_str(&format!("  ATTENTION: {words}\n"));
        }
        // From the best to the worst, as they are told everywhere.
        let levels = FallbackLevel::ALL.into_iter().filter_map(|level| {
            let count = self.levels.get(level.as_str())?;
            Some(format!("{count} {}", level.as_str()))
        });
        let levels: Vec<String> = levels.collect();
        let levels = match levels.as_slice() {
            [] | [_] => format!("worst: {}", self.worst_level),
            several => several.join(", "),
        };
        out.push_str(&format!(
            "  {} ticks, {} not optimal ({}); a tick took {:.0} µs (median), {:.0} µs (99 %)\n",
            self.ticks, self.not_optimal, levels, self.tick_time.p50, self.tick_time.p99,
        ));
        if let Some(first) = &self.first_not_optimal {
            out.push_str(&format!(
                "  the first of these at {:.3} s: {}\n",
                first.time,
                shortened(&first.why)
            ));
        }
        if let Some(busiest) = self.most_loaded() {
            out.push_str(&format!(
                "  most loaded actuator: {}, {} {}, {} of its limit\n",
                busiest.actuator,
                number(busiest.peak),
                busiest.unit,
                per_cent(busiest.share)
            ));
        }
        if !self.limits.is_empty() {
            out.push_str(&format!("  limits reached: {}\n", self.limits_in_words()));
        }
        let mut tasks = table(&["task", "error at the end", "largest error"], &[1, 2]);
        for task in &self.tasks {
            let unit = task.unit.as_str();
            tasks.add_row([
                match task.of {
                    ErrorOf::Measured => task.name.clone(),
                    ErrorOf::Planned => format!("{} (planned)", task.name),
                },
                quantity(task.end, unit),
                quantity(task.peak, unit),
            ]);
        }
        if !self.tasks.is_empty() {
            out.push_str(&indented(&tasks.to_string(), "  "));
        }
        let mut contacts = table(
            &[
                "contact",
                "on",
                "normal force at the end",
                "largest planned",
                "largest real",
            ],
            &[1, 2, 3, 4],
        );
        let force = |x: Option<f64>| x.map_or_else(|| "–".to_owned(), |x| format!("{x:.1} N"));
        for contact in &self.contacts {
            contacts.add_row([
                contact.name.clone(),
                per_cent(Some(contact.on)),
                contact.at_end(),
                force(contact.peak_planned),
                force(contact.peak_real),
            ]);
        }
        if !self.contacts.is_empty() {
            out.push_str(&indented(&contacts.to_string(), "  "));
        }
        out
    }

    /// The most frequent limits.
    fn limits_in_words(&self) -> String {
        let mut words: Vec<String> = self
            .limits
            .iter()
            .take(SHOWN)
            .map(LimitSummary::text)
            .collect();
        match self.limits.len().saturating_sub(SHOWN) {
            0 => {}
            1 => words.push("one other in summary.json".to_owned()),
            others => words.push(format!("{others} others in summary.json")),
        }
        words.join(", ")
    }

    /// The actuator that came nearest to its limit.
    pub fn most_loaded(&self) -> Option<&EffortSummary> {
        let limited = self.efforts.iter().filter(|e| e.share.is_some());
        limited.max_by(|a, b| a.share.unwrap_or(0.0).total_cmp(&b.share.unwrap_or(0.0)))
    }
}

/// An explanation with the first limits of each list, all but its first line behind a margin. `wbqp replay` and the
/// summary's file have it whole.
fn shortened(why: &str) -> String {
    let mut out = String::new();
    let mut listed = 0;
    for line in why.lines() {
        let is_limit = line.starts_with("  ");
        if !is_limit && listed > LISTED {
            out.push_str(&format!("\n      … {} more", listed - LISTED));
        }
        listed = if is_limit { listed + 1 } else { 0 };
        if listed > LISTED {
            continue;
        }
        if !out.is_empty() {
            out.push_str("\n    ");
        }
        out.push_str(line);
    }
    if listed > LISTED {
        out.push_str(&format!("\n      … {} more", listed - LISTED));
    }
    out
}

/// Where an actuator's effort is in a message of `/command`.
pub(super) fn effort_pointer(controller: &Controller, index: usize) -> Option<String> {
    let robot = controller.robot();
    let actuator = robot.actuators.get(index)?;
    Some(match &actuator.kind {
        ActuatorKind::Joint(motor) => {
            let joint = robot.model.joints().get(motor.joint.index())?;
            format!("/joints/{}/effort", escaped(&joint.name))
        }
        ActuatorKind::Rotor(_) => format!("/rotors/{}/thrust", escaped(&actuator.name)),
    })
}

fn efforts(log: &Log, controller: &Controller) -> Result<Vec<EffortSummary>> {
    let robot = controller.robot();
    let pointers: Vec<String> = (0..robot.nu())
        .map(|i| effort_pointer(controller, i).unwrap_or_default())
        .collect();
    let efforts = columns(log, "/command", &pointers)?;
    let of = |(actuator, effort): (&wbqp::actuator::Actuator, &wbqp_measures::Series)| {
        let share = |u: f64| {
            let limit = if u < 0.0 {
                actuator.lower
            } else {
                actuator.upper
            };
            (limit.is_finite() && limit != 0.0).then_some(u / limit)
        };
        // Shares where there are limits, magnitudes where there are none.
        let load = |u: &f64| share(*u).unwrap_or_else(|| u.abs());
        let values = effort.samples().map(|(_, u)| u);
        let peak = values.max_by(|a, b| load(a).total_cmp(&load(b)));
        let peak = peak.unwrap_or(0.0);
        EffortSummary {
            actuator: actuator.name.clone(),
            unit: effort_unit(&robot.model, actuator),
            peak,
            share: share(peak),
        }
    };
    Ok(robot.actuators.iter().zip(&efforts).map(of).collect())
}

fn tick_time(log: &Log) -> Result<TickTime> {
    let columns = columns(log, "/qp", &["/times/total".to_owned()])?;
    let quantile = |p| columns.first().and_then(|times| times.quantile(p));
    Ok(TickTime {
        p50: quantile(0.5).unwrap_or_default(),
        p99: quantile(0.99).unwrap_or_default(),
        max: quantile(1.0).unwrap_or_default(),
    })
}

#[cfg(test)]
mod tests {
    use super::shortened;

    #[test]
    fn long_lists_are_cut_and_counted() {
        let limits = "\n  limit 0\n  limit 1\n  limit 2\n  limit 3\n  limit 4";
        let why = format!("relaxed: they contradict{limits}\ngiven up:\n  limit 1");
        let cut = "relaxed: they contradict\n      limit 0\n      limit 1\n      limit 2\n      … 2 more\n    given \
                   up:\n      limit 1";
        assert_eq!(shortened(&why), cut);
        assert_eq!(shortened(&format!("a{limits}")).lines().count(), 5);
        assert_eq!(shortened("safe: no state"), "safe: no state");
    }
}
