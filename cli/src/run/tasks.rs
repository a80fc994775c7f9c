//! How well the tasks of a run were followed.

use anyhow::Result;
use serde::Serialize;
use wbqp::Controller;
use wbqp_measures::{Recording, log::Log};
use wbqp_sim::scenario::Case;

use super::{
    task_errors::{ErrorOf, TaskErrors},
    traces::norm,
};

/// Part of the run that "at the end" means.
pub(super) const END: f64 = 0.1;

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

impl TaskSummary {
    /// Of all tasks, from a log.
    ///
    /// # Errors
    /// A log that cannot be read.
    pub(super) fn of_all(log: &Log, controller: &Controller, case: &Case) -> Result<Vec<Self>> {
        let of = |errors: Result<TaskErrors<'_>>| Ok(Self::of(&errors?, log.end()));
        TaskErrors::of_all(log, controller, case).map(of).collect()
    }

    /// Of one task, in a run with this end, s.
    fn of(errors: &TaskErrors<'_>, end: f64) -> Self {
        let mut error = norm(&errors.series);
        for (error, alpha) in error.y.iter_mut().zip(&errors.alpha.y) {
            if *alpha == 0.0 {
                *error = f64::NAN;
            }
        }
        Self {
            name: errors.name.to_owned(),
            unit: errors.unit.to_owned(),
            rows: errors.rows.len(),
            of: errors.of,
            end: error.window(end * (1.0 - END), f64::INFINITY).rmse(0.0),
            peak: error.max(),
        }
    }
}
