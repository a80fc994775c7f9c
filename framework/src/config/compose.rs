//! Putting a configuration together in code, without a file.

use super::{
    ConfigErrors, ControllerConfig,
    document::Document,
    entry::Names,
    expand::{self, Listed, Notes, Reading, Texts},
    load,
    report::Report,
};
use crate::{
    contact::{ContactSpec, ShortContact},
    plugin::{AnyConstraint, AnyFallbackLaw, AnyTask, Entry},
    qp::Solver,
    settings::{MeasurementLimits, Settings},
};
use wbqp_robot_model::Robot;

impl ControllerConfig {
    /// A configuration with default settings at a rate in Hz, with the default solver and nothing to do yet.
    pub fn at_rate(rate: f64, robot: impl Robot) -> Self {
        Self::new(Settings::at_rate(rate), Box::new(robot))
    }

    /// Adds a task.
    pub fn with_task(mut self, task: Entry<dyn AnyTask>) -> Self {
        self.tasks.push(task);
        self
    }

    /// Adds a constraint.
    pub fn with_constraint(mut self, constraint: Entry<dyn AnyConstraint>) -> Self {
        self.constraints.push(constraint);
        self
    }

    /// Adds a contact.
    pub fn with_contact(mut self, contact: ContactSpec) -> Self {
        self.contacts.push(contact);
        self
    }

    /// Adds contacts that bring their own constraints, as a file says them with the key `motion`: the same entries, and
    /// the limits of the actuators if there are none yet. A constraint of the same type for the same contact that is
    /// there already is not brought again.
    ///
    /// # Errors
    /// What is wrong with a contact; a type of constraint that is not linked.
    pub fn with_contacts(
        mut self,
        contacts: impl IntoIterator<Item = ShortContact>,
    ) -> Result<Self, ConfigErrors> {
        let contacts: Vec<String> = contacts
            .into_iter()
            .map(|contact| match toml::Value::try_from(&contact) {
                Ok(table) => table.to_string(),
                // Plain data: it has no value that TOML cannot express.
                Err(_) => String::new(),
            })
            .collect();
        let text = format!("contact = [{}]", contacts.join(", "));
        let mut report = Report::new("", &text, Vec::new());
        let texts = Texts::default();
        let mut notes = Notes::default();
        let mut document = Document::contacts(&text, &mut report);
        expand::fill_names(&mut document, &mut notes);
        let listed = self.listed();
        expand::write_out_contacts(
            &mut document,
            Reading::Record,
            &listed,
            &texts,
            &mut notes,
            &mut report,
        );
        expand::fill_defaults(&mut document, &texts, &mut notes);
        let contacts = load::contacts(document.contacts, &mut report);
        let mut names = Names::default();
        let constraints = load::constraints(document.constraints, &mut names, &mut report);
        report.finish().map_err(ConfigErrors::without_places)?;
        self.contacts.extend(contacts.into_iter().flatten());
        self.constraints.extend(constraints.into_iter().flatten());
        Ok(self)
    }

    /// The constraints that are there, with their contacts, and all names.
    fn listed(&self) -> Listed {
        let of = |constraint: &Entry<dyn AnyConstraint>| {
            let keys = serde_json::to_value(&constraint.plugin).unwrap_or_default();
            let contact = keys.get("contact").and_then(serde_json::Value::as_str);
            (
                constraint.plugin.typetag_name().to_owned(),
                contact.unwrap_or_default().to_owned(),
            )
        };
        let tasks = self.tasks.iter().map(|task| &task.name);
        let names = tasks.chain(self.constraints.iter().map(|constraint| &constraint.name));
        Listed {
            constraints: self.constraints.iter().map(of).collect(),
            names: names.cloned().collect(),
        }
    }

    /// Takes another solver.
    pub fn with_solver(mut self, solver: impl Solver) -> Self {
        self.solver = Box::new(solver);
        self
    }

    /// Another fallback law.
    pub fn with_fallback(mut self, law: impl AnyFallbackLaw) -> Self {
        self.fallback = Box::new(law);
        self
    }

    /// Takes other bounds on what is measured.
    pub fn with_measurement_limits(mut self, limits: MeasurementLimits) -> Self {
        self.measurement = limits;
        self
    }
}
