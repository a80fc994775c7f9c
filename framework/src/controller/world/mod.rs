//! The measured world of one tick: state, dynamics, frames and contacts, computed once.
//!
//! # Notation
//! W world, R base.
#![allow(non_snake_case)]

mod look;
mod setup;

use std::sync::Arc;

use nalgebra::{UnitQuaternion, Vector6};

use super::{
    measurement::Measurement,
    observer::{LastTick, Observer},
    report::FallbackLevel,
};
use crate::{
    contact::{ContactBinding, ContactState},
    plugin::{EntryState, PreviousSolution, Tick},
    problem::{BoundEntry, DynamicsTerms, Problem},
};
use wbqp_dynamics::{
    Data, FrameKinematics,
    model::{FrameId, Model},
    state::State,
};

/// State, dynamics, requested frames and contacts.
#[derive(Clone, Debug)]
pub(crate) struct World {
    pub(crate) model: Arc<Model>,
    pub(crate) period: f64,
    /// Time that this tick stands for, s, see [`elapsed`](super::fallback::elapsed).
    pub(crate) elapsed: f64,
    /// Whether what happened since the last usable state was seen.
    pub(crate) is_continuous: bool,
    /// Time for which `slew` counts in this tick, s.
    pub(crate) slew_time: f64,
    /// Time since the first tick, s.
    pub(crate) time: f64,
    /// The measurement's time at the first tick.
    pub(crate) origin: Option<f64>,
    pub(crate) state: State,
    pub(crate) data: Data,
    pub(crate) frame_ids: Vec<FrameId>,
    pub(crate) frames: Vec<FrameKinematics>,
    pub(crate) contacts: Vec<ContactState>,
    pub(crate) last: PreviousSolution,
    pub(crate) bindings: Vec<ContactBinding>,
    pub(crate) observer: Option<Observer>,
}

impl World {
    fn update_bodies(&mut self) {
        self.data.update(&self.model, &self.state);
        for (frame, id) in self.frames.iter_mut().zip(&self.frame_ids) {
            frame.update(&self.model, &self.data, *id);
        }
    }

    /// Takes a measurement over and computes everything that depends on it.
    pub(crate) fn measure(&mut self, m: &Measurement, level: FallbackLevel) {
        self.take_state(m, level);
        if let Some(observer) = &mut self.observer {
            observer.is_blind = false;
        }
        for ((binding, contact), wrench) in self
            .bindings
            .iter_mut()
            .zip(&mut self.contacts)
            .zip(&m.wrenches)
        {
            binding.update(
                self.time,
                self.elapsed,
                &self.model,
                &self.data,
                wrench,
                contact,
            );
        }
    }

    /// `level` is that of the last tick.
    fn take_state(&mut self, m: &Measurement, level: FallbackLevel) {
        // After a gap, as in the first tick, velocities are the measured ones: what they would have become is unknown.
        let can_predict = self.origin.is_some() && self.is_continuous;
        self.time = m.time - *self.origin.get_or_insert(m.time);
        let observer = self.observer.as_mut().filter(|_| can_predict);
        match observer {
            Some(observer) if observer.knows_forces(level) => {
                let elapsed = self.elapsed;
                let (data, contacts) = (&self.data, &self.contacts);
                let last = LastTick { level, elapsed };
                observer.predict(&self.state.v, data, contacts, &self.last, last);
                self.state.copy_from(&m.state);
                observer.correct(&mut self.state.v, data, elapsed);
            }
            Some(observer) => {
                observer.forget(self.elapsed);
                self.state.copy_from(&m.state);
            }
            None => self.state.copy_from(&m.state),
        }
        // Sensors deliver quaternions that are almost of unit length: everything after needs exactly that.
        self.state.R_WR = UnitQuaternion::new_normalize(*m.state.R_WR.quaternion());
        self.update_bodies();
    }

    /// Takes down what the next tick needs of a solution that the problem has recovered.
    pub(crate) fn remember(&mut self, problem: &mut Problem, tasks: &[BoundEntry]) {
        self.last.vdot.copy_from_slice(&problem.solved.vdot);
        let asked = &mut problem.asked;
        asked.collect(tasks, self.last.virtual_input.as_mut_slice());
        for (index, contact) in self.contacts.iter_mut().enumerate() {
            contact.solution.fill(0.0);
            contact.set_point.fill(0.0);
            let force = problem.force(index);
            for (&direction, f) in contact.kind.constrained().iter().zip(force) {
                contact.solution[direction] = *f;
            }
        }
        for task in tasks {
            if let (true, Some(force)) = (task.live, task.store.force_report)
                && let Some(contact) = self.contacts.get_mut(force.contact.index())
            {
                contact.set_point = force.reference;
            }
        }
    }

    /// The unknown wrench on the base; zero without an observer.
    pub(crate) fn disturbance(&self) -> Vector6<f64> {
        let observer = self.observer.as_ref();
        observer.map_or_else(Vector6::zeros, |observer| observer.disturbance)
    }

    /// The terms of the dynamics, borrowed for the problem.
    pub(crate) fn terms(&self) -> DynamicsTerms<'_> {
        DynamicsTerms {
            data: &self.data,
            frames: &self.frames,
            contacts: &self.contacts,
            disturbance: self.disturbance(),
        }
    }

    /// What a plug-in sees.
    pub(crate) fn tick(&self, entry: EntryState) -> Tick<'_> {
        Tick {
            time: self.time,
            period: self.period,
            elapsed: self.elapsed,
            slew_time: self.slew_time,
            model: &self.model,
            state: &self.state,
            dynamics: &self.data,
            last_vdot: &self.last.vdot,
            last_virtual_input: &self.last.virtual_input,
            last_effort: &self.last.effort,
            disturbance: self.disturbance(),
            alpha: entry.alpha,
            since: entry.since,
            frames: &self.frames,
            contacts: &self.contacts,
            references: &[],
        }
    }
}
