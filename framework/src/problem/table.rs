//! Whose is a row, whose is a variable: permanent names for everything in the problem.

use super::{Partition, Problem};
use crate::qp::{RowId, VarId};

/// A row of the problem, a decision variable or an error, by name: displayed as `owner.label`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Named {
    /// Of a row the entry's name, or `dynamics`; of a variable `acceleration`, or the name of the actuator, the contact
    /// or the soft entry.
    pub owner: String,
    /// Axis or quantity.
    pub label: String,
    /// Unit of its value.
    pub unit: String,
}

impl std::fmt::Display for Named {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}.{}", self.owner, self.label)
    }
}

/// All rows and variables that can ever appear, made once.
#[derive(Clone, Debug, Default)]
pub(crate) struct Table {
    pub(crate) rows: Vec<Named>,
    pub(crate) vars: Vec<Named>,
}

impl Table {
    pub(crate) fn add_row(&mut self, owner: &str, label: &str, unit: &str) -> RowId {
        self.rows.push(Named {
            owner: owner.to_owned(),
            label: label.to_owned(),
            unit: unit.to_owned(),
        });
        RowId::new(self.rows.len() as u32 - 1)
    }

    pub(crate) fn add_var(&mut self, owner: &str, label: &str, unit: &str) -> VarId {
        self.vars.push(Named {
            owner: owner.to_owned(),
            label: label.to_owned(),
            unit: unit.to_owned(),
        });
        VarId::new(self.vars.len() as u32 - 1)
    }
}

/// A row that is a bound on an eliminated effort, of the problem built last.
#[derive(Clone, Copy, Debug)]
pub(super) struct TorqueRow {
    /// The bound.
    pub(super) id: RowId,
    /// Its row in the problem of this tick.
    pub(super) row: usize,
    /// Whose effort.
    pub(super) actuator: usize,
}

impl Problem {
    /// Identity of the bound on a contact's normal force.
    pub(crate) fn normal_row(&self, contact: usize) -> Option<RowId> {
        self.normal_rows.get(contact).copied()
    }

    /// Weight of `‖(u, f)‖²` relative to the largest one that is on.
    pub(crate) fn relative_regularisation(&self) -> f64 {
        self.regularisation
    }

    /// Whether a row is one of the equations of motion.
    pub(crate) fn is_dynamics(&self, id: RowId) -> bool {
        self.dynamics_rows.contains(&id)
    }

    /// The row of the problem that is this bound on an eliminated effort, and whose.
    pub(super) fn torque_row(&self, id: RowId) -> Option<(usize, usize)> {
        let found = self.torque_rows.binary_search_by_key(&id, |row| row.id);
        found
            .ok()
            .map(|i| (self.torque_rows[i].row, self.torque_rows[i].actuator))
    }

    /// The actuator whose effort is this variable of the problem.
    pub(super) fn effort_at(&self, position: usize) -> Option<usize> {
        let Partition {
            accelerations,
            substituted,
            kept,
            ..
        } = &self.partition;
        (position + substituted)
            .checked_sub(*accelerations)
            .and_then(|i| kept.get(i))
            .copied()
    }
}
