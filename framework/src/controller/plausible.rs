//! Whether a measurement can be true of the robot.
//!
//! # What is compared
//! Speeds and forces with a bound each. Positions and velocities, besides, with those of the last usable measurement.
//! Positions may have changed by a bound per period, for as many periods as the robot was not seen, and while it was
//! seen by twice what its speed explains. Velocities may have changed by a bound for all the time in between.
//!
//! A robot is seen by every measurement whose speeds and forces are plausible, also by one that has jumped. So after an
//! outage the robot may be as far away as it could have come in that time, and a blow too hard to be believed is over
//! when it is over; but where measurements go on regularly, and lie elsewhere than their own speeds could have brought
//! the robot, waiting does not make the jump plausible: it has to be said that it is meant
//! ([`Controller::reset`](super::Controller::reset)), or to end.
//!
//! # Where the bounds come from
//! With `c` = 10 for "ten times what is possible", per revolute joint `c max(q̇_max, 50 rad/s)`, per prismatic joint
//! `c max(q̇_max, 5 m/s)`; a limit above [`FASTEST`] says nothing, as no limit, and counts as 100 rad/s or 10 m/s. The
//! base turns as fast as the fastest revolute joint, and moves with `c max(10 m/s, q̇_max r)`, with the largest limit
//! and the reach r: how far from the base's origin anything can be. Accelerations go to the largest speed within
//! [`REACTION`]. Forces go to `c (m g + Σ thrust + Σ torque / r)` and moments to that times r, at least 0.1 m. A
//! contact whose `force_max` is larger is taken at its word.

use nalgebra::UnitQuaternion;

use super::Measurement;
use crate::{
    contact::{ContactId, ContactSpec},
    fault::{Fault, Implausible, Measured},
    robot::RobotModel,
    settings::MeasurementLimits,
};
use wbqp_dynamics::{
    actuator::ActuatorKind,
    model::{Joint, JointId, JointKind, Model},
    state::State,
};

/// How many times what is possible.
const MARGIN: f64 = 10.0;
/// A limit on a joint's speed above this says nothing, rad/s or m/s.
const FASTEST: f64 = 1000.0;
/// Time within which anything may reach its largest speed, s.
const REACTION: f64 = 0.001;
/// Gravity where there is none, m/s².
const GRAVITY: f64 = 9.81;

/// Bounds for a robot, and when it was seen. In storage made once.
#[derive(Clone, Debug)]
pub(super) struct Plausible {
    linear_velocity: f64,
    angular_velocity: f64,
    linear_acceleration: f64,
    angular_acceleration: f64,
    /// Per period.
    position_jump: f64,
    rotation_jump: f64,
    joints: Vec<JointBounds>,
    /// Force and moment of each contact.
    wrenches: Vec<[f64; 2]>,
    period: f64,
    pub(super) seen: Seen,
}

#[derive(Clone, Copy, Debug)]
struct JointBounds {
    velocity: f64,
    acceleration: f64,
    jump: f64,
}

