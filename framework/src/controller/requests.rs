//! What can be asked of a controller between ticks: switches, references, weights, plug-ins by name, and what the last
//! tick gave.
//!
//! What changes something takes effect in the next tick, and ramps and trajectories begin at that tick's time.

use std::any::Any;

use nalgebra::DVector;

use super::{
    Command, Controller, Measurement, Report,
    entry_id::EntryId,
    error::RequestError,
    planned_force::planned_forces,
    record::{Dump, Record, Recorder, blank_record},
    running::RunningPlugin,
    sensitivity::{Before, Sensitivity},
    snapshot::Snapshot,
};
use crate::{
    contact::{ContactId, ContactSpec, ContactState, SurfaceMotion},
    error::BindError,
    fault::Fault,
    plugin::{AnyReference, EntryState, Layout, PerRow, Sample, Setup},
    problem::{BoundEntry, Named},
    qp::{Qp, RowId, Solution, VarId},
    settings::{MeasurementLimits, Settings},
    stopwatch::Stopwatch,
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
    /// the next tick on: for a constant error of the sensor, while nothing is touched. The same goes for all contacts at
    /// its frame, which have one sensor. Nothing happens before the first tick.
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
        self.entries[..self.task_count]
            .iter()
            .map(|g| g.name.as_str())
    }

    /// Names of all tasks, then of all constraints.
    pub fn entry_names(&self) -> impl Iterator<Item = &str> {
        self.entries.iter().map(|entry| entry.name.as_str())
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

    /// Rows of each task with labels and units, in the order of [`Controller::task_names`].
    pub fn task_layouts(&self) -> impl Iterator<Item = &Layout> {
        self.entries[..self.task_count].iter().map(|g| &g.layout)
    }

    /// Names of the contacts, in the order of [`Report::contacts`](super::Report::contacts).
    pub fn contact_names(&self) -> impl Iterator<Item = &str> {
        self.world.bindings.iter().map(|b| b.spec.name.as_str())
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
        let index = self.entry(entry)?.index();
        self.revision += 1;
        let contacts: Vec<ContactSpec> =
            self.world.bindings.iter().map(|b| b.spec.clone()).collect();
        let mut frames = self.world.frame_ids.clone();
        let mut setup = Setup::new(&self.robot, &contacts, self.world.period, &mut frames);
        let RunningPlugin { plugin, tag, .. } = &mut self.plugins[index];
        let BoundEntry { name, layout, .. } = &self.entries[index];
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
        let changed = plugin.change(&mut apply, &mut setup, layout);
        if is_other {
            return Err(RequestError::other_type::<T>(name, tag));
        }
        changed.map_err(|source| RequestError::value(name, source))
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
        let index = self.entry(entry)?.index();
        self.revision += 1;
        let contacts: Vec<ContactSpec> =
            self.world.bindings.iter().map(|b| b.spec.clone()).collect();
        let mut frames = self.world.frame_ids.clone();
        let mut setup = Setup::new(&self.robot, &contacts, self.world.period, &mut frames);
        let entry = &self.entries[index];
        let changed = self.plugins[index].set(keys, entry, &mut setup);
        changed.map_err(|source| RequestError::value(&entry.name, source))
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

    /// Says that what the next tick measures is meant to be elsewhere than what was measured last: the robot was
    /// carried, a simulation was set back, an estimator has found out where it is. The next measurement is compared
    /// with this one.
    ///
    /// Velocity references start at these velocities, filters of forces at these forces, the fallback law takes over
    /// from here if it is at work, and the solver starts without a warm start. What is wanted stays:
    /// references, ramps, integrals and switches go on, and so does the controller's time,
    /// also if the stamp is an earlier one. Efforts stay within `slew` of the last ones. Does not allocate.
    ///
    /// # Errors
    /// What is not usable or not plausible in this measurement by itself; nothing has changed then.
    pub fn reset(&mut self, measurement: &Measurement) -> Result<(), Fault> {
        if let Some(fault) = measurement.fault(&self.robot, self.world.contacts.len(), None) {
            return Err(fault);
        }
        if let Some(implausible) = self.plausible.in_itself(measurement) {
            return Err(implausible);
        }
        let (stamp, period) = (measurement.time, self.world.period);
        // As if it had been measured a period ago, so that a tick may take the same measurement.
        let before = stamp - period;
        if let Some(last) = self.fallback.without_state.time() {
            if stamp <= last && self.world.origin.is_some() {
                self.world.rebase(stamp);
            }
            self.fallback.without_state.renew(before);
        }
        self.fallback.clock.previous = None;
        self.fallback.clock.steady = 0;
        self.world.restart(measurement);
        self.plausible.restart(before);
        self.command.engage(&self.robot.model, &self.world.state);
        if self.fallback.level == super::FallbackLevel::Safe {
            self.fallback.law.engage(&self.world.tick(EntryState::ON));
        }
        self.solver.reset();
        Ok(())
    }

    /// The set points, at a time in s, of the tasks that push, are switched on and have a weight: of each its name, the
    /// contact, and the normal force that its reference says, N.
    ///
    /// For a controller that is only looked at: it has not run and will not. What is asked of it afterwards
    /// ([`follow`](Controller::follow) and so on) counts from one period after that time.
    pub fn planned_forces(&mut self, time: f64) -> Vec<(&str, ContactId, f64)> {
        self.world.time = time;
        self.world.origin = Some(0.0);
        let tick = self.world.tick(EntryState::ON);
        planned_forces(&tick, &self.entries, &mut self.plugins)
    }

    /// Begins to keep what each tick begins with, from the next one on, for [`Controller::sensitivity`]. A tick copies
    /// a few hundred numbers then. Allocates once.
    pub fn keep_beginnings(&mut self) {
        if self.before.is_none() {
            self.before = Some(Box::new(Before::new(self)));
        }
    }

    /// Keeps nothing any more: ticks are as they were before [`Controller::keep_beginnings`], and there are no
    /// derivatives until that is called again.
    pub fn forget_beginnings(&mut self) {
        self.before = None;
    }

    /// Derivatives of the last tick's optimum, accelerations, efforts and contact forces, with respect to weights,
    /// gains, references, and the measured state and wrenches; from one factorisation on the active limits.
    ///
    /// They are those of the tick alone: of what it would have computed from other numbers with the same past. Filters,
    /// the observer and integrals are in it as far as this tick moves them. References are parameters of their own, and
    /// stay what they were when the state is moved, also those that look at it. The command's rounding into its limits
    /// and its velocity references are not part of it. [`Sensitivity::notes`] says where they do not exist.
    ///
    /// Does not allocate, unless keys of an entry were changed since the last call. Nothing of the controller
    /// changes: the next tick is the same to the bit. Not for inside a real-time loop: it takes as long as fifty
    /// to a thousand ticks.
    ///
    /// ```no_run
    /// # fn run(mut controller: wbqp::Controller) -> Result<(), wbqp::controller::RequestError> {
    /// use wbqp::controller::Sensitivity;
    ///
    /// let mut sensitivity = Sensitivity::new(&mut controller);
    /// controller.tick(&controller.measurement());
    /// controller.sensitivity(&mut sensitivity)?;
    /// println!("{sensitivity}");
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`RequestError`]; what is in the storage is of no tick then.
    pub fn sensitivity(&mut self, out: &mut Sensitivity) -> Result<(), RequestError> {
        out.fill(self)
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

    /// Records the last `ticks` ticks, at least one. Costs a copy of the rows per tick.
    ///
    /// # Errors
    /// [`RequestError::Unrecordable`] if a plug-in cannot be written to a file.
    pub fn with_recorder(mut self, ticks: usize) -> Result<Self, RequestError> {
        if let Err(problem) = &self.made_from.configuration {
            return Err(RequestError::Unrecordable {
                problem: problem.clone(),
            });
        }
        let blank = blank_record(&self);
        self.recorder = Some(Recorder::new(&blank, ticks));
        Ok(self)
    }

    /// The recorded ticks if the level has changed in one of them since this was last asked. Allocates: call it outside
    /// the real-time part.
    pub fn take_dump(&mut self) -> Option<Dump> {
        let recorder = self.recorder.as_mut()?;
        if !std::mem::take(&mut recorder.pending) {
            return None;
        }
        self.dump()
    }

    /// The recorded ticks; nothing without a recorder or before the first tick. Allocates.
    pub fn dump(&self) -> Option<Dump> {
        let records: Vec<Record> = self.recorder.as_ref()?.records().cloned().collect();
        let configuration = self.made_from.configuration.clone().ok()?;
        let directory = &self.made_from.directory;
        (!records.is_empty()).then(|| Dump::new(directory, configuration, &self.robot, records))
    }

    /// The robot.
    pub fn robot(&self) -> &RobotModel {
        &self.robot
    }

    /// Rate, formulation and the other settings.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The last command; before the first tick, the one that comes nearest to holding the home posture.
    pub fn command(&self) -> &Command {
        &self.command
    }

    /// The last report.
    pub fn report(&self) -> &Report {
        &self.report
    }

    /// What the command before the first tick leaves unbalanced, `g − S u` at home, N and N·m. Not zero where
    /// the actuators' limits, or a missing direction of thrust, forbid to hold still.
    pub fn hover_residual(&self) -> &DVector<f64> {
        &self.hover_residual
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

    /// A measurement of the right sizes: the home posture at rest at time 0, no force. For drivers to write into.
    pub fn measurement(&self) -> Measurement {
        Measurement::home(&self.robot, self.world.contacts.len())
    }

    /// What a measurement may be: the bounds of the configuration, and those derived from the robot where it says
    /// nothing; of joints and contacts the largest.
    pub fn measurement_limits(&self) -> MeasurementLimits {
        self.plausible.limits()
    }

    /// Name and unit of a row.
    pub fn row(&self, row: RowId) -> Option<&Named> {
        self.report.row(row)
    }

    /// Name and unit of a variable.
    pub fn variable(&self, var: VarId) -> Option<&Named> {
        self.table.vars.get(var.index())
    }

    /// Lets stage times be measured.
    pub fn with_stopwatch(mut self, stopwatch: Box<dyn Stopwatch>) -> Self {
        self.stopwatch = stopwatch;
        self
    }

    /// The position of a task; an error knows tasks alone.
    fn find_task(&self, name: &str) -> Result<usize, RequestError> {
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
