//! Copies what a tick depends on into a record, and back.

use std::path::PathBuf;

use nalgebra::{Quaternion, UnitQuaternion, Vector6};

use super::{
    super::{
        Command, Controller, Measurement, Report, RequestError,
        bounds::Seen,
        fallback::{Age, Clock, Fallback},
        world::World,
    },
    CommandRecord, ContactMemory, Dump, EntryRecord, Memory, Outcome, Record, Recorder,
    StateRecord,
};
use crate::qp::WarmStart;
use wbqp_dynamics::state::State;

/// What a controller was made from.
#[derive(Debug)]
pub(crate) struct MadeFrom {
    /// Where relative paths count from.
    pub(crate) directory: PathBuf,
    /// As TOML, or why it cannot be written so.
    pub(crate) configuration: Result<String, String>,
}

/// A record of the controller's sizes.
pub(in super::super) fn blank_record(controller: &Controller) -> Record {
    let entries = controller.entries.iter().map(|bound| EntryRecord {
        name: bound.name.clone(),
        weight: bound.weight.now().to_vec(),
        vdot: bound.store.vdot.clone(),
        effort: bound.store.effort.clone(),
        forces: bound.store.forces.clone(),
        lower: bound.store.lower.clone(),
        upper: bound.store.upper.clone(),
        bound_lower: bound.store.bound_lower.clone(),
        bound_upper: bound.store.bound_upper.clone(),
        error: bound.store.error.clone(),
        ..EntryRecord::default()
    });
    let capacity = controller.qp.capacity();
    let relaxed = controller.fallback.relaxation.qp.capacity().vars;
    let before = blank_memory(&controller.world);
    let state = before.state.clone();
    let command = blank_command(&controller.command);
    Record {
        measured: state,
        wrenches: vec![[0.0; 6]; controller.world.contacts.len()],
        before: Memory {
            command: command.clone(),
            held: vec![0.0; controller.fallback.law.memory.len()],
            warm: WarmStart::with_capacity(capacity.vars),
            relaxed_warm: WarmStart::with_capacity(relaxed),
            proof: WarmStart::with_capacity(relaxed + 1),
            needed: controller.fallback.relaxation.needed.clone(),
            ..before
        },
        entries: entries.collect(),
        outcome: Outcome {
            command,
            x: vec![0.0; capacity.vars],
            ..Outcome::default()
        },
        ..Record::default()
    }
}

/// Room for what the measured world remembers.
pub(in super::super) fn blank_memory(world: &World) -> Memory {
    let nv = world.last.vdot.len();
    Memory {
        state: blank_state(&world.state),
        contacts: vec![ContactMemory::default(); world.contacts.len()],
        asked: vec![0.0; nv],
        vdot: vec![0.0; nv],
        sent: vec![0.0; world.last.effort.len()],
        ..Memory::default()
    }
}

/// What the measured world remembers from tick to tick.
pub(in super::super) fn remember_world(world: &World, before: &mut Memory) {
    before.time = world.time;
    before.origin = world.origin;
    write_state(&world.state, &mut before.state);
    let contacts = world.contacts.iter().zip(&world.bindings);
    for (out, (contact, binding)) in before.contacts.iter_mut().zip(contacts) {
        binding.remember(contact, out);
        out.measured = contact.measured.into();
        out.measured_at_switch = contact.measured_at_switch.into();
        out.set_point = contact.set_point.into();
        out.solution = contact.solution.into();
    }
    let observer = world.observer.as_ref();
    before.disturbance = observer.map_or([0.0; 6], |observer| observer.disturbance.into());
    before.is_blind = observer.is_some_and(|observer| observer.is_blind);
    let last = &world.last;
    copy(&mut before.asked, last.virtual_input.as_slice());
    copy(&mut before.vdot, last.vdot.as_slice());
    copy(&mut before.sent, last.effort.as_slice());
}

