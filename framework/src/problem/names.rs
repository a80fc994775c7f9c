//! Permanent names for the physical variables and for the framework's own rows.

use super::{BoundEntry, Table, partition::FirstIds};
use crate::{
    contact::{COMPONENTS, ContactSpec},
    qp::RowId,
    settings::Formulation,
};
use wbqp_dynamics::{
    actuator::ActuatorKind,
    model::{Base, JointKind, Model},
};
use wbqp_robot_model::RobotModel;

/// Names of the efforts and of the contacts' force components.
pub(crate) struct VariableNames<'a> {
    pub(crate) accelerations: Vec<(String, &'static str)>,
    pub(crate) efforts: Vec<(&'a str, &'static str)>,
    pub(crate) contacts: Vec<(&'a str, &'static [usize])>,
}

impl<'a> VariableNames<'a> {
    pub(crate) fn new(robot: &'a RobotModel, contacts: &'a [ContactSpec]) -> Self {
        let unit = |kind| effort_unit(&robot.model, kind);
        let efforts = robot.actuators.iter();
        let contacts = contacts.iter();
        Self {
            accelerations: acceleration_names(&robot.model),
            efforts: efforts.map(|a| (a.name.as_str(), unit(&a.kind))).collect(),
            contacts: contacts
                .map(|c| (c.name.as_str(), c.kind.constrained()))
                .collect(),
        }
    }
}

fn acceleration_names(model: &Model) -> Vec<(String, &'static str)> {
    let base: &[(&str, &str)] = match model.base() {
        Base::Floating => &[
            ("base x", "m/s²"),
            ("base y", "m/s²"),
            ("base z", "m/s²"),
            ("base roll", "rad/s²"),
            ("base pitch", "rad/s²"),
            ("base yaw", "rad/s²"),
        ],
        Base::Fixed => &[],
    };
    let base = base.iter().map(|(name, unit)| ((*name).to_owned(), *unit));
    let joints = model.joints().iter().map(|j| {
        let unit = match j.kind {
            JointKind::Revolute => "rad/s²",
            JointKind::Prismatic => "m/s²",
        };
        (j.name.clone(), unit)
    });
    base.chain(joints).collect()
}

fn effort_unit(model: &Model, kind: &ActuatorKind) -> &'static str {
    match kind {
        ActuatorKind::Joint(motor) => match model.joints()[motor.joint.index()].kind {
            JointKind::Revolute => "N·m",
            JointKind::Prismatic => "N",
        },
        ActuatorKind::Rotor(_) => "N",
    }
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

impl VariableNames<'_> {
    /// Gives the physical variables and the entries' slacks their ids.
    pub(super) fn register(&self, entries: &mut [BoundEntry], table: &mut Table) -> FirstIds {
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
                let (label, unit) = COMPONENTS[d];
                table.add_var(name, label, unit);
            }
        }
        for entry in entries.iter_mut() {
            entry.add_slack(table);
        }
        FirstIds {
            vdot,
            effort,
            force,
        }
    }
}
