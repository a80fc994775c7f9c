//! How well the tasks of a run were followed.

use anyhow::Result;
use serde::Serialize;
use wbqp::{Controller, plugin::Layout};
use wbqp_measures::{Recording, escaped, log::Log};
use wbqp_sim::scenario::Case;

use super::traces::{columns, norm};

/// Part of the run that "at the end" means.
const END: f64 = 0.1;

/// How well a task was followed: norms over its rows. One whose errors have two units, metres and radians, is there for
/// each of them.
#[derive(Clone, Debug, Serialize)]
pub struct TaskSummary {
    /// Its name.
    pub name: String,
    /// Of the error.
    pub unit: String,
    /// How many numbers the error has.
    pub rows: usize,
    /// What the error is of.
    pub of: ErrorOf,
    /// Root of the mean square over the last tenth of the run; absent if it was off then.
    pub end: Option<f64>,
    /// The largest.
    pub peak: Option<f64>,
}

/// What a task's error is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ErrorOf {
    /// What was measured.
    Measured,
    /// What was planned: of a contact without a force-torque sensor the controller knows no more.
    Planned,
}

impl ErrorOf {
    /// What it is of in a case, of the task with this layout.
    pub(super) fn of(layout: &Layout, controller: &Controller, case: &Case) -> Self {
        let is_measured = |contact| {
            let frame = &controller.contact_spec(contact).frame;
            let mut sensors = case.sensors().force_torque.iter();
            sensors.any(|sensor| &sensor.frame == frame)
        };
        match layout.contact() {
            Some(contact) if !layout.acts_on_accelerations() && !is_measured(contact) => {
                Self::Planned
            }
            _ => Self::Measured,
        }
    }

    /// Where it is in a row of a task's message.
    pub(super) fn field(self) -> &'static str {
        match self {
            Self::Measured => "error",
            Self::Planned => "residual",
        }
    }
}

impl TaskSummary {
    /// Of all tasks, from a log.
    ///
    /// # Errors
    /// A log that cannot be read.
    pub(super) fn of_all(log: &Log, controller: &Controller, case: &Case) -> Result<Vec<Self>> {
        let mut tasks = Vec::new();
        let layouts = controller.task_names().zip(controller.task_layouts());
        for (name, layout) in layouts {
            let topic = format!("/task/{name}");
            let of = ErrorOf::of(layout, controller, case);
            let [alpha] = columns(log, &topic, &["/alpha".to_owned()])?
                .try_into()
                .unwrap_or_default();
            for (unit, rows) in by_unit(log, &topic) {
                let pointers: Vec<String> = rows
                    .iter()
                    .map(|row| format!("/rows/{}/{}", escaped(row), of.field()))
                    .collect();
                let mut error = norm(&columns(log, &topic, &pointers)?);
                for (error, alpha) in error.y.iter_mut().zip(&alpha.y) {
                    if *alpha == 0.0 {
                        *error = f64::NAN;
                    }
                }
                let from = log.end() * (1.0 - END);
                tasks.push(Self {
                    name: name.to_owned(),
                    unit: unit.to_owned(),
                    rows: rows.len(),
                    of,
                    end: error.window(from, f64::INFINITY).rmse(0.0),
                    peak: error.max(),
                });
            }
        }
        Ok(tasks)
    }
}

/// A task's rows whose errors have one unit, in the order of the units: metres and radians have no norm.
pub(super) fn by_unit<'l>(log: &'l Log, topic: &str) -> Vec<(&'l str, Vec<&'l str>)> {
    let mut groups: Vec<(usize, &str, Vec<&str>)> = Vec::new();
    for row in log.fields(topic, &["rows"]) {
        let of = |field| log.unit(topic, &["rows", row, field]);
        let all = of("error").unwrap_or_default();
        // The task's error has one unit, of which only the rows' own say which it is: `m or rad`, `m/s²`.
        let own = of("residual").unwrap_or_default();
        let own = own.strip_suffix("/s²").unwrap_or(own);
        let mut units = all.split(" or ").enumerate();
        let (rank, unit) = units.find(|(_, unit)| *unit == own).unwrap_or((0, all));
        match groups.iter_mut().find(|(_, other, _)| *other == unit) {
            Some((.., rows)) => rows.push(row),
            None => groups.push((rank, unit, vec![row])),
        }
    }
    groups.sort_by_key(|(rank, ..)| *rank);
    let groups = groups.into_iter();
    groups.map(|(_, unit, rows)| (unit, rows)).collect()
}