/// Remembers it again, with everything computed that depends on the state then.
pub(in super::super) fn recall_world(world: &mut World, before: &Memory) {
    read_state(&before.state, &mut world.state);
    world.time = before.time;
    world.refresh();
    recall_filters(world, before);
    let (time, model, data) = (world.time, &world.model, &world.data);
    let contacts = world.contacts.iter_mut().zip(&mut world.bindings);
    for ((contact, binding), memory) in contacts.zip(&before.contacts) {
        binding.place_as_then(time, model, data, memory, contact);
    }
}

/// Remembers what a measurement does not replace; the state and what depends on it stays.
pub(in super::super) fn recall_filters(world: &mut World, before: &Memory) {
    world.time = before.time;
    world.origin = before.origin;
    let contacts = world.contacts.iter_mut().zip(&mut world.bindings);
    for (memory, (contact, binding)) in before.contacts.iter().zip(contacts) {
        binding.recall(memory);
        contact.measured = memory.measured.into();
        contact.measured_at_switch = memory.measured_at_switch.into();
        contact.set_point = memory.set_point.into();
        contact.solution = memory.solution.into();
    }
    if let Some(observer) = &mut world.observer {
        observer.disturbance = before.disturbance.into();
        observer.is_blind = before.is_blind;
    }
    copy(world.last.virtual_input.as_mut_slice(), &before.asked);
    copy(world.last.vdot.as_mut_slice(), &before.vdot);
    copy(world.last.effort.as_mut_slice(), &before.sent);
}

/// Before anything is computed.
pub(in super::super) fn record_inputs(controller: &mut Controller, measurement: &Measurement) {
    let Some(record) = controller.recorder.as_mut().and_then(Recorder::current) else {
        return;
    };
    record.time = measurement.time;
    record.written = false;
    let state = &measurement.state;
    record.sizes = [state.q.len(), state.v.len(), measurement.wrenches.len()];
    write_state(state, &mut record.measured);
    for (out, wrench) in record.wrenches.iter_mut().zip(&measurement.wrenches) {
        *out = (*wrench).into();
    }
    let before = &mut record.before;
    remember_world(&controller.world, before);
    write_command(&controller.command, &mut before.command);
    before.has_begun = controller.first.is_over;
    before.level = controller.fallback.level;
    before.on_level_since = controller.fallback.on_level.since;
    before.on_level_ticks = controller.fallback.on_level.ticks;
    before.seen = controller.plausible.seen.last;
    before.unseen = controller.plausible.seen.gap;
    controller.fallback.remember(before);
    controller.solver.warm_start(&mut before.warm);
}

/// After the plug-ins have written their rows.
pub(in super::super) fn record_rows(controller: &mut Controller) {
    let Some(record) = controller.recorder.as_mut().and_then(Recorder::current) else {
        return;
    };
    record.written = true;
    for (entry, bound) in record.entries.iter_mut().zip(&controller.entries) {
        entry.live = bound.live;
        entry.alpha = bound.alpha;
        copy(&mut entry.weight, bound.weight.now());
        if !bound.live {
            continue;
        }
        let store = &bound.store;
        copy(&mut entry.vdot, &store.vdot);
        copy(&mut entry.effort, &store.effort);
        for (out, block) in entry.forces.iter_mut().zip(&store.forces) {
            copy(out, block);
        }
        copy(&mut entry.lower, &store.lower);
        copy(&mut entry.upper, &store.upper);
        copy(&mut entry.bound_lower, &store.bound_lower);
        copy(&mut entry.bound_upper, &store.bound_upper);
        copy(&mut entry.error, &store.error);
    }
}

/// After the tick.
pub(in super::super) fn record_outcome(controller: &mut Controller, changed: bool) {
    let Some(recorder) = &mut controller.recorder else {
        return;
    };
    if let Some(record) = recorder.current() {
        let outcome = &mut record.outcome;
        outcome.level = controller.report.level;
        outcome.status = controller.report.status;
        outcome.iterations = controller.report.iterations;
        write_command(&controller.command, &mut outcome.command);
        outcome.n = if controller.report.level.is_solved() {
            controller.qp.n()
        } else {
            0
        };
        copy(
            &mut outcome.x[..outcome.n],
            &controller.solution.x[..outcome.n],
        );
    }
    recorder.pending |= changed;
    recorder.advance();
}

