//! What the sensors say at the beginning of a tick, and whether it can be true of the robot.
//!
//! # What is compared
//! The time since the last usable state, places, speeds and forces with a bound each ([`bounds`](super::bounds)).
//! Positions and velocities, besides, with those of the last usable state. Positions may have changed by a bound per
//! period, for as many periods as the robot was not seen, and while it was seen by twice what its speed explains.
//! Velocities may have changed by a bound for all the time in between.
//!
//! A state is usable if it is finite and plausible, whether or not the wrenches beside it are: of a measurement whose
//! wrenches alone cannot be used the state is taken over, and its stamp counts.
//!
//! A robot is seen by every measurement whose speeds are plausible, also by one that has jumped. So after an
//! outage the robot may be as far away as it could have come in that time, and a blow too hard to be believed is over
//! when it is over; but where measurements go on regularly, and lie elsewhere than their own speeds could have brought
//! the robot, waiting does not make the jump plausible: it has to be said that it is meant
//! ([`Controller::reset`](super::Controller::reset)), or to end.

use std::array::from_fn;

use nalgebra::Vector6;

use super::bounds::Plausible;
use crate::{
    contact::ContactId,
    fault::{Fault, Quantity},
};
use wbqp_dynamics::{
    model::JointId,
    spatial::{angle_above, length},
    state::State,
};
use wbqp_robot_model::RobotModel;

/// The inputs of a tick.
#[derive(Clone, Debug)]
pub struct Measurement {
    /// Time, s, on any clock that goes forwards from tick to tick: a stamp that is not later than the last usable
    /// state's is a fault (a clock that was set back is used again once it has gone on regularly for ten ticks).
    /// References and ramps count from the first tick.
    pub time: f64,
    /// Estimated state, velocities world-aligned.
    pub state: State,
    /// Per contact (in the configuration's order): wrench that the environment exerts on the robot,
    /// `[force; moment]`, N and N·m, in the axes and about the origin of the contact's frame E on the robot.
    /// Convert the sensor's sign where it is read. Zero where there is no sensor.
    pub wrenches: Vec<Vector6<f64>>,
}

impl Measurement {
    /// What makes the measurement unusable, if anything does.
    pub(crate) fn fault(
        &self,
        robot: &RobotModel,
        contacts: usize,
        last: Option<f64>,
    ) -> Option<Fault> {
        if !self.time.is_finite() {
            return Some(Fault::NotFinite(Quantity::Time));
        }
        if last.is_some_and(|last| self.time <= last) {
            return Some(Fault::NotLater);
        }
        if !self.state.fits(&robot.model) {
            return Some(Fault::WrongSize(Quantity::State));
        }
        let state = &self.state;
        let numbers = [
            (Quantity::BasePosition, state.p_WR.as_slice()),
            (Quantity::BaseOrientation, state.R_WR.coords.as_slice()),
            (Quantity::JointPositions, state.q.as_slice()),
            (Quantity::Velocities, state.v.as_slice()),
        ];
        let is_bad = |(_, numbers): &(Quantity, &[f64])| !numbers.iter().all(|x| x.is_finite());
        if let Some((what, _)) = numbers.into_iter().find(is_bad) {
            return Some(Fault::NotFinite(what));
        }
        // Estimators deliver unit quaternions up to rounding; anything else is no orientation.
        if !(0.9..=1.1).contains(&state.R_WR.coords.norm()) {
            return Some(Fault::NotARotation);
        }
        if self.wrenches.len() != contacts {
            return Some(Fault::WrongSize(Quantity::Wrenches));
        }
        let bad = |w: &Vector6<f64>| !w.iter().all(|x| x.is_finite());
        self.wrenches
            .iter()
            .position(bad)
            .map(|i| Fault::NotFinite(Quantity::Wrench(ContactId(i as u32))))
    }
}

impl Plausible {
    /// What of a measurement is not plausible, if anything; all numbers of its state are finite. `last` is the last
    /// usable state, and `stamp` its time.
    pub(super) fn fault(
        &mut self,
        measurement: &Measurement,
        last: &State,
        stamp: Option<f64>,
    ) -> Option<Fault> {
        let now = measurement.time;
        if let Some(fault) = stamp.and_then(|last| beyond(Quantity::Gap, now - last, self.gap)) {
            return Some(fault);
        }
        let absurd = self.places(&measurement.state);
        let absurd = absurd.or_else(|| self.speeds(measurement));
        let fault = absurd.or_else(|| {
            let unseen = self.see(now)?;
            let passed = stamp.map_or(unseen, |stamp| unseen.max(now - stamp));
            self.since(&measurement.state, last, [unseen, passed])
        });
        if fault.is_none() {
            self.seen.gap = 0.0;
        }
        fault.or_else(|| self.forces(measurement))
    }

