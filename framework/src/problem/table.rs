//! Whose is a row, whose is a variable: permanent names for everything in the problem.

use crate::qp::{RowId, VarId};

/// A row of the problem: its owner, what it is of the owner's, and the unit of its value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RowInfo {
    /// Name of the entry (or `dynamics`).
    pub owner: String,
    /// Axis or quantity.
    pub label: String,
    /// Unit of the row's value.
    pub unit: String,
}

impl std::fmt::Display for RowInfo {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}.{}", self.owner, self.label)
    }
}

/// A decision variable.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VarInfo {
    /// `acceleration`, the actuator's, the contact's or the soft entry's name.
    pub owner: String,
    /// Axis or quantity.
    pub label: String,
    /// Its unit.
    pub unit: String,
}

impl std::fmt::Display for VarInfo {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}.{}", self.owner, self.label)
    }
}

/// All rows and variables that can ever appear, made once.
#[derive(Clone, Debug, Default)]
pub(crate) struct Table {
    pub(crate) rows: Vec<RowInfo>,
    pub(crate) vars: Vec<VarInfo>,
}

impl Table {
    pub(crate) fn add_row(&mut self, owner: &str, label: &str, unit: &str) -> RowId {
        self.rows.push(RowInfo {
            owner: owner.to_owned(),
            label: label.to_owned(),
            unit: unit.to_owned(),
        });
        RowId::new(self.rows.len() as u32 - 1)
    }

    pub(crate) fn add_var(&mut self, owner: &str, label: &str, unit: &str) -> VarId {
        self.vars.push(VarInfo {
            owner: owner.to_owned(),
            label: label.to_owned(),
            unit: unit.to_owned(),
        });
        VarId::new(self.vars.len() as u32 - 1)
    }
}
