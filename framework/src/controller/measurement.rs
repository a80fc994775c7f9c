//! What the sensors say at the beginning of a tick.

use nalgebra::Vector6;

use crate::{
    contact::ContactId,
    fault::{Fault, Quantity},
    robot::RobotModel,
};
use wbqp_dynamics::state::State;

/// The inputs of a tick.
#[derive(Clone, Debug)]
pub struct Measurement {
    /// Time, s, on any clock that goes forwards from tick to tick: a stamp that is not later than the last usable one
    /// is a fault (a clock that was set back is used again once it has gone on regularly for ten ticks). References and
    /// ramps count from the first tick.
    pub time: f64,
    /// Estimated state, velocities world-aligned.
    pub state: State,
    /// Per contact (in the configuration's order): wrench that the environment exerts on the robot,
    /// `[force; moment]`, N and N·m, in the axes and about the origin of the contact's frame E on the robot.
    /// Convert the sensor's sign where it is read. Zero where there is no sensor.
    pub wrenches: Vec<Vector6<f64>>,
}

impl Measurement {
    /// The robot's home posture at rest at time 0, no force.
    pub fn home(robot: &RobotModel, contacts: usize) -> Self {
        Self {
            time: 0.0,
            state: robot.home.clone(),
            wrenches: vec![Vector6::zeros(); contacts],
        }
    }

    /// Copies another measurement without allocating; of one of other sizes the time only.
    pub(super) fn copy_from(&mut self, other: &Self) {
        self.time = other.time;
        let (state, others) = (&mut self.state, &other.state);
        if (state.q.len(), state.v.len()) == (others.q.len(), others.v.len()) {
            state.copy_from(others);
        }
        if self.wrenches.len() == other.wrenches.len() {
            self.wrenches.copy_from_slice(&other.wrenches);
        }
    }

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
        if self.wrenches.len() != contacts {
            return Some(Fault::WrongSize(Quantity::Wrenches));
        }
        let state = &self.state;
        let checks = [
            (
                Quantity::BasePosition,
                state.p_WR.iter().all(|x| x.is_finite()),
            ),
            (
                Quantity::BaseOrientation,
                state.R_WR.coords.iter().all(|x| x.is_finite()),
            ),
            (
                Quantity::JointPositions,
                state.q.iter().all(|x| x.is_finite()),
            ),
            (Quantity::Velocities, state.v.iter().all(|x| x.is_finite())),
        ];
        if let Some((what, _)) = checks.iter().find(|(_, finite)| !finite) {
            return Some(Fault::NotFinite(*what));
        }
        // Estimators deliver unit quaternions up to rounding; anything else is no orientation.
        if !(0.9..=1.1).contains(&state.R_WR.coords.norm()) {
            return Some(Fault::NotARotation);
        }
        let bad = |w: &Vector6<f64>| !w.iter().all(|x| x.is_finite());
        self.wrenches
            .iter()
            .position(bad)
            .map(|i| Fault::NotFinite(Quantity::Wrench(ContactId(i as u32))))
    }
}
