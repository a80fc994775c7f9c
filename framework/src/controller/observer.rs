//! Velocities, and the wrench that the model does not know, from the motion that the model predicts.
//!
//! # Notation
//! b the base's six velocities, j those of the joints, W world.
//!
//! # Mathematics
//! With the efforts u that were sent, the joints' accelerations of the last solution (none, if the last tick had none)
//! and the contact forces λ, the base rows of the equations of motion say how the base accelerates,
//!
//! `M_bb v̇_b = S_b u + J_bᵀ λ + ŵ − h_b − M_bj v̇_j`.
//!
//! Over the time Δ since the last measurement that predicts `v⁻ = v̂ + v̇ Δ`. The measured velocities v correct it by
//! the innovation `e = v − v⁻`, and what of it would come again and again is a wrench on the base:
//!
//! `v̂ = v⁻ + a e`, `ŵ ← ŵ + c (a/Δ) M_b e`, `a = 1 − exp(−2π f_v Δ)`, `c = 1 − exp(−2π f_w Δ)`,
//!
//! a Luenberger observer with poles near `2π f_v` and `2π f_w` where `f_w ≪ f_v`. For constant errors of the base's
//! acceleration ŵ is the observer of the generalised momentum of De Luca et al., "Collision detection and safe reaction
//! with the DLR-III lightweight manipulator arm", IROS 2006, for the base alone.
//!
//! While λ is not known, because a sensor fails, or because a tick without a solution has planned none, nothing is
//! predicted: v̂ is what is measured, and ŵ is forgotten, `ŵ ← ŵ exp(−Δ/2 s)`. A wrench of contacts from before would
//! have to be taken back by ŵ once the robot is off the surface, one of zero would let ŵ stand for the surface: and the
//! fallback law, which pushes against ŵ, would push against either. What is not confirmed becomes worse with time, too.

use nalgebra::{DVector, Matrix6, Vector3, Vector6};

use super::report::FallbackLevel;
use crate::{
    contact::{ContactBinding, ContactState},
    plugin::PreviousSolution,
    settings::{ContactForces, Observer as Settings},
};
use wbqp_dynamics::{Actuation, Data, elementary::low_pass};
use wbqp_robot_model::RobotModel;

/// A prediction that is farther from what is measured counts for nothing, m/s or rad/s: it comes from a wrench, or from
/// a mass matrix, of no robot, and would not be forgotten for long.
const CREDIBLE: f64 = 100.0;

/// Time in which a wrench that is not confirmed becomes 1/e, s.
const FORGETTING: f64 = 2.0;

/// How the last tick ended, and how long ago it was, s.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LastTick {
    pub(crate) level: FallbackLevel,
    pub(crate) elapsed: f64,
}

/// What is observed from tick to tick, sized once.
#[derive(Clone, Debug)]
pub(crate) struct Observer {
    settings: Settings,
    actuation: Actuation,
    /// Of the base: 6, or 0 if it is fixed.
    base: usize,
    /// S, row-major, nv × nu.
    inputs: Vec<f64>,
    /// By contact: the first at its frame where forces are measured, itself where they are planned.
    first: Vec<usize>,
    /// Predicted velocities, then the innovation.
    velocity: DVector<f64>,
    /// Whether the wrenches of the last measurement were not usable.
    pub(crate) is_blind: bool,
    /// ŵ, `[force; moment]` about the base's origin, world axes, N and N·m. Zero for a fixed base.
    pub(crate) disturbance: Vector6<f64>,
}

impl Observer {
    pub(crate) fn new(settings: Settings, robot: &RobotModel, bindings: &[ContactBinding]) -> Self {
        let (model, nu) = (&robot.model, robot.nu());
        let frames = || bindings.iter().map(|binding| &binding.spec.frame);
        let first = match settings.forces {
            ContactForces::Measured => frames()
                .map(|frame| {
                    frames()
                        .position(|other| other == frame)
                        .unwrap_or_default()
                })
                .collect(),
            ContactForces::Planned => (0..bindings.len()).collect(),
        };
        Self {
            first,
            settings,
            actuation: Actuation::new(model, &robot.actuators),
            base: model.joint_offset(),
            inputs: vec![0.0; model.nv() * nu],
            velocity: DVector::zeros(model.nv()),
            is_blind: false,
            disturbance: Vector6::zeros(),
        }
    }

