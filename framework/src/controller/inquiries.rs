//! What a controller says of itself, by name: what it has, what it does, and what its last tick gave.

use nalgebra::DVector;

use super::{
    Command, Controller, Measurement, Report, entry_id::EntryId, error::RequestError,
    snapshot::Snapshot,
};
use crate::{
    contact::{ContactId, ContactSpec, ContactState},
    plugin::{Layout, Sample},
    problem::Named,
    qp::{Qp, RowId, Solution, VarId},
    settings::{MeasurementLimits, Settings},
};
use wbqp_robot_model::RobotModel;

impl Controller {
    /// The task or constraint of that name: where it is in lists of them, [`Report::tasks`] for one.
    ///
    /// # Errors
    /// [`RequestError::Absent`], or [`RequestError::IsContact`].
    pub fn entry(&self, name: &str) -> Result<EntryId, RequestError> {
        let names = || self.entries.iter().map(|g| g.name.as_str());
        match names().position(|n| n == name) {
            Some(index) => Ok(EntryId(index as u32)),
            None => Err(self.absent("entry", name, names())),
        }
    }

    /// The contact of that name.
    ///
    /// # Errors
    /// [`RequestError::Absent`].
    pub fn contact(&self, name: &str) -> Result<ContactId, RequestError> {
        let names = || self.world.bindings.iter().map(|b| b.spec.name.as_str());
        match names().position(|n| n == name) {
            Some(i) => Ok(ContactId(i as u32)),
            None => Err(RequestError::absent("contact", name, names())),
        }
    }

    /// Names of the tasks, in the order of [`Report::tasks`](super::Report::tasks).
    pub fn task_names(&self) -> impl Iterator<Item = &str> {
        self.entries[..self.task_count]
            .iter()
            .map(|g| g.name.as_str())
    }

    /// Rows of each task with labels and units, in the order of [`Controller::task_names`].
    pub fn task_layouts(&self) -> impl Iterator<Item = &Layout> {
        self.entries[..self.task_count].iter().map(|g| &g.layout)
    }

    /// Names of the contacts, in the order of [`Report::contacts`](super::Report::contacts).
    pub fn contact_names(&self) -> impl Iterator<Item = &str> {
        self.world.bindings.iter().map(|b| b.spec.name.as_str())
    }

    /// Names of all tasks, then of all constraints.
    pub fn entry_names(&self) -> impl Iterator<Item = &str> {
        self.entries.iter().map(|entry| entry.name.as_str())
    }

    /// A contact as configured. Panics only for an id of another controller.
    pub fn contact_spec(&self, contact: ContactId) -> &ContactSpec {
        &self.world.bindings[contact.index()].spec
    }

    /// A contact as of the last tick: kinematics, switch, forces. Panics only for an id of another controller.
    pub fn contact_state(&self, contact: ContactId) -> &ContactState {
        &self.world.contacts[contact.index()]
    }

    /// What a task followed in its last update, of the first reference that it follows; before the first, where that
    /// begins.
    ///
    /// # Errors
    /// [`RequestError`] if the task does not exist or follows nothing.
    pub fn followed(&self, task: &str) -> Result<&Sample, RequestError> {
        let index = self.find_task(task)?;
        match self.plugins[index].references.first() {
            Some(followed) => Ok(&followed.sample),
            None => Err(RequestError::NoReference {
                name: self.entries[index].name.clone(),
            }),
        }
    }

    /// The weight of each row that a task or constraint has or, during a ramp, goes to; none of bounds and hard limits.
    ///
    /// # Errors
    /// [`RequestError`] if there is no such entry.
    pub fn weight(&self, entry: &str) -> Result<&[f64], RequestError> {
        let index = self.entry(entry)?.index();
        Ok(self.entries[index].weight.wanted())
    }

    /// Whether a task or constraint is to be on: what was asked for last, also while it ramps or waits for the next
    /// tick.
    ///
    /// # Errors
    /// [`RequestError`] if there is no such entry.
    pub fn is_on(&self, entry: &str) -> Result<bool, RequestError> {
        let index = self.entry(entry)?.index();
        Ok(self.entries[index].switch.is_wanted())
    }

