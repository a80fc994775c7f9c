//! What can be asked of a controller between ticks: switches, references, weights, parameters.
//!
//! It takes effect in the next tick, and ramps and trajectories begin at that tick's time.

use std::any::Any;

use super::{Controller, error::RequestError, running::RunningPlugin};
use crate::{
    contact::{ContactSpec, SurfaceMotion},
    error::BindError,
    plugin::{AnyReference, PerRow, Setup},
    problem::BoundEntry,
};

impl Controller {
    /// Switches an entry (task or constraint) on, with its ramp. Nothing happens if it is on.
    ///
    /// # Errors
    /// [`RequestError`] if there is no such entry.
    pub fn activate(&mut self, entry: &str) -> Result<(), RequestError> {
        let index = self.entry(entry)?.index();
        self.entries[index].switch.turn(true);
        Ok(())
    }

    /// Switches an entry off, with its ramp. Nothing happens if it is off.
    ///
    /// # Errors
    /// [`RequestError`] if there is no such entry.
    pub fn deactivate(&mut self, entry: &str) -> Result<(), RequestError> {
        let index = self.entry(entry)?.index();
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

    /// Takes what the contact's force-torque sensor says now, on average over about half a second, for its zero, from
    /// the next tick on: for a constant error of the sensor, while nothing is touched. The same goes for all contacts
    /// at its frame, which have one sensor. Nothing happens before the first tick.
    ///
    /// # Errors
    /// [`RequestError::Absent`].
    pub fn tare(&mut self, contact: &str) -> Result<(), RequestError> {
        let i = self.contact(contact)?.index();
        for k in 0..self.world.bindings.len() {
            if self.world.bindings[k].spec.frame == self.world.bindings[i].spec.frame {
                self.world.bindings[k].zero.take();
            }
        }
        Ok(())
    }

    /// Gives a task another trajectory, in place of the first that it follows. It begins one period after the last
    /// tick (before the first tick: with that), from what the task followed until then. Allocates.
    ///
    /// ```text
    /// controller.follow("arm", MinJerk::new([0.0, 0.3, 0.9], 2.0))?;
    /// ```
    ///
    /// # Errors
    /// [`RequestError`] if the task does not exist, follows nothing, or the trajectory does not fit; the old
    /// one is kept then.
    pub fn follow(
        &mut self,
        task: &str,
        reference: impl Into<Box<dyn AnyReference>>,
    ) -> Result<(), RequestError> {
        let index = self.find_task(task)?;
        let begin = self.world.next_time();
        let name = &self.entries[index].name;
        let Some(followed) = self.plugins[index].references.first_mut() else {
            return Err(RequestError::NoReference { name: name.clone() });
        };
        let replaced = followed.replace(&*reference.into(), begin);
        replaced.map_err(|source| RequestError::value(name, source))
    }

    /// Moves a contact's surface; its pose, twist and acceleration hold from the next tick on.
    ///
    /// # Errors
    /// [`RequestError`] if there is no such contact or a number is not finite.
    pub fn move_surface(&mut self, name: &str, motion: &SurfaceMotion) -> Result<(), RequestError> {
        let i = self.contact(name)?.index();
        if !motion.is_finite() {
            let source = BindError::value("surface", "has a number that is not finite");
            return Err(RequestError::value(name, source));
        }
        self.world.bindings[i].move_surface(motion);
        Ok(())
    }

    /// Gives an entry another weight, to which it goes from the next tick on with the entry's ramp.
    ///
    /// # Errors
    /// [`RequestError`] if the entry does not exist or the weight does not fit its rows.
    pub fn reweight(&mut self, entry: &str, weight: impl Into<PerRow>) -> Result<(), RequestError> {
        let index = self.entry(entry)?.index();
        let entry = &mut self.entries[index];
        let changed = entry.reweight(&weight.into());
        changed.map_err(|problem| {
            RequestError::value(&entry.name, BindError::value("weight", problem))
        })
    }

    /// Changes parameters of a task or constraint between two ticks. The plug-in checks them as it does those of a
    /// file; whether a number is one that can be meant is asked of files alone. They hold from the next tick on, at
    /// once. Nothing else follows them: a damping that was critical stays what it was. What was resolved when the
    /// controller was made stays: frames and joints that are named, references, which [`Controller::follow`] replaces,
    /// and where these count from (`origin` of `free_motion`). Allocates.
    ///
    /// ```text
    /// controller.change("arm", |arm: &mut Posture| arm.kp = 40.0.into())?;
    /// ```
    ///
    /// # Errors
    /// [`RequestError`] if there is no such entry, it is of another type, or refuses what it would have become; the old
    /// parameters are kept then.
    pub fn change<T: Any>(
        &mut self,
        entry: &str,
        change: impl FnOnce(&mut T),
    ) -> Result<(), RequestError> {
        self.with_setup(entry, |plugin, entry, setup| {
            let mut change = Some(change);
            let mut is_other = false;
            let mut apply = |parameters: &mut dyn Any| match parameters.downcast_mut::<T>() {
                Some(parameters) => {
                    if let Some(change) = change.take() {
                        change(parameters);
                    }
                }
                None => is_other = true,
            };
            let changed = plugin.plugin.change(&mut apply, setup, &entry.layout);
            if is_other {
                return Err(RequestError::other_type::<T>(&entry.name, plugin.tag));
            }
            changed.map_err(|source| RequestError::value(&entry.name, source))
        })
    }

    /// Replaces keys of a task or constraint between two ticks, named and written as in its file, all or none; checked
    /// by the plug-in as those of a file are. What [`Controller::change`] says holds here as well. Allocates.
    ///
    /// ```text
    /// controller.set("arm", wbqp::toml::toml! { kp = 40.0 })?;
    /// ```
    ///
    /// # Errors
    /// [`RequestError`] if there is no such entry, or it has no such key or refuses what it would have become; the old
    /// parameters are kept then.
    pub fn set(&mut self, entry: &str, keys: toml::Table) -> Result<(), RequestError> {
        self.with_setup(entry, |plugin, entry, setup| {
            let changed = plugin.set(keys, entry, setup);
            changed.map_err(|source| RequestError::value(&entry.name, source))
        })
    }

    /// The parameters of a task or constraint, to read or change them between two ticks without a check and without
    /// allocating; [`Controller::change`] checks. The next tick survives whatever they are, since rows that are not
    /// finite make it fall back and say so, but the robot does what they say.
    ///
    /// # Errors
    /// [`RequestError`] if there is no such entry or it is of another type.
    pub fn parameters_mut<T: Any>(&mut self, entry: &str) -> Result<&mut T, RequestError> {
        let index = self.entry(entry)?.index();
        self.revision += 1;
        let (name, tag) = (&self.entries[index].name, self.plugins[index].tag);
        let parameters = self.plugins[index].plugin.parameters_mut();
        parameters
            .downcast_mut::<T>()
            .ok_or_else(|| RequestError::other_type::<T>(name, tag))
    }

    /// Changes a plug-in that is then bound again, to see whether it still fits the rows of its entry.
    fn with_setup(
        &mut self,
        entry: &str,
        change: impl FnOnce(&mut RunningPlugin, &BoundEntry, &mut Setup<'_>) -> Result<(), RequestError>,
    ) -> Result<(), RequestError> {
        let index = self.entry(entry)?.index();
        self.revision += 1;
        let contacts: Vec<ContactSpec> =
            self.world.bindings.iter().map(|b| b.spec.clone()).collect();
        let mut frames = self.world.frame_ids.clone();
        let mut setup = Setup::new(&self.robot, &contacts, self.world.period, &mut frames);
        change(&mut self.plugins[index], &self.entries[index], &mut setup)
    }
}