/// When the robot was seen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Seen {
    /// Stamp of the last measurement whose speeds and forces were plausible; nothing if there is none to compare with.
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
        let angular_velocity = limits.max_angular_velocity.unwrap_or(fastest);
        let own = MARGIN * f64::max(10.0, limit * reach);
        let linear_velocity = limits.max_linear_velocity.unwrap_or(own);
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
            linear_velocity,
            angular_velocity,
            linear_acceleration: limits
                .max_linear_acceleration
                .unwrap_or(linear_velocity / REACTION),
            angular_acceleration: limits
                .max_angular_acceleration
                .unwrap_or(angular_velocity / REACTION),
            position_jump: limits.max_position_jump.unwrap_or(linear_velocity * period),
            rotation_jump: limits
                .max_rotation_jump
                .unwrap_or(angular_velocity * period),
            joints,
            wrenches: contacts.iter().map(wrench).collect(),
            period,
            seen: Seen::default(),
        }
    }

    /// The bounds as a table that would set them; of joints and contacts the largest.
    pub(super) fn limits(&self) -> MeasurementLimits {
        let joint = |of: fn(&JointBounds) -> f64| self.joints.iter().map(of).reduce(f64::max);
        let wrench = |i: usize| self.wrenches.iter().map(|w| w[i]).reduce(f64::max);
        MeasurementLimits {
            max_linear_velocity: Some(self.linear_velocity),
            max_angular_velocity: Some(self.angular_velocity),
            max_joint_velocity: joint(|j| j.velocity),
            max_linear_acceleration: Some(self.linear_acceleration),
            max_angular_acceleration: Some(self.angular_acceleration),
            max_joint_acceleration: joint(|j| j.acceleration),
            max_position_jump: Some(self.position_jump),
            max_rotation_jump: Some(self.rotation_jump),
            max_joint_jump: joint(|j| j.jump),
            max_force: wrench(0),
            max_moment: wrench(1),
        }
    }

    /// What of a measurement is not plausible, if anything; all its numbers are finite. `last` is the last usable
    /// state, and `stamp` its time.
    pub(super) fn fault(
        &mut self,
        measurement: &Measurement,
        last: &State,
        stamp: Option<f64>,
    ) -> Option<Fault> {
        let now = measurement.time;
        let fault = self.speeds(measurement).or_else(|| {
            let unseen = self.see(now)?;
            let passed = stamp.map_or(unseen, |stamp| unseen.max(now - stamp));
            self.since(&measurement.state, last, [unseen, passed])
        });
        if fault.is_none() {
            self.seen.gap = 0.0;
        }
        fault
            .or_else(|| self.forces(measurement))
            .map(Fault::Implausible)
    }

    /// The next measurement is compared with a state that was seen at this time.
    pub(super) fn restart(&mut self, stamp: f64) {
        self.seen = Seen {
            last: Some(stamp),
            gap: 0.0,
        };
    }

    /// Takes down that the robot is seen now; for how long it was not since the last usable measurement, if there was
    /// one.
    fn see(&mut self, stamp: f64) -> Option<f64> {
        let last = self.seen.last.replace(stamp)?;
        self.seen.gap = self.seen.gap.max(stamp - last);
        Some(self.seen.gap.max(self.period))
    }

    /// What of the speeds and forces is not plausible.
    pub(super) fn in_itself(&self, measurement: &Measurement) -> Option<Implausible> {
        self.speeds(measurement)
            .or_else(|| self.forces(measurement))
    }

    fn speeds(&self, measurement: &Measurement) -> Option<Implausible> {
        let v = measurement.state.v.as_slice();
        let (base, joints) = split(v, measurement.state.q.len());
        if let Some([linear, angular]) = base {
            let fault = beyond(Measured::LinearVelocity, norm(linear), self.linear_velocity)
                .or_else(|| {
                    let speed = norm(angular);
                    beyond(Measured::AngularVelocity, speed, self.angular_velocity)
                });
            if fault.is_some() {
                return fault;
            }
        }
        let joints = joints.iter().zip(&self.joints).enumerate();
        let mut joints = joints.filter_map(|(i, (v, bounds))| {
            let joint = Measured::JointVelocity(JointId::new(i));
            beyond(joint, v.abs(), bounds.velocity)
        });
        joints.next()
    }

    fn forces(&self, measurement: &Measurement) -> Option<Implausible> {
        let wrenches = measurement.wrenches.iter().zip(&self.wrenches).enumerate();
        let mut wrenches = wrenches.filter_map(|(i, (wrench, [most_force, most_moment]))| {
            let contact = ContactId(i as u32);
            let [fx, fy, fz, mx, my, mz] = <[f64; 6]>::from(*wrench);
            let force = norm([fx, fy, fz]);
            beyond(Measured::Force(contact), force, *most_force).or_else(|| {
                let moment = norm([mx, my, mz]);
                beyond(Measured::Moment(contact), moment, *most_moment)
            })
        });
        wrenches.next()
    }

    /// What has changed too much since a state that is `passed` seconds old, of which the robot was not seen for so
    /// many.
    fn since(&self, now: &State, last: &State, [unseen, passed]: [f64; 2]) -> Option<Implausible> {
        let periods = unseen / self.period;
        // Nothing in an ordinary tick.
        let seen = 2.0 * (passed - unseen);
        let (base, joint_speeds) = split(now.v.as_slice(), now.q.len());
        let (base_before, speeds_before) = split(last.v.as_slice(), last.q.len());
        let speed = |i: usize| {
            let [now, before] = [base, base_before].map(|v| v.map_or(0.0, |v| norm(v[i])));
            now.max(before)
        };
        let jump = norm((now.p_WR - last.p_WR).into());
        let most = self.position_jump * periods + seen * speed(0);
        let fault = beyond(Measured::PositionJump, jump, most);
        let fault = fault.or_else(|| {
            let angle = last
                .R_WR
                .angle_to(&UnitQuaternion::new_normalize(*now.R_WR));
            let most = self.rotation_jump * periods + seen * speed(1);
            beyond(Measured::RotationJump, angle, most)
        });
        if fault.is_some() {
            return fault;
        }
        let speeds = joint_speeds.iter().zip(speeds_before);
        let joints = now.q.iter().zip(last.q.iter()).zip(speeds);
        let mut joints = joints.zip(&self.joints).enumerate();
        let fault = joints.find_map(|(i, (((q, q_before), (v, v_before)), bounds))| {
            let joint = JointId::new(i);
            let most = bounds.jump * periods + seen * v.abs().max(v_before.abs());
            beyond(Measured::JointJump(joint), (q - q_before).abs(), most).or_else(|| {
                let rate = (v - v_before).abs() / passed;
                beyond(
                    Measured::JointAcceleration(joint),
                    rate,
                    bounds.acceleration,
                )
            })
        });
        let (Some(base), Some(base_before)) = (base, base_before) else {
            return fault;
        };
        let rate = |i: usize| {
            let (now, before): ([f64; 3], [f64; 3]) = (base[i], base_before[i]);
            norm(std::array::from_fn(|k| now[k] - before[k])) / passed
        };
        let linear = || {
            beyond(
                Measured::LinearAcceleration,
                rate(0),
                self.linear_acceleration,
            )
        };
        let angular = || {
            beyond(
                Measured::AngularAcceleration,
                rate(1),
                self.angular_acceleration,
            )
        };
        fault.or_else(linear).or_else(angular)
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

fn beyond(quantity: Measured, value: f64, limit: f64) -> Option<Implausible> {
    (value > limit).then_some(Implausible {
        quantity,
        value,
        limit,
    })
}

/// Linear and angular velocity of a floating base, and the joints'.
fn split(v: &[f64], joints: usize) -> (Option<[[f64; 3]; 2]>, &[f64]) {
    let (base, joints) = v.split_at(v.len().saturating_sub(joints));
    let base = match *base {
        [vx, vy, vz, wx, wy, wz] => Some([[vx, vy, vz], [wx, wy, wz]]),
        _ => None,
    };
    (base, joints)
}

/// Length of a vector, also where its square overflows.
fn norm(vector: [f64; 3]) -> f64 {
    let largest = vector.into_iter().fold(0.0, |a: f64, x| a.max(x.abs()));
    if largest == 0.0 || largest.is_infinite() {
        return largest;
    }
    let squares = vector.map(|x| (x / largest) * (x / largest));
    largest * squares.into_iter().sum::<f64>().sqrt()
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
