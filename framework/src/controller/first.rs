//! What is known of a first tick before it: how its errors count, and how large they may be.

use crate::{
    plugin::{Layout, layout::VdotBlock},
    problem::BoundEntry,
    settings::FirstError,
};
use wbqp_dynamics::model::{Base, Model};

/// What is remembered of the first tick, and how large its errors may be.
#[derive(Clone, Debug)]
pub(super) struct FirstTick {
    /// Whether a tick was plausible.
    pub(super) is_over: bool,
    /// Whether one was refused.
    pub(super) was_refused: bool,
    pub(super) limits: FirstError,
    /// How the errors of each task count, row by row.
    pub(super) errors: Vec<Vec<Counts>>,
}

/// How the error of a row counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Counts {
    /// Not at all: it is neither a length nor an angle.
    No,
    /// A joint's, by itself.
    Alone(Quantity),
    /// A component of the task's position or orientation.
    Together(Quantity),
}

/// What an error is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Quantity {
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

    /// [`Fault::FirstError`](crate::fault::Fault::FirstError) in words, of a task with these errors.
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
