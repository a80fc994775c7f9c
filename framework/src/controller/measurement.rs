//! What the sensors say at the beginning of a tick.

use nalgebra::Vector6;

use super::implausible::Implausible;
use crate::{
    actuator::ActuatorId, contact::ContactId, model::JointId, robot::RobotModel, state::State,
};

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

/// A measured quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Quantity {
    /// The time stamp.
    Time,
    /// The state as a whole.
    State,
    /// Position of the base.
    BasePosition,
    /// Orientation of the base.
    BaseOrientation,
    /// Joint positions.
    JointPositions,
    /// Generalised velocities.
    Velocities,
    /// The list of wrenches.
    Wrenches,
    /// One contact's wrench.
    Wrench(ContactId),
}

/// Why a tick's command is not the optimum of its problem.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Fault {
    /// A measured number is NaN or infinite.
    NotFinite(Quantity),
    /// A measured list has the wrong size.
    WrongSize(Quantity),
    /// The time stamp is not later than that of the last usable measurement.
    NotLater,
    /// The base's quaternion is not of unit length, nor near it.
    NotARotation,
    /// A measured number, or its change since the last usable measurement, is beyond what the table `[measurement]`
    /// allows.
    Implausible(Implausible),
    /// In the first tick the error of this task (its position among the tasks) is larger than `max_first_error` of the
    /// settings allows: nothing moves, and the next tick counts as the first.
    FirstError(usize),
    /// A plug-in wrote a coefficient or a limit that is not a number; the index counts tasks, then constraints.
    Rows(usize),
    /// The mass matrix is not positive definite at this state.
    MassMatrix,
    /// The equations of motion have no finite numbers at this state.
    Dynamics,
    /// Limits contradict one another; which is in the report.
    Infeasible,
    /// The solver gave no usable solution; its status is in the report.
    Solver,
    /// The solution's effort of this actuator is not what was sent: beyond its limits, or further from the last one
    /// than its `slew` allows. By how much is in the report ([`Report::cut`](super::Report::cut)).
    CutEffort(ActuatorId),
    /// The velocity reference of this joint was not a number, and stays what it was.
    CutVelocity(JointId),
}

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NotFinite(q) => write!(f, "measurement not finite: {q}"),
            Self::WrongSize(q) => write!(f, "measurement of the wrong size: {q}"),
            Self::NotLater => f.write_str("measurement: the time stamp is not later than the last"),
            Self::NotARotation => {
                f.write_str("measurement: the base orientation is not a unit quaternion")
            }
            Self::Implausible(implausible) => implausible.fmt(f),
            Self::FirstError(task) => write!(
                f,
                "the error of task {task} in the first tick is larger than `max_first_error` allows"
            ),
            Self::Rows(entry) => write!(f, "entry {entry} wrote a number that is not finite"),
            Self::MassMatrix => f.write_str("the mass matrix is not positive definite"),
            Self::Dynamics => f.write_str("the equations of motion are not finite at this state"),
            Self::Infeasible => f.write_str("limits contradict one another"),
            Self::Solver => f.write_str("the solver gave no usable solution"),
            Self::CutEffort(actuator) => write!(
                f,
                "the effort of actuator {} had to be cut to its limits",
                actuator.index()
            ),
            Self::CutVelocity(joint) => write!(
                f,
                "the velocity reference of joint {} is not finite",
                joint.index()
            ),
        }
    }
}

impl std::fmt::Display for Quantity {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Time => f.write_str("time"),
            Self::State => f.write_str("state"),
            Self::BasePosition => f.write_str("base position"),
            Self::BaseOrientation => f.write_str("base orientation"),
            Self::JointPositions => f.write_str("joint positions"),
            Self::Velocities => f.write_str("velocities"),
            Self::Wrenches => f.write_str("list of wrenches"),
            Self::Wrench(c) => write!(f, "wrench of contact {}", c.index()),
        }
    }
}