    /// Takes down that the robot is seen now; for how long it was not since the last usable state, if there was
    /// one.
    fn see(&mut self, stamp: f64) -> Option<f64> {
        let last = self.seen.last.replace(stamp)?;
        self.seen.gap = self.seen.gap.max(stamp - last);
        Some(self.seen.gap.max(self.period))
    }

    /// Where nothing of the robot can be.
    pub(super) fn places(&self, state: &State) -> Option<Fault> {
        let base = beyond(
            Quantity::BasePosition,
            length(state.p_WR.into()),
            self.position,
        );
        base.or_else(|| {
            let joints = state.q.iter().zip(&self.joints).enumerate();
            let mut joints = joints.filter_map(|(i, (q, bounds))| {
                let joint = Quantity::JointPosition(JointId::new(i));
                beyond(joint, q.abs(), bounds.position)
            });
            joints.next()
        })
    }

    pub(super) fn speeds(&self, measurement: &Measurement) -> Option<Fault> {
        let (base, joints) = measurement.state.velocities();
        let base = base.and_then(|[linear, angular]| {
            let fault = beyond(Quantity::LinearVelocity, length(linear), self.velocity[0]);
            fault.or_else(|| beyond(Quantity::AngularVelocity, length(angular), self.velocity[1]))
        });
        if base.is_some() {
            return base;
        }
        let joints = joints.iter().zip(&self.joints).enumerate();
        let mut joints = joints.filter_map(|(i, (v, bounds))| {
            let joint = Quantity::JointVelocity(JointId::new(i));
            beyond(joint, v.abs(), bounds.velocity)
        });
        joints.next()
    }

    pub(super) fn forces(&self, measurement: &Measurement) -> Option<Fault> {
        let wrenches = measurement.wrenches.iter().zip(&self.wrenches).enumerate();
        let mut wrenches = wrenches.filter_map(|(i, (wrench, [most_force, most_moment]))| {
            let contact = ContactId(i as u32);
            let [fx, fy, fz, mx, my, mz] = <[f64; 6]>::from(*wrench);
            let force = length([fx, fy, fz]);
            beyond(Quantity::Force(contact), force, *most_force).or_else(|| {
                let moment = length([mx, my, mz]);
                beyond(Quantity::Moment(contact), moment, *most_moment)
            })
        });
        wrenches.next()
    }

    /// What has changed too much since a state that is `passed` seconds old, of which the robot was not seen for so
    /// many.
    fn since(&self, now: &State, last: &State, [unseen, passed]: [f64; 2]) -> Option<Fault> {
        let periods = unseen / self.period;
        // Nothing in an ordinary tick.
        let seen = 2.0 * (passed - unseen);
        let (base, joint_speeds) = now.velocities();
        let (base_before, speeds_before) = last.velocities();
        let most = |i: usize| {
            let [now, before] = [base, base_before].map(|v| v.map_or(0.0, |v| length(v[i])));
            self.jump[i] * periods + seen * now.max(before)
        };
        let jump = length((now.p_WR - last.p_WR).into());
        let fault = beyond(Quantity::PositionJump, jump, most(0)).or_else(|| {
            let angle = angle_above(&last.R_WR, &now.R_WR, most(1))?;
            beyond(Quantity::RotationJump, angle, most(1))
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
            let jump = (q - q_before).abs();
            let rate = (v - v_before).abs() / passed;
            if jump <= most && rate <= bounds.acceleration {
                return None;
            }
            let jump = beyond(Quantity::JointJump(joint), jump, most);
            let joint = Quantity::JointAcceleration(joint);
            jump.or_else(|| beyond(joint, rate, bounds.acceleration))
        });
        let (Some(base), Some(base_before)) = (base, base_before) else {
            return fault;
        };
        let rate = |i: usize| length(from_fn(|k| base[i][k] - base_before[i][k])) / passed;
        let linear = || beyond(Quantity::LinearAcceleration, rate(0), self.acceleration[0]);
        let angular = || beyond(Quantity::AngularAcceleration, rate(1), self.acceleration[1]);
        fault.or_else(linear).or_else(angular)
    }
}

fn beyond(quantity: Quantity, value: f64, limit: f64) -> Option<Fault> {
    (value > limit).then_some(Fault::Implausible {
        quantity,
        value,
        limit,
    })
}
