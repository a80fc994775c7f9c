//! What can be asked of a running controller between ticks: switches, references, weights, plug-ins by name.
//!
//! It takes effect in the next tick, and ramps and trajectories begin at that tick's time.

use super::{Controller, error::RequestError};
use crate::{
    contact::{ContactId, ContactSpec, ContactState, SurfaceMotion},
    error::BindError,
    plugin::{Layout, Reference, Task, Weight},
    problem::{BoundEntry, Treatment},
};

impl Controller {
    /// Switches an entry (task or constraint) on, with its ramp. Nothing happens if it is on.
    ///
    /// # Errors
    /// [`RequestError::Absent`].
    pub fn activate(&mut self, name: &str) -> Result<(), RequestError> {
        let index = self.entry(name)?;
        self.entries[index].switch.turn(true);
        Ok(())
    }

    /// Switches an entry off, with its ramp. Nothing happens if it is off.
    ///
    /// # Errors
    /// [`RequestError::Absent`].
    pub fn deactivate(&mut self, name: &str) -> Result<(), RequestError> {
        let index = self.entry(name)?;
        self.entries[index].switch.turn(false);
        Ok(())
    }

    /// Switches a contact on: its forces enter the problem, its rows and those of its tasks follow its ramp,
    /// set points start at the force measured in the next tick, integrators start at zero.
    ///
    /// # Errors
    /// [`RequestError::Absent`].
    pub fn activate_contact(&mut self, name: &str) -> Result<(), RequestError> {
        let i = self.contact(name)?.index();
        self.world.bindings[i].switch.turn(true);
        Ok(())
    }

    /// Switches a contact off; with a ramp, its force goes from where it is to zero.
    ///
    /// # Errors
    /// [`RequestError::Absent`].
    pub fn deactivate_contact(&mut self, name: &str) -> Result<(), RequestError> {
        let i = self.contact(name)?.index();
        self.world.bindings[i].switch.turn(false);
        Ok(())
    }

    /// Gives a task another trajectory. It begins one period after the last tick (before the first tick: with
    /// that), from what the task followed until then.
    ///
    /// # Errors
    /// [`RequestError`] if the task does not exist, follows nothing, or the trajectory does not fit; the old
    /// one is kept then.
    pub fn follow(
        &mut self,
        task: &str,
        reference: Box<dyn Reference>,
    ) -> Result<(), RequestError> {
        let index = self.task_index(task)?;
        let begin = self.world.next_time();
        redirect(&mut *self.tasks[index], task, reference, begin)
    }

    /// Moves a contact's surface; its pose, twist and acceleration hold from the next tick on.
    ///
    /// # Errors
    /// [`RequestError`] if there is no such contact or a number is not finite.
    pub fn move_surface(&mut self, name: &str, motion: &SurfaceMotion) -> Result<(), RequestError> {
        let i = self.contact(name)?.index();
        if !motion.is_finite() {
            return Err(RequestError::Value {
                name: name.to_owned(),
                source: BindError::value("surface", "has a number that is not finite"),
            });
        }
        self.world.bindings[i].move_surface(motion);
        Ok(())
    }

    /// Gives an entry another weight, to which it goes from the next tick on with the entry's ramp.
    ///
    /// # Errors
    /// [`RequestError`] if the entry does not exist or the weight does not fit its rows.
    pub fn reweight(&mut self, name: &str, weight: &Weight) -> Result<(), RequestError> {
        let index = self.entry(name)?;
        reweight(&mut self.entries[index], weight)
    }

    /// The contact of that name.
    ///
    /// # Errors
    /// [`RequestError::Absent`].
    pub fn contact(&self, name: &str) -> Result<ContactId, RequestError> {
        let names = || self.world.bindings.iter().map(|b| b.spec.name.as_str());
        match names().position(|n| n == name) {
            Some(i) => Ok(ContactId(i as u32)),
            None => Err(absent("contact", name, names())),
        }
    }

