//! Collects what does not fit the robot, so that all of it is reported at once.

use std::collections::HashMap;

use crate::{
    contact::ContactSpec,
    error::BindError,
    one_line::{CONTROL, one_line},
    plugin::{AnyConstraint, AnyPlugin, AnyTask, Entry},
    settings::{MeasurementLimits, Settings, Target},
};
use wbqp_dynamics::model::{Base, Model};

/// One thing that does not fit the robot.
#[derive(Debug)]
pub(crate) struct Misfit {
    pub(crate) target: Target,
    /// Whose it is in messages, such as ``task[0] `arm` (posture)``.
    pub(crate) subject: String,
    pub(crate) kind: MisfitKind,
    pub(crate) error: BindError,
}

/// The sort of a [`Misfit`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MisfitKind {
    /// A parameter, as its error says.
    Parameter,
    /// Nothing carries the robot at the start.
    Hover,
}

/// Everything that does not fit so far.
#[derive(Debug, Default)]
pub(super) struct Misfits {
    /// With the place of what is wrong among its kind.
    list: Vec<(usize, Misfit)>,
    is_too_large: bool,
}

impl Misfits {
    pub(super) fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Everything that was collected, as an error.
    pub(super) fn stop_if_any(&mut self) -> Result<(), Vec<Misfit>> {
        if self.list.is_empty() {
            return Ok(());
        }
        // In the order of a file, whatever was looked at first.
        let rank = |target: &Target| match target {
            Target::Controller => 0,
            Target::Robot => 1,
            Target::Solver => 2,
            Target::Fallback => 3,
            Target::Measurement => 4,
            Target::Contact(_) => 5,
            Target::Task(_) => 6,
            Target::Constraint(_) => 7,
        };
        let mut list = std::mem::take(&mut self.list);
        list.sort_by_key(|(index, misfit)| (rank(&misfit.target), *index));
        Err(list.into_iter().map(|(_, misfit)| misfit).collect())
    }

    fn add(&mut self, target: Target, index: usize, subject: String, error: BindError) {
        let misfit = Misfit {
            target,
            subject,
            kind: MisfitKind::Parameter,
            error,
        };
        self.list.push((index, misfit));
    }

    pub(super) fn settings(&mut self, settings: &Settings, model: &Model) {
        for (key, problem) in settings.problems() {
            let error = BindError::value(key, problem);
            self.add(Target::Controller, 0, "controller".to_owned(), error);
        }
        let wrench = settings.observer.as_ref().map_or(0.0, |o| o.wrench);
        if wrench > 0.0 && model.base() == Base::Fixed {
            let problem = "the robot's base is fixed: no wrench on it is observed; leave it out, and velocities are";
            let error = BindError::value("observer.wrench", problem);
            self.add(Target::Controller, 0, "controller".to_owned(), error);
        }
    }

    pub(super) fn measurement(&mut self, limits: &MeasurementLimits, rate: f64) {
        // Of a rate that is none something is said already.
        let rate = Some(rate).filter(|rate| rate.is_finite() && *rate > 0.0);
        for (key, problem) in limits.problems(rate) {
            let error = BindError::value(key, problem);
            self.add(Target::Measurement, 0, "measurement".to_owned(), error);
        }
    }

    pub(super) fn robot(&mut self, tag: &str, problems: Vec<String>) {
        for problem in problems {
            let subject = format!("robot ({tag})");
            self.add(Target::Robot, 0, subject, BindError::Other(problem));
        }
    }

    pub(super) fn hover(&mut self, tag: &str, missing: String) {
        let error = BindError::Other(missing);
        let misfit = Misfit {
            target: Target::Robot,
            subject: format!("robot ({tag})"),
            kind: MisfitKind::Hover,
            error,
        };
        self.list.push((0, misfit));
    }

    pub(super) fn solver(&mut self, tag: &str, bound: Result<(), BindError>) {
        if let Err(error) = bound {
            self.add(Target::Solver, 0, format!("solver ({tag})"), error);
        }
    }

