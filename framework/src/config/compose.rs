//! Putting a configuration together in code, without a file.

use super::{ControllerConfig, Settings};
use crate::{
    constraint::Constraint,
    contact::ContactSpec,
    controller::{Controller, ControllerError},
    entry::Entry,
    qp::QpSolver,
    robot::Robot,
    task::Task,
};

impl ControllerConfig {
    /// A configuration with default settings at a rate in Hz, with the default solver and nothing to do yet.
    pub fn at_rate(rate: f64, robot: impl Robot) -> Self {
        Self::new(Settings::at_rate(rate), Box::new(robot))
    }

    /// Adds a task.
    pub fn with_task(mut self, task: Entry<dyn Task>) -> Self {
        self.tasks.push(task);
        self
    }

    /// Adds a constraint.
    pub fn with_constraint(mut self, constraint: Entry<dyn Constraint>) -> Self {
        self.constraints.push(constraint);
        self
    }

    /// Adds a contact.
    pub fn with_contact(mut self, contact: ContactSpec) -> Self {
        self.contacts.push(contact);
        self
    }

    /// Takes another solver.
    pub fn with_solver(mut self, solver: impl QpSolver) -> Self {
        self.solver = Box::new(solver);
        self
    }

    /// Makes the controller; the same as [`Controller::new`].
    ///
    /// # Errors
    /// [`ControllerError`]: everything that is wrong, as for a file, by name and key instead of line.
    pub fn build(self) -> Result<Controller, ControllerError> {
        Controller::new(self)
    }
}
