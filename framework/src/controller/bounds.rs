//! The bounds of what a measurement may be: the configuration's, or from the robot.
//!
//! # Where the bounds come from
//! Joints may be `c` times as far from zero as their range goes, with `c` = 10 for "ten times what is possible", and
//! the base [`FARTHEST`] from the world's origin. Speeds are, per revolute joint `c max(q̇_max, 50 rad/s)`, per
//! prismatic joint `c max(q̇_max, 5 m/s)`; a limit above [`FASTEST`] says nothing, as no limit, and counts as 100 rad/s
//! or 10 m/s. The base turns as fast as the fastest revolute joint, and moves with `c max(10 m/s, q̇_max r)`, with the
//! largest limit and the reach r: how far from the base's origin anything can be. Accelerations go to the largest speed
//! within [`REACTION`]. Forces go to `c (m g + Σ thrust + Σ torque / r)`, or to `c` times the contact's `force_max`
//! where that is more, and moments to the force times r, at least 0.1 m.

use std::f64::consts::PI;

use super::Measurement;
use crate::{contact::ContactSpec, fault::Fault, settings::MeasurementLimits};
use wbqp_dynamics::{
    actuator::ActuatorKind,
    model::{Joint, JointKind, Model},
};
use wbqp_robot_model::RobotModel;

/// How many times what is possible.
const MARGIN: f64 = 10.0;
/// A limit on a joint's speed above this says nothing, rad/s or m/s.
const FASTEST: f64 = 1000.0;
/// Distance of a base from the world's origin that no map has, m.
const FARTHEST: f64 = 1e8;
/// Position of a joint without range: as many turns as it may have made, rad or m.
const ENDLESS: f64 = 1e6;
/// Time within which anything may reach its largest speed, s.
const REACTION: f64 = 0.001;
/// Time without a measurement that is taken for an outage and not for a wrong stamp, s.
const GAP: f64 = 10.0;
/// Gravity where there is none, m/s².
const GRAVITY: f64 = 9.81;

/// Bounds for a robot, and when it was seen. In storage made once.
#[derive(Clone, Debug)]
pub(super) struct Plausible {
    /// Of the base, from the world's origin.
    pub(super) position: f64,
    /// Of the base: linear and angular.
    pub(super) velocity: [f64; 2],
    pub(super) acceleration: [f64; 2],
    /// Of its position and orientation, per period.
    pub(super) jump: [f64; 2],
    pub(super) joints: Vec<JointBounds>,
    /// Force and moment of each contact.
    pub(super) wrenches: Vec<[f64; 2]>,
    /// Of the time between two measurements, s.
    pub(super) gap: f64,
    pub(super) period: f64,
    pub(super) seen: Seen,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct JointBounds {
    pub(super) position: f64,
    pub(super) velocity: f64,
    pub(super) acceleration: f64,
    pub(super) jump: f64,
}

/// When the robot was seen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Seen {
    /// Stamp of the last measurement whose speeds were plausible; nothing if there is none to compare with.
    pub(super) last: Option<f64>,
    /// The longest time between two of them since the last usable one, s.
    pub(super) gap: f64,
}

impl Plausible {
    pub(super) fn new(
        limits: &MeasurementLimits,
        robot: &RobotModel,
        contacts: &[ContactSpec],
        period: f64,
    ) -> Self {
        let model = &robot.model;
        let joint = |joint: &Joint| {
            let least = match joint.kind {
                JointKind::Revolute => 50.0,
                JointKind::Prismatic => 5.0,
            };
            let own = MARGIN * f64::max(speed_of(joint), least);
            let velocity = limits.max_joint_velocity.unwrap_or(own);
            JointBounds {
                position: limits.max_joint_position.unwrap_or(farthest(joint)),
                velocity,
                acceleration: limits.max_joint_acceleration.unwrap_or(velocity / REACTION),
                jump: limits.max_joint_jump.unwrap_or(velocity * period),
            }
        };
        let joints: Vec<JointBounds> = model.joints().iter().map(joint).collect();
        let turning = || {
            let joints = model.joints().iter().zip(&joints);
            joints.filter(|(joint, _)| joint.kind == JointKind::Revolute)
        };
        let bounds = turning().map(|(_, bounds)| bounds.velocity);
        let fastest = bounds.filter(|v| v.is_finite()).fold(500.0, f64::max);
        let limit = turning().map(|(joint, _)| speed_of(joint));
        let limit = limit.fold(0.0, f64::max);
        let reach = reach(model).max(0.1);
        let velocity = either(
            [limits.max_linear_velocity, limits.max_angular_velocity],
            [MARGIN * f64::max(10.0, limit * reach), fastest],
        );
        let power = MARGIN * strength(robot, reach);
        let wrench = |contact: &ContactSpec| {
            let own = if contact.force_max.is_finite() {
                power.max(MARGIN * contact.force_max)
            } else {
                power
            };
            let force = limits.max_force.unwrap_or(own);
            [force, limits.max_moment.unwrap_or(force * reach)]
        };
        Self {
            position: limits.max_position.unwrap_or(FARTHEST),
            velocity,
            acceleration: either(
                [
                    limits.max_linear_acceleration,
                    limits.max_angular_acceleration,
                ],
                velocity.map(|v| v / REACTION),
            ),
            jump: either(
                [limits.max_position_jump, limits.max_rotation_jump],
                velocity.map(|v| v * period),
            ),
            joints,
            wrenches: contacts.iter().map(wrench).collect(),
            gap: limits.max_gap.unwrap_or(GAP),
            period,
            seen: Seen::default(),
        }
    }