    /// What takes more than it may.
    pub(super) fn fallback(&mut self, tag: &str, error: BindError) {
        self.add(Target::Fallback, 0, format!("fallback ({tag})"), error);
    }

    pub(super) fn memory(&mut self, checked: Result<(), BindError>) {
        if let Err(error) = checked {
            self.is_too_large = true;
            self.add(Target::Controller, 0, "controller".to_owned(), error);
        }
    }

    /// Everything that was collected, if there is no going on without taking more than may be taken.
    pub(super) fn stop_if_too_large(&mut self) -> Result<(), Vec<Misfit>> {
        if self.is_too_large {
            self.stop_if_any()
        } else {
            Ok(())
        }
    }

    pub(super) fn contact(&mut self, index: usize, name: &str, error: BindError) {
        let subject = format!("contact[{index}] `{}`", one_line(name));
        self.add(Target::Contact(name.to_owned()), index, subject, error);
    }

    pub(super) fn entry<P: AnyPlugin + ?Sized>(
        &mut self,
        index: usize,
        entry: &Entry<P>,
        error: BindError,
    ) {
        let (name, tag) = (&entry.name, entry.plugin.tag());
        let (target, list) = if P::IS_TASK {
            (Target::Task(name.clone()), "task")
        } else {
            (Target::Constraint(name.clone()), "constraint")
        };
        let subject = format!("{list}[{index}] `{}` ({tag})", one_line(name));
        self.add(target, index, subject, error);
    }

    /// Names that are empty, have control characters or are given twice: possible only in code, files are checked when
    /// they are read.
    pub(super) fn names(
        &mut self,
        contacts: &[ContactSpec],
        tasks: &[Entry<dyn AnyTask>],
        constraints: &[Entry<dyn AnyConstraint>],
    ) {
        let taken = |by: &str| BindError::value("name", format!("is taken by {by}"));
        let unfit = |name: &str| match name {
            "" => Some(BindError::value("name", "must not be empty")),
            name if name.contains(char::is_control) => Some(BindError::value("name", CONTROL)),
            _ => None,
        };
        let first_contact = first_of(contacts.iter().map(|contact| contact.name.as_str()));
        for (index, contact) in contacts.iter().enumerate() {
            let first = first_contact.get(contact.name.as_str()).copied();
            if let Some(error) = unfit(&contact.name) {
                self.contact(index, &contact.name, error);
            } else if let Some(first) = first.filter(|&first| first < index) {
                let by = format!("contact[{first}]");
                self.contact(index, &contact.name, taken(&by));
            }
        }
        let first_task = first_of(tasks.iter().map(|task| task.name.as_str()));
        let first_task = |name: &str| first_task.get(name).copied();
        let first_constraint = first_of(constraints.iter().map(|one| one.name.as_str()));
        for (index, entry) in tasks.iter().enumerate() {
            if let Some(error) = unfit(&entry.name) {
                self.entry(index, entry, error);
            } else if let Some(first) = first_task(&entry.name).filter(|&first| first < index) {
                self.entry(index, entry, taken(&format!("task[{first}]")));
            }
        }
        for (index, entry) in constraints.iter().enumerate() {
            if let Some(error) = unfit(&entry.name) {
                self.entry(index, entry, error);
            } else if let Some(first) = first_task(&entry.name) {
                self.entry(index, entry, taken(&format!("task[{first}]")));
            } else if let Some(&first) = first_constraint.get(entry.name.as_str())
                && first < index
            {
                self.entry(index, entry, taken(&format!("constraint[{first}]")));
            }
        }
    }
}

/// The first place of each name.
fn first_of<'a>(names: impl Iterator<Item = &'a str>) -> HashMap<&'a str, usize> {
    let mut first = HashMap::new();
    for (index, name) in names.enumerate() {
        first.entry(name).or_insert(index);
    }
    first
}