impl Controller {
    /// Runs a recorded tick again, the oldest is 0: for a controller of
    /// [the dump's configuration](crate::ControllerConfig::from_dump). It remembers what was remembered before that
    /// tick, and has the recorded rows in place of those of its plug-ins.
    ///
    /// # Errors
    /// [`RequestError::Misfit`] if there is no such tick, or it is not of such a controller; nothing has changed then.
    pub fn rerun(&mut self, dump: &Dump, tick: usize) -> Result<(&Command, &Report), RequestError> {
        let Some(record) = dump.records.get(tick) else {
            return Err(RequestError::Misfit {
                what: "a tick beyond the last one recorded",
            });
        };
        if let Some(what) = misfit(self, record) {
            return Err(RequestError::Misfit { what });
        }
        restore(self, record);
        let measurement = measurement(record, &self.world.state);
        self.run(&measurement, Some(record));
        Ok((&self.command, &self.report))
    }
}

/// Remembers what was remembered before the recorded tick.
fn restore(controller: &mut Controller, record: &Record) {
    let before = &record.before;
    recall_world(&mut controller.world, before);
    read_command(&before.command, &mut controller.command);
    controller.first.is_over = before.has_begun;
    controller.fallback.level = before.level;
    controller.fallback.on_level.since = before.on_level_since;
    controller.fallback.on_level.ticks = before.on_level_ticks;
    controller.plausible.seen = Seen {
        last: before.seen,
        gap: before.unseen,
    };
    controller.fallback.recall(before);
    controller.solver.start_from(&before.warm);
}

/// Takes the recorded rows instead of asking the plug-ins.
pub(in super::super) fn recall_rows(controller: &mut Controller, entries: &[EntryRecord]) {
    for (entry, bound) in entries.iter().zip(&mut controller.entries) {
        bound.live = entry.live;
        bound.alpha = entry.alpha;
        bound.weight.hold(&entry.weight);
        let store = &mut bound.store;
        copy(&mut store.vdot, &entry.vdot);
        copy(&mut store.effort, &entry.effort);
        for (block, recorded) in store.forces.iter_mut().zip(&entry.forces) {
            copy(block, recorded);
        }
        copy(&mut store.lower, &entry.lower);
        copy(&mut store.upper, &entry.upper);
        copy(&mut store.bound_lower, &entry.bound_lower);
        copy(&mut store.bound_upper, &entry.bound_upper);
        copy(&mut store.error, &entry.error);
    }
}

/// What of a record does not have this controller's sizes, if anything.
fn misfit(controller: &Controller, record: &Record) -> Option<&'static str> {
    let blank = blank_record(controller);
    let sizes = |r: &Record| {
        let s = |s: &StateRecord| [s.q.len(), s.v.len()];
        let c = |c: &CommandRecord| {
            [
                c.effort.len(),
                c.rotor_speed.len(),
                c.joint_acceleration.len(),
                c.joint_velocity.len(),
            ]
        };
        let b = &r.before;
        (
            s(&r.measured),
            s(&b.state),
            c(&b.command),
            c(&r.outcome.command),
            [
                r.wrenches.len(),
                b.contacts.len(),
                b.asked.len(),
                b.vdot.len(),
                b.sent.len(),
                b.held.len(),
            ],
        )
    };
    if sizes(&blank) != sizes(record) {
        return Some("the robot's size");
    }
    let entry = |e: &EntryRecord| {
        let forces: Vec<usize> = e.forces.iter().map(Vec::len).collect();
        let rest = [
            &e.weight,
            &e.vdot,
            &e.effort,
            &e.lower,
            &e.upper,
            &e.bound_lower,
            &e.bound_upper,
            &e.error,
        ];
        (e.name.clone(), forces, rest.map(Vec::len))
    };
    let entries = |r: &Record| r.entries.iter().map(entry).collect::<Vec<_>>();
    (entries(&blank) != entries(record)).then_some("an entry")
}

