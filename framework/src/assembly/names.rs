//! Permanent names for the physical variables and for the framework's own rows.

use super::{Group, Table, live::FirstIds};
use crate::{config::Formulation, qp::RowId};

/// Names of the efforts and of the contacts' force components.
pub(crate) struct VariableNames<'a> {
    pub(crate) accelerations: Vec<(String, &'static str)>,
    pub(crate) efforts: Vec<(&'a str, &'static str)>,
    pub(crate) contacts: Vec<(&'a str, &'static [usize])>,
}

/// Rows that belong to the framework, registered before those of the entries: ids ascend in the order in which rows
/// appear in the problem.
#[derive(Debug)]
pub(crate) struct ProblemRows {
    pub(super) dynamics: Vec<RowId>,
    pub(super) normals: Vec<RowId>,
}

impl ProblemRows {
    pub(crate) fn new(
        formulation: Formulation,
        names: &VariableNames<'_>,
        table: &mut Table,
    ) -> Self {
        let mut dynamics = Vec::new();
        if formulation == Formulation::Explicit {
            for (label, unit) in &names.accelerations {
                let unit = match *unit {
                    "m/s²" => "N",
                    _ => "N·m",
                };
                dynamics.push(table.add_row("dynamics", label, unit));
            }
        }
        table.add_row("regularisation", "efforts and forces", "1");
        let normals = names.contacts.iter();
        let normals = normals
            .map(|(name, _)| table.add_row(name, "normal force", "N"))
            .collect();
        Self { dynamics, normals }
    }

    /// How many equations of motion are rows.
    pub(crate) fn dynamics_rows(&self) -> usize {
        self.dynamics.len()
    }
}

const FORCE_LABELS: [(&str, &str); 6] = [
    ("x", "N"),
    ("y", "N"),
    ("normal", "N"),
    ("moment x", "N·m"),
    ("moment y", "N·m"),
    ("moment z", "N·m"),
];

impl VariableNames<'_> {
    /// Gives the physical variables and the groups' slacks their ids.
    pub(super) fn register(&self, groups: &mut [Group], table: &mut Table) -> FirstIds {
        let vdot = table.vars.len() as u32;
        for (label, unit) in &self.accelerations {
            table.add_var("acceleration", label, unit);
        }
        let effort = table.vars.len() as u32;
        for (name, unit) in &self.efforts {
            table.add_var(name, "effort", unit);
        }
        let mut force = Vec::new();
        for (name, directions) in &self.contacts {
            force.push(table.vars.len() as u32);
            for &d in *directions {
                let (label, unit) = FORCE_LABELS[d];
                table.add_var(name, label, unit);
            }
        }
        for group in groups.iter_mut() {
            group.add_slack(table);
        }
        FirstIds {
            vdot,
            effort,
            force,
        }
    }
}