    /// The bounds as a table that would set them; of joints and contacts the largest.
    pub(super) fn limits(&self) -> MeasurementLimits {
        let joint = |of: fn(&JointBounds) -> f64| self.joints.iter().map(of).reduce(f64::max);
        let wrench = |i: usize| self.wrenches.iter().map(|w| w[i]).reduce(f64::max);
        MeasurementLimits {
            max_gap: Some(self.gap),
            max_position: Some(self.position),
            max_joint_position: joint(|j| j.position),
            max_linear_velocity: Some(self.velocity[0]),
            max_angular_velocity: Some(self.velocity[1]),
            max_joint_velocity: joint(|j| j.velocity),
            max_linear_acceleration: Some(self.acceleration[0]),
            max_angular_acceleration: Some(self.acceleration[1]),
            max_joint_acceleration: joint(|j| j.acceleration),
            max_position_jump: Some(self.jump[0]),
            max_rotation_jump: Some(self.jump[1]),
            max_joint_jump: joint(|j| j.jump),
            max_force: wrench(0),
            max_moment: wrench(1),
        }
    }

    /// The next measurement is compared with a state that was seen at this time.
    pub(super) fn restart(&mut self, stamp: f64) {
        self.seen = Seen {
            last: Some(stamp),
            gap: 0.0,
        };
    }

    /// What of positions, speeds and forces is not plausible.
    pub(super) fn in_itself(&self, measurement: &Measurement) -> Option<Fault> {
        self.places(&measurement.state)
            .or_else(|| self.speeds(measurement))
            .or_else(|| self.forces(measurement))
    }
}

/// What is configured, or what follows from the robot.
fn either(configured: [Option<f64>; 2], own: [f64; 2]) -> [f64; 2] {
    std::array::from_fn(|i| configured[i].unwrap_or(own[i]))
}

/// How far from zero a joint may be, rad or m.
fn farthest(joint: &Joint) -> f64 {
    let ends = joint.limits.lower.abs().max(joint.limits.upper.abs());
    let least = match joint.kind {
        JointKind::Revolute => PI,
        JointKind::Prismatic => 0.1,
    };
    if ends.is_finite() {
        MARGIN * ends.max(least)
    } else {
        ENDLESS
    }
}

/// A joint's limit on its speed, as far as it says something.
fn speed_of(joint: &Joint) -> f64 {
    let limit = joint.limits.velocity;
    match joint.kind {
        _ if limit > 0.0 && limit <= FASTEST => limit,
        JointKind::Revolute => 100.0,
        JointKind::Prismatic => 10.0,
    }
}

/// How far from the base's origin anything can be, m.
fn reach(model: &Model) -> f64 {
    let mut of_bodies = vec![0.0_f64; model.bodies().len()];
    for i in 1..of_bodies.len() {
        let Some(id) = model.body_id(i) else { continue };
        let parent = model.bodies()[i].parent.index();
        // A body without a joint of its own follows another: as far as its parent, and its own frames.
        let arm = model.joint_of(id).map_or(0.0, |joint| {
            let joint = &model.joints()[joint.index()];
            let stroke = match joint.kind {
                JointKind::Prismatic => joint.limits.upper.abs().max(joint.limits.lower.abs()),
                JointKind::Revolute => 0.0,
            };
            let stroke = if stroke.is_finite() { stroke } else { 0.0 };
            joint.X_PJ.translation.vector.norm() + stroke
        });
        of_bodies[i] = of_bodies.get(parent).copied().unwrap_or_default() + arm;
    }
    let frames = model.frames().iter();
    let of_frames = frames.map(|frame| {
        let body = of_bodies.get(frame.body.index());
        body.copied().unwrap_or_default() + frame.X_BF.translation.vector.norm()
    });
    of_frames.fold(0.0, f64::max)
}

/// What weight and actuators amount to, N.
fn strength(robot: &RobotModel, reach: f64) -> f64 {
    let gravity = robot.model.gravity().norm();
    let gravity = if gravity > 0.0 { gravity } else { GRAVITY };
    let largest = |actuator: &wbqp_dynamics::actuator::Actuator| {
        let effort = actuator.lower.abs().max(actuator.upper.abs());
        let effort = if effort.is_finite() { effort } else { 0.0 };
        match &actuator.kind {
            ActuatorKind::Rotor(_) => effort,
            ActuatorKind::Joint(motor) => match robot.model.joints()[motor.joint.index()].kind {
                JointKind::Revolute => effort / reach,
                JointKind::Prismatic => effort,
            },
        }
    };
    let actuators: f64 = robot.actuators.iter().map(largest).sum();
    (robot.model.mass() * gravity + actuators).max(1.0)
}
