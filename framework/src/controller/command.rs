//! What goes to the actuators.
//!
//! # Mathematics
//! A servoed joint receives a velocity reference that integrates the commanded acceleration and leaks to the
//! measured velocity with time constant `τ_ℓ`:
//! `v_ref⁺ = sat(v_ref + T v̇_A* − (T/τ_ℓ)(v_ref − v_meas))`, where T is the time that the tick stands for
//! ([`Tick::elapsed`](crate::plugin::Tick::elapsed)). The leak is the anti-windup; drift of the position is
//! removed by the posture task.

use crate::robot::RobotModel;
use wbqp_dynamics::{actuator::ActuatorKind, model::Model, state::State};

/// The command of a tick, in storage made once.
#[derive(Clone, Debug, PartialEq)]
pub struct Command {
    /// Effort of every actuator in the order of `u`: thrust N, torque N·m or force N.
    pub effort: Vec<f64>,
    /// Speed of every actuator that is a rotor, rad/s; 0 for joints. Same order as `effort`.
    pub rotor_speed: Vec<f64>,
    /// Acceleration of every joint, rad/s² or m/s², in the model's order.
    pub joint_acceleration: Vec<f64>,
    /// Velocity reference of every joint, rad/s or m/s, in the model's order.
    pub joint_velocity: Vec<f64>,
}

impl Command {
    pub(crate) fn new(robot: &RobotModel) -> Self {
        let joints = robot.model.joints().len();
        Self {
            effort: vec![0.0; robot.nu()],
            rotor_speed: vec![0.0; robot.nu()],
            joint_acceleration: vec![0.0; joints],
            joint_velocity: vec![0.0; joints],
        }
    }

    /// Takes efforts over, clipped to the actuators' limits, and converts thrusts to rotor speeds: for the command
    /// before the first tick. Those of ticks go through the [`Gate`](super::gate::Gate).
    pub(crate) fn hover(&mut self, robot: &RobotModel, effort: &[f64]) {
        for (i, actuator) in robot.actuators.iter().enumerate() {
            let u = effort[i].max(actuator.lower).min(actuator.upper);
            self.effort[i] = u;
            if let ActuatorKind::Rotor(rotor) = &actuator.kind {
                self.rotor_speed[i] = rotor.speed(u);
            }
        }
    }

    /// Takes over another command of the same robot.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        self.effort.copy_from_slice(&other.effort);
        self.rotor_speed.copy_from_slice(&other.rotor_speed);
        self.joint_acceleration
            .copy_from_slice(&other.joint_acceleration);
        self.joint_velocity.copy_from_slice(&other.joint_velocity);
    }

    /// Takes accelerations over and integrates the velocity references over the time that the tick stands for.
    pub(crate) fn integrate(
        &mut self,
        model: &Model,
        state: &State,
        vdot: &[f64],
        seconds: f64,
        leak: f64,
    ) {
        let offset = model.joint_offset();
        let share = leaked(seconds, leak);
        for (i, joint) in model.joints().iter().enumerate() {
            let acceleration = vdot[offset + i];
            let measured = state.v[offset + i];
            let reference = self.joint_velocity[i];
            let limit = joint.limits.velocity;
            let next = reference + seconds * acceleration - share * (reference - measured);
            self.joint_acceleration[i] = acceleration;
            self.joint_velocity[i] = next.clamp(-limit, limit);
        }
    }

    /// Integrates the velocity references without acceleration: they leak to the measured velocities.
    pub(crate) fn coast(&mut self, model: &Model, state: &State, seconds: f64, leak: f64) {
        let offset = model.joint_offset();
        let share = leaked(seconds, leak);
        for (i, joint) in model.joints().iter().enumerate() {
            let (reference, measured) = (self.joint_velocity[i], state.v[offset + i]);
            let limit = joint.limits.velocity;
            let next = reference - share * (reference - measured);
            self.joint_acceleration[i] = 0.0;
            self.joint_velocity[i] = next.clamp(-limit, limit);
        }
    }

    /// The joints are to stand still.
    pub(crate) fn stop_joints(&mut self) {
        self.joint_acceleration.fill(0.0);
        self.joint_velocity.fill(0.0);
    }

    /// Starts the velocity references at the measured velocities.
    pub(crate) fn engage(&mut self, model: &Model, state: &State) {
        let offset = model.joint_offset();
        for (i, joint) in model.joints().iter().enumerate() {
            let limit = joint.limits.velocity;
            self.joint_velocity[i] = state.v[offset + i].clamp(-limit, limit);
        }
    }
}

/// Share of the distance from the measured velocity that leaks away in a time; never more than all of it.
fn leaked(seconds: f64, leak: f64) -> f64 {
    (seconds / leak).min(1.0)
}