    /// A contact as configured. Panics only for an id of another controller.
    pub fn contact_spec(&self, contact: ContactId) -> &ContactSpec {
        &self.world.bindings[contact.index()].spec
    }

    /// A contact as of the last tick: kinematics, switch, forces. Panics only for an id of another controller.
    pub fn contact_state(&self, contact: ContactId) -> &ContactState {
        &self.world.contacts[contact.index()]
    }

    /// Names of the tasks, in the order of [`Report::tasks`](super::Report::tasks).
    pub fn task_names(&self) -> impl Iterator<Item = &str> {
        self.entries[..self.tasks.len()]
            .iter()
            .map(|g| g.name.as_str())
    }

    /// Rows of each task with labels and units, in the order of [`Controller::task_names`].
    pub fn task_layouts(&self) -> impl Iterator<Item = &Layout> {
        self.entries[..self.tasks.len()].iter().map(|g| &g.layout)
    }

    /// Names of the contacts, in the order of [`Report::contacts`](super::Report::contacts).
    pub fn contact_names(&self) -> impl Iterator<Item = &str> {
        self.world.bindings.iter().map(|b| b.spec.name.as_str())
    }

    fn entry(&self, name: &str) -> Result<usize, RequestError> {
        let names = || self.entries.iter().map(|g| g.name.as_str());
        let found = names().position(|n| n == name);
        found.ok_or_else(|| absent("entry", name, names()))
    }

    pub(super) fn task_index(&self, name: &str) -> Result<usize, RequestError> {
        let found = self.task_names().position(|n| n == name);
        found.ok_or_else(|| absent("task", name, self.task_names()))
    }

    /// The position of a constraint among all entries.
    pub(super) fn constraint_index(&self, name: &str) -> Result<usize, RequestError> {
        let first = self.tasks.len();
        let names = || self.entries[first..].iter().map(|g| g.name.as_str());
        let found = names().position(|n| n == name);
        found
            .map(|index| first + index)
            .ok_or_else(|| absent("constraint", name, names()))
    }
}

/// Gives a task another trajectory that begins at a time.
pub(super) fn redirect(
    task: &mut dyn Task,
    name: &str,
    mut reference: Box<dyn Reference>,
    begin: f64,
) -> Result<(), RequestError> {
    let name = || name.to_owned();
    let follow = task
        .follow()
        .ok_or_else(|| RequestError::NoReference { name: name() })?;
    reference
        .bind(&follow.start(begin))
        .map_err(|source| RequestError::Value {
            name: name(),
            source,
        })?;
    *follow.reference = reference;
    Ok(())
}

/// Lets the rows of a entry go to another weight.
pub(super) fn reweight(entry: &mut BoundEntry, weight: &Weight) -> Result<(), RequestError> {
    let rows = entry.weight.now().len();
    let refused = |problem: String| RequestError::Value {
        name: entry.name.clone(),
        source: BindError::value("weight", problem),
    };
    let usable = weight.values().iter().all(|w| w.is_finite() && *w >= 0.0)
        && (matches!(weight, Weight::Uniform(_)) || weight.values().len() == rows);
    if !usable {
        return Err(refused(format!(
            "must be one number, or {rows}, finite and not negative"
        )));
    }
    if entry.treatment == Treatment::Slack && weight.values().iter().all(|w| *w == 0.0) {
        let problem = "is zero: a soft inequality without price limits nothing";
        return Err(refused(problem.to_owned()));
    }
    entry.weight.turn(weight);
    Ok(())
}

fn absent<'a>(
    kind: &'static str,
    name: &str,
    known: impl Iterator<Item = &'a str>,
) -> RequestError {
    // The same list and guess as when a plug-in names something that does not exist.
    match BindError::unknown(kind, name, known) {
        BindError::Unknown {
            kind,
            name,
            hint,
            known,
        } => RequestError::Absent {
            kind,
            name,
            hint,
            known,
        },
        other => RequestError::Value {
            name: name.to_owned(),
            source: other,
        },
    }
}
