//! The right-hand side `ẋ` and one step of the integrator.

use wbqp::dynamics::{Data, JointDrive, Wrenches, forward_dynamics, forward_dynamics_of_servos};
use wbqp::model::Model;
use wbqp::nalgebra::DVector;

use super::{Plant, has_diverged, layout::Layout};

/// Classical Runge–Kutta: fraction of the step at which the second to fourth stages are evaluated.
const STAGES: [f64; 3] = [0.5, 0.5, 1.0];
/// Weights of the first to the third stage, times 6; the fourth is 1.
const WEIGHTS: [f64; 3] = [1.0, 2.0, 2.0];

/// A way to solve the equations of motion: [`forward_dynamics`] or one like it.
type Dynamics =
    fn(&Model, &mut Data, &[JointDrive], &Wrenches, &mut DVector<f64>, &mut DVector<f64>);

impl Plant {
    /// One step of `h` s that ends at `end`. Needs `rates` at `x`, and leaves them so.
    pub(super) fn step(&mut self, h: f64, end: f64) {
        let mut work = std::mem::replace(&mut self.work, super::Work::empty());
        work.k.copy_from_slice(&self.rates);
        work.sum.fill(0.0);
        for (fraction, weight) in STAGES.into_iter().zip(WEIGHTS) {
            for i in 0..self.x.len() {
                work.sum[i] += weight * work.k[i];
                work.x[i] = self.x[i] + fraction * h * work.k[i];
            }
            self.place(&work.x);
            self.evaluate_contacts(&work.x);
            self.evaluate_rates(&work.x, &mut work.k);
        }
        for i in 0..self.x.len() {
            self.x[i] += h / 6.0 * (work.sum[i] + work.k[i]);
        }
        self.work = work;
        self.time = end;
        Layout::normalise(&mut self.x);
        self.arrive(true);
    }

    /// Makes everything that is derived from `x`, the command and the time what it should be.
    pub(super) fn refresh(&mut self) {
        self.arrive(false);
    }

    fn arrive(&mut self, settle: bool) {
        let mut x = std::mem::take(&mut self.x);
        let mut rates = std::mem::take(&mut self.rates);
        self.place(&x);
        self.evaluate_contacts(&x);
        if settle {
            self.settle_contacts(&mut x);
        }
        self.evaluate_rates(&x, &mut rates);
        self.x = x;
        self.rates = rates;
        self.note_divergence();
    }

    pub(super) fn note_divergence(&mut self) {
        let finite = within(&self.x) && within(&self.rates[..3]);
        self.diverged |= !finite || has_diverged(&self.state);
    }

    /// Kinematics at `x`.
    pub(super) fn place(&mut self, x: &[f64]) {
        self.layout.decode(x, &mut self.state);
        self.data.update_kinematics(&self.robot.model, &self.state);
    }

    /// Contact forces at the present kinematics.
    fn evaluate_contacts(&mut self, x: &[f64]) {
        for (i, contact) in self.contacts.iter_mut().enumerate() {
            let anchor = self.layout.anchor(x, i);
            contact.evaluate(&self.robot.model, &self.data, &anchor);
        }
    }

    /// Opens and closes contacts and puts anchors where they belong.
    fn settle_contacts(&mut self, x: &mut [f64]) {
        for (i, contact) in self.contacts.iter_mut().enumerate() {
            let mut anchor = self.layout.anchor(x, i);
            let again = contact.settle(&mut anchor);
            self.layout.set_anchor(x, i, &anchor);
            if again {
                contact.evaluate(&self.robot.model, &self.data, &anchor);
            }
        }
    }

    /// `ẋ` at the present kinematics and contact forces. The disturbances are those of the step's start.
    fn evaluate_rates(&mut self, x: &[f64], dx: &mut [f64]) {
        let model = &self.robot.model;
        self.wrenches.clear();
        let thrusts = self.layout.thrusts(x);
        for (rotor, &thrust) in self.rotors.iter().zip(thrusts) {
            rotor.push(model, &self.data, thrust, &mut self.wrenches);
        }
        self.push_environment();
        self.fill_rates(x, dx, forward_dynamics);
        for (i, contact) in self.contacts.iter().enumerate() {
            self.layout.set_anchor(dx, i, &contact.anchor_rate());
        }
    }