    /// Whether a contact is to be on: what was asked for last, also while it ramps or waits for the next tick.
    ///
    /// # Errors
    /// [`RequestError::Absent`].
    pub fn is_contact_on(&self, name: &str) -> Result<bool, RequestError> {
        let i = self.contact(name)?.index();
        Ok(self.world.bindings[i].switch.is_wanted())
    }

    /// The keys of a task or constraint with their present values, as its file would have them: what
    /// [`Controller::set`] replaces.
    ///
    /// # Errors
    /// [`RequestError`] if there is no such entry, or its parameters cannot be written in TOML.
    pub fn parameters(&self, entry: &str) -> Result<toml::Table, RequestError> {
        let index = self.entry(entry)?.index();
        let parameters = self.plugins[index].parameters();
        parameters.map_err(|source| RequestError::value(&self.entries[index].name, source))
    }

    /// The last command; before the first tick, the one that comes nearest to holding the home posture.
    pub fn command(&self) -> &Command {
        &self.command
    }

    /// The last report.
    pub fn report(&self) -> &Report {
        &self.report
    }

    /// Why the last tick did not end with the optimum of its problem, by name: [`Report::explain`].
    pub fn explain(&self) -> Option<String> {
        self.report.explain()
    }

    /// Room for a copy of what a tick took and gave, to be filled after each by [`Snapshot::take`]; until then it has
    /// the last tick's command and report, and the home measurement. Allocates.
    pub fn snapshot(&self) -> Snapshot {
        Snapshot::of(self)
    }

    /// The problem of the last tick, in physical units.
    pub fn problem(&self) -> &Qp {
        &self.qp
    }

    /// Its solution, in physical units; on the level [`Relaxed`](super::FallbackLevel::Relaxed) that of the relaxed
    /// problem, as far as it is about the same variables and rows.
    pub fn solution(&self) -> &Solution {
        &self.solution
    }

    /// What the substitution of variables took from row `i` of [`Controller::problem`]: its value, and its limits, as
    /// its owner wrote them are larger by that, in the row's unit.
    pub fn row_constant(&self, i: usize) -> f64 {
        self.problem.constant(i)
    }

    /// Name and unit of a row.
    pub fn row(&self, row: RowId) -> Option<&Named> {
        self.report.row(row)
    }

    /// Name and unit of a variable.
    pub fn variable(&self, var: VarId) -> Option<&Named> {
        self.table.vars.get(var.index())
    }

    /// The robot.
    pub fn robot(&self) -> &RobotModel {
        &self.robot
    }

    /// Rate, formulation and the other settings.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// What the command before the first tick leaves unbalanced, `g − S u` at home, N and N·m. Not zero where
    /// the actuators' limits, or a missing direction of thrust, forbid to hold still.
    pub fn hover_residual(&self) -> &DVector<f64> {
        &self.hover_residual
    }

    /// A measurement of the right sizes: the home posture at rest at time 0, no force. For drivers to write into.
    pub fn measurement(&self) -> Measurement {
        Measurement::home(&self.robot, self.world.contacts.len())
    }

    /// What a measurement may be: the bounds of the configuration, and those derived from the robot where it says
    /// nothing; of joints and contacts the largest.
    pub fn measurement_limits(&self) -> MeasurementLimits {
        self.plausible.limits()
    }

    /// The position of a task; an error knows tasks alone.
    pub(super) fn find_task(&self, name: &str) -> Result<usize, RequestError> {
        match self.task_names().position(|n| n == name) {
            Some(index) => Ok(index),
            None => Err(self.absent("task", name, self.task_names())),
        }
    }

    /// There is no such entry; perhaps it is a contact.
    fn absent<'a>(
        &self,
        kind: &'static str,
        name: &str,
        known: impl Iterator<Item = &'a str>,
    ) -> RequestError {
        if self.contact(name).is_ok() {
            let name = name.to_owned();
            return RequestError::IsContact { name };
        }
        RequestError::absent(kind, name, known)
    }
}