    /// Whether the contact forces of the last tick, which ended on that level, are known.
    pub(crate) fn knows_forces(&self, level: FallbackLevel) -> bool {
        match self.settings.forces {
            ContactForces::Measured => !self.is_blind,
            ContactForces::Planned => level.is_solved(),
        }
    }

    /// Whether a contact's force counts: what is measured at a frame counts once, however many contacts are there, that
    /// of the first of them which is told of it.
    fn counts(&self, contact: usize, contacts: &[ContactState]) -> bool {
        let first = self.first[contact];
        !(first..contact)
            .any(|other| self.first[other] == first && contacts[other].measured != Vector6::zeros())
    }

    /// Forgets what it cannot confirm, `elapsed` s after the last tick.
    pub(crate) fn forget(&mut self, elapsed: f64) {
        self.disturbance *= (-elapsed / FORGETTING).exp();
    }

    /// Predicts the velocities of this tick from everything that is known of the last one.
    pub(crate) fn predict(
        &mut self,
        v: &DVector<f64>,
        data: &Data,
        contacts: &[ContactState],
        last: &PreviousSolution,
        LastTick { level, elapsed }: LastTick,
    ) {
        let planned = |i: usize| if level.is_solved() { last.vdot[i] } else { 0.0 };
        self.velocity.copy_from(v);
        for i in self.base..v.len() {
            self.velocity[i] += planned(i) * elapsed;
        }
        if self.base == 0 {
            return;
        }
        let mass = data.mass_matrix();
        let nu = last.effort.len();
        self.inputs.fill(0.0);
        self.actuation.write(data, &mut self.inputs, nu);
        let mut push = self.disturbance;
        for (i, push) in push.iter_mut().enumerate() {
            *push -= data.bias()[i];
            for (s, u) in self.inputs[i * nu..(i + 1) * nu].iter().zip(&last.effort) {
                *push += s * u;
            }
            for j in self.base..v.len() {
                *push -= mass[(i, j)] * planned(j);
            }
        }
        for (k, contact) in contacts.iter().enumerate() {
            if !self.counts(k, contacts) {
                continue;
            }
            let force = match self.settings.forces {
                ContactForces::Measured => contact.measured,
                ContactForces::Planned => contact.solution + contact.free_force,
            };
            for (i, push) in push.iter_mut().enumerate() {
                *push += contact.J.column(i).dot(&force);
            }
        }
        let own: Matrix6<f64> = mass.fixed_view::<6, 6>(0, 0).into();
        if let Some(factor) = own.cholesky() {
            let acceleration = factor.solve(&push);
            for (v, a) in self.velocity.iter_mut().zip(&acceleration) {
                *v += a * elapsed;
            }
        }
    }

    /// Corrects the prediction by the measured velocities, and replaces them by the outcome.
    pub(crate) fn correct(&mut self, v: &mut DVector<f64>, data: &Data, elapsed: f64) {
        let share = low_pass(self.settings.velocity, elapsed);
        for (predicted, measured) in self.velocity.iter_mut().zip(v.iter_mut()) {
            let innovation = *measured - *predicted;
            let is_credible = innovation.abs() <= CREDIBLE;
            let innovation = if is_credible { innovation } else { 0.0 };
            *measured -= (1.0 - share) * innovation;
            *predicted = innovation;
        }
        if self.base == 0 || self.settings.wrench == 0.0 {
            return;
        }
        let mass = data.mass_matrix();
        let gain = low_pass(self.settings.wrench, elapsed) * share / elapsed;
        for i in 0..self.base {
            let more = gain * mass.column(i).dot(&self.velocity);
            if more.is_finite() {
                self.disturbance[i] += more;
            }
        }
        self.limit();
    }

    fn limit(&mut self) {
        let w = &self.disturbance;
        let force = Vector3::new(w[0], w[1], w[2]).cap_magnitude(self.settings.max_force);
        let moment = Vector3::new(w[3], w[4], w[5]).cap_magnitude(self.settings.max_moment);
        self.disturbance = Vector6::new(force.x, force.y, force.z, moment.x, moment.y, moment.z);
    }
}