    /// The same with the wrenches of all rotors of a body in one sum, and anchors that stay where contacts are open:
    /// what [`Contact::evaluate_held`](super::contact::Contact::evaluate_held) goes with.
    pub(super) fn evaluate_rates_quickly(&mut self, x: &[f64], dx: &mut [f64]) {
        self.wrenches.clear();
        let thrusts = self.layout.thrusts(x);
        for group in &self.groups {
            group.push(&self.data, thrusts, &mut self.wrenches);
        }
        self.push_environment();
        self.fill_rates(x, dx, forward_dynamics_of_servos);
        for (i, contact) in self.contacts.iter().enumerate() {
            self.layout.set_anchor(dx, i, &contact.anchor_rate_held());
        }
    }

    /// Adds the wrenches of contacts, disturbances and hands.
    fn push_environment(&mut self) {
        let model = &self.robot.model;
        for contact in &self.contacts {
            let truth = &contact.truth;
            if truth.in_contact {
                self.wrenches
                    .add_force(&self.data, contact.body, &truth.p_WC, &truth.force_W);
            }
        }
        for disturbance in &self.disturbances {
            // `time` is the start of the step until the step is done.
            let share = disturbance.share(self.time, self.equal_step);
            if share > 0.0 {
                let at = wbqp::dynamics::frame_motion(model, &self.data, disturbance.frame);
                self.wrenches.add_wrench(
                    &self.data,
                    disturbance.body,
                    &at.p_WF,
                    &(disturbance.force * share),
                    &(disturbance.moment * share),
                );
            }
        }
        if let Some(pull) = &self.pull {
            let at = wbqp::dynamics::frame_motion(model, &self.data, pull.frame);
            let p_WP = at.p_WF + at.R_WF * pull.p_FP.coords;
            self.wrenches
                .add_force(&self.data, pull.body, &p_WP, &pull.force);
        }
    }

    /// `ẋ` under all wrenches but for the anchors.
    fn fill_rates(&mut self, x: &[f64], dx: &mut [f64], dynamics: Dynamics) {
        self.solve(dynamics);
        self.layout.rigid_rates(x, self.vdot.as_slice(), dx);
        for ((rate, rotor), &thrust) in self
            .layout
            .thrusts_mut(dx)
            .iter_mut()
            .zip(&self.rotors)
            .zip(self.layout.thrusts(x))
        {
            *rate = rotor.rate(thrust, self.command.values()[rotor.actuator]);
        }
    }

    /// Accelerations and efforts. A servo that would need more than its stall effort is driven by that effort
    /// instead and everything is solved again, at most once per joint.
    fn solve(&mut self, dynamics: Dynamics) {
        let offset = self.robot.model.joint_offset();
        let command = self.command.values();
        for (i, joint) in self.joints.iter().enumerate() {
            let (q, qdot) = (self.state.q[i], self.state.v[offset + i]);
            self.drives[i] = joint.drive(command, q, qdot);
            self.motor_effort[i] = joint.motor_effort(command);
            self.stalled[i] = false;
        }
        for _ in 0..=self.joints.len() {
            dynamics(
                &self.robot.model,
                &mut self.data,
                &self.drives,
                &self.wrenches,
                &mut self.vdot,
                &mut self.effort,
            );
            let mut again = false;
            for (i, joint) in self.joints.iter().enumerate() {
                if !joint.is_servo() || self.stalled[i] {
                    continue;
                }
                self.motor_effort[i] = self.effort[i];
                let (q, qdot) = (self.state.q[i], self.state.v[offset + i]);
                if let Some((drive, most)) = joint.stalled(self.effort[i], q, qdot) {
                    self.drives[i] = drive;
                    self.motor_effort[i] = most;
                    self.stalled[i] = true;
                    again = true;
                }
            }
            if !again {
                break;
            }
        }
    }
}

fn within(x: &[f64]) -> bool {
    x.iter().all(|x| x.is_finite())
}