impl Fallback {
    fn remember(&self, out: &mut Memory) {
        out.solved = self.without_solution.last;
        out.measured = self.without_state.last;
        out.stamp = self.clock.previous;
        out.steady = self.clock.steady;
        copy(&mut out.held, &self.law.memory);
        out.relaxed_warm.copy_from(&self.warm);
        out.proof.copy_from(&self.proof);
        out.since_proof = self.since_proof;
        for (out, needed) in out.needed.iter_mut().zip(&self.relaxation.needed) {
            *out = *needed;
        }
    }

    fn recall(&mut self, memory: &Memory) {
        let since = |last| Age {
            last,
            ..Age::default()
        };
        self.without_solution = since(memory.solved);
        self.without_state = since(memory.measured);
        self.clock = Clock {
            previous: memory.stamp,
            steady: memory.steady,
        };
        copy(&mut self.law.memory, &memory.held);
        self.warm.copy_from(&memory.relaxed_warm);
        self.proof.copy_from(&memory.proof);
        self.since_proof = memory.since_proof;
        for (needed, recorded) in self.relaxation.needed.iter_mut().zip(&memory.needed) {
            *needed = *recorded;
        }
    }
}

/// The measurement of a record.
fn measurement(record: &Record, like: &State) -> Measurement {
    let mut state = like.clone();
    read_state(&record.measured, &mut state);
    let mut wrenches: Vec<_> = record.wrenches.iter().map(|w| Vector6::from(*w)).collect();
    let [q, v, contacts] = record.sizes;
    state.q = state.q.resize_vertically(q, 0.0);
    state.v = state.v.resize_vertically(v, 0.0);
    wrenches.resize(contacts, Vector6::zeros());
    Measurement {
        time: record.time,
        state,
        wrenches,
    }
}

/// As many numbers as both have.
fn copy(to: &mut [f64], from: &[f64]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to = *from;
    }
}

fn blank_state(like: &State) -> StateRecord {
    let mut state = StateRecord {
        q: vec![0.0; like.q.len()],
        v: vec![0.0; like.v.len()],
        ..StateRecord::default()
    };
    write_state(like, &mut state);
    state
}

fn write_state(state: &State, out: &mut StateRecord) {
    out.position = state.p_WR.into();
    let r = &state.R_WR;
    out.orientation = [r.w, r.i, r.j, r.k];
    copy(&mut out.q, state.q.as_slice());
    copy(&mut out.v, state.v.as_slice());
}

fn read_state(record: &StateRecord, out: &mut State) {
    out.p_WR = record.position.into();
    let [w, x, y, z] = record.orientation;
    out.R_WR = UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z));
    copy(out.q.as_mut_slice(), &record.q);
    copy(out.v.as_mut_slice(), &record.v);
}

fn blank_command(like: &Command) -> CommandRecord {
    CommandRecord {
        effort: like.effort.clone(),
        rotor_speed: like.rotor_speed.clone(),
        joint_acceleration: like.joint_acceleration.clone(),
        joint_velocity: like.joint_velocity.clone(),
    }
}

fn write_command(command: &Command, out: &mut CommandRecord) {
    copy(&mut out.effort, &command.effort);
    copy(&mut out.rotor_speed, &command.rotor_speed);
    copy(&mut out.joint_acceleration, &command.joint_acceleration);
    copy(&mut out.joint_velocity, &command.joint_velocity);
}

fn read_command(record: &CommandRecord, out: &mut Command) {
    copy(&mut out.effort, &record.effort);
    copy(&mut out.rotor_speed, &record.rotor_speed);
    copy(&mut out.joint_acceleration, &record.joint_acceleration);
    copy(&mut out.joint_velocity, &record.joint_velocity);
}
