//! The first tick: references begin at what was measured, and nothing moves if a task is implausibly far from what it
//! wants.
//!
//! A tick is the first until one was plausible: after a refused one time counts anew, and references begin at what the
//! next one measures.

use super::{report::TaskReport, running::RunningPlugin, world::World};
use crate::{
    fault::Fault,
    plugin::{EntryState, Layout, layout::VdotBlock},
    problem::BoundEntry,
    settings::{FirstError, StartFrom},
};
use wbqp_dynamics::model::{Base, Model};

/// What is remembered of the first tick, and how large its errors may be.
#[derive(Clone, Debug)]
pub(super) struct FirstTick {
    /// Whether a tick was plausible.
    pub(super) is_over: bool,
    /// Whether one was refused.
    was_refused: bool,
    limits: FirstError,
    /// How the errors of each task count, row by row.
    errors: Vec<Vec<Counts>>,
}

/// How the error of a row counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Counts {
    /// Not at all: it is neither a length nor an angle.
    No,
    /// A joint's, by itself.
    Alone(Quantity),
    /// A component of the task's position or orientation.
    Together(Quantity),
}

/// What an error is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Quantity {
    /// m.
    Position,
    /// rad.
    Rotation,
}

/// The largest distance and angle among a task's errors, m and rad.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Distance {
    pub(super) position: f64,
    pub(super) rotation: f64,
}

impl FirstTick {
    pub(super) fn new(limits: FirstError, tasks: &[BoundEntry], model: &Model) -> Self {
        let errors = tasks.iter().map(|entry| counts(&entry.layout, model));
        Self {
            is_over: false,
            was_refused: false,
            limits,
            errors: errors.collect(),
        }
    }

    /// How far a task is from what it wants.
    pub(super) fn distance(&self, task: usize, errors: &[f64]) -> Distance {
        let rows = self.errors.get(task).map(Vec::as_slice).unwrap_or_default();
        let of = |quantity: Quantity| {
            let (mut alone, mut squares) = (0.0_f64, 0.0);
            for (counts, error) in rows.iter().zip(errors) {
                match counts {
                    Counts::Alone(q) if *q == quantity => alone = alone.max(error.abs()),
                    Counts::Together(q) if *q == quantity => squares += error * error,
                    _ => {}
                }
            }
            alone.max(f64::sqrt(squares))
        };
        Distance {
            position: of(Quantity::Position),
            rotation: of(Quantity::Rotation),
        }
    }
}

fn counts(layout: &Layout, model: &Model) -> Vec<Counts> {
    let is_known = |unit: &str| ["m", "rad"].contains(&unit);
    if !layout.error_unit.split(" or ").all(is_known) {
        return vec![Counts::No; layout.len()];
    }
    let base = match model.base() {
        Base::Floating => 6,
        Base::Fixed => 0,
    };
    let is_joint = |row: usize| match &layout.vdot {
        VdotBlock::Unit(columns) => columns.get(row).is_some_and(|column| *column >= base),
        _ => false,
    };
    let count = |(row, spec): (usize, &crate::plugin::RowSpec)| {
        let is_rotation = match layout.error_unit.as_str() {
            "m" => false,
            "rad" => true,
            _ => spec.unit.starts_with("rad"),
        };
        let quantity = if is_rotation {
            Quantity::Rotation
        } else {
            Quantity::Position
        };
        if is_joint(row) {
            Counts::Alone(quantity)
        } else {
            Counts::Together(quantity)
        }
    };
    layout.rows.iter().enumerate().map(count).collect()
}

impl FirstTick {
    /// Lets references begin at what is measured. Before the plug-ins write the rows of a first tick.
    pub(super) fn begin(&self, start: StartFrom, world: &World, plugins: &mut [RunningPlugin]) {
        if self.was_refused {
            // What the refused tick left in integrators and at points of touch.
            for plugin in plugins.iter_mut() {
                plugin.plugin.activate();
            }
        }
        if start == StartFrom::Home {
            return;
        }
        let tick = world.tick(EntryState::ON);
        for plugin in plugins {
            for reference in &mut plugin.references {
                reference.start_here(&tick);
            }
        }
    }

    /// Whether the rows of a first tick are plausible; the errors of all tasks are in their reports if they are not.
    ///
    /// # Errors
    /// [`Fault::FirstError`] with the first task whose error is too large.
    pub(super) fn check(
        &mut self,
        tasks: &[BoundEntry],
        reports: &mut [TaskReport],
    ) -> Result<(), Fault> {
        let limits = &self.limits;
        let is_far = |(task, entry): (usize, &BoundEntry)| {
            let Distance { position, rotation } = self.distance(task, &entry.store.error);
            entry.live && (position > limits.position || rotation > limits.rotation)
        };
        let Some(task) = tasks.iter().enumerate().position(is_far) else {
            self.is_over = true;
            return Ok(());
        };
        self.was_refused = true;
        for (entry, report) in tasks.iter().zip(reports) {
            report.alpha = if entry.live { entry.alpha } else { 0.0 };
            for (out, error) in report.error.iter_mut().zip(&entry.store.error) {
                *out = if entry.live { *error } else { 0.0 };
            }
        }
        Err(Fault::FirstError(task))
    }

    /// [`Fault::FirstError`] in words, of a task with these errors.
    pub(super) fn error_text(&self, task: usize, name: &str, errors: &[f64]) -> String {
        let Distance { position, rotation } = self.distance(task, errors);
        let limits = &self.limits;
        let (key, unit, error, limit) = if position > limits.position {
            ("position", "m", position, limits.position)
        } else {
            ("rotation", "rad", rotation, limits.rotation)
        };
        format!(
            "task `{name}` is {error:.3} {unit} from its reference in the first tick, more than \
             `max_first_error.{key}` = {limit} {unit} in [controller] allows: nothing moves until it is nearer"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn first(rows: Vec<Counts>) -> FirstTick {
        FirstTick {
            is_over: false,
            was_refused: false,
            limits: FirstError::default(),
            errors: vec![rows],
        }
    }

    #[test]
    fn joints_count_by_themselves_and_components_together() {
        let joints = first(vec![Counts::Alone(Quantity::Rotation); 4]);
        let d = joints.distance(0, &[0.3, -0.4, 0.3, 0.3]);
        assert_eq!((d.position, d.rotation), (0.0, 0.4));
        let point = first(vec![Counts::Together(Quantity::Position); 3]);
        let d = point.distance(0, &[0.3, -0.4, 0.0]);
        assert_eq!((d.position, d.rotation), (0.5, 0.0));
        let force = first(vec![Counts::No; 3]);
        assert_eq!(force.distance(0, &[1e3; 3]), Distance::default());
    }
}
