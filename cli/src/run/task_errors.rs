//! What the tasks of a run missed, row by row, from its log.

use anyhow::Result;
use serde::Serialize;
use wbqp::{Controller, plugin::Layout};
use wbqp_measures::{Series, escaped, log::Log};
use wbqp_sim::scenario::Case;

use super::traces::columns;

/// Errors of a task's rows that have one unit. A task whose errors have two, metres and radians, has one of these for
/// each: the two have no norm.
pub(super) struct TaskErrors<'a> {
    /// The task.
    pub(super) name: &'a str,
    /// What its error is of.
    pub(super) of: ErrorOf,
    /// Of the errors.
    pub(super) unit: &'a str,
    /// Names of the rows.
    pub(super) rows: Vec<&'a str>,
    /// Of each row.
    pub(super) series: Vec<Series>,
    /// How far the task is on, from 0 to 1.
    pub(super) alpha: Series,
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

impl<'a> TaskErrors<'a> {
    /// Of all tasks, in the configuration's order; read one after the other, for a log may be long.
    pub(super) fn of_all(
        log: &'a Log,
        controller: &'a Controller,
        case: &'a Case,
    ) -> impl Iterator<Item = Result<Self>> {
        let tasks = controller.task_names().zip(controller.task_layouts());
        tasks.flat_map(move |(name, layout)| {
            let topic = format!("/task/{name}");
            let of = ErrorOf::of(layout, controller, case);
            by_unit(log, &topic).into_iter().map(move |(unit, rows)| {
                let mut pointers: Vec<String> = rows.iter().map(|row| of.pointer(row)).collect();
                pointers.push("/alpha".to_owned());
                let mut series = columns(log, &topic, &pointers)?;
                Ok(Self {
                    name,
                    of,
                    unit,
                    rows,
                    alpha: series.pop().unwrap_or_default(),
                    series,
                })
            })
        })
    }
}

impl ErrorOf {
    /// What it is of in a case, of the task with this layout.
    fn of(layout: &Layout, controller: &Controller, case: &Case) -> Self {
        let is_measured = |contact| {
            let frame = &controller.contact_spec(contact).frame;
            case.force_torque_at(frame).is_some()
        };
        match layout.contact() {
            Some(contact) if !layout.acts_on_accelerations() && !is_measured(contact) => {
                Self::Planned
            }
            _ => Self::Measured,
        }
    }

    /// Where it is of a row in a task's message.
    fn pointer(self, row: &str) -> String {
        let field = match self {
            Self::Measured => "error",
            Self::Planned => "residual",
        };
        format!("/rows/{}/{field}", escaped(row))
    }
}

/// A task's rows whose errors have one unit, in the order of the units.
fn by_unit<'l>(log: &'l Log, topic: &str) -> Vec<(&'l str, Vec<&'l str>)> {
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
