//! Why a tick's command is not the optimum of its problem.

mod implausible;

use crate::contact::ContactId;
use wbqp_dynamics::{actuator::ActuatorId, model::JointId};

/// Why a tick's command is not the optimum of its problem.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Fault {
    /// A measured number is NaN or infinite.
    NotFinite(Quantity),
    /// A measured list has the wrong size.
    WrongSize(Quantity),
    /// The time stamp is not later than that of the last usable state. (One that is too much later is implausible.)
    /// Usable is a state that was finite and plausible, whatever the wrenches beside it were.
    NotLater,
    /// The base's quaternion is not of unit length, nor near it.
    NotARotation,
    /// A measured number, or its change since the last usable state, is beyond what the table `[measurement]`
    /// allows.
    Implausible {
        /// What was measured, or how it has changed.
        quantity: Quantity,
        /// Its size: s, m, rad, N or N·m, of speeds per second, of accelerations per second squared.
        value: f64,
        /// The largest that is plausible, in the same unit.
        limit: f64,
    },
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
    /// The solution's effort of an actuator is not what was sent: beyond its limits, or further from the last one than
    /// its `slew` allows.
    CutEffort {
        /// Whose.
        actuator: ActuatorId,
        /// What would have been sent, N or N·m.
        asked: f64,
        /// What was sent, N or N·m.
        sent: f64,
    },
    /// The velocity reference of this joint was not a number, and stays what it was.
    CutVelocity(JointId),
}

/// A measured quantity: a part of a measurement, or a size or a change that has a bound in `[measurement]`.
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
    /// Position of a joint.
    JointPosition(JointId),
    /// Generalised velocities.
    Velocities,
    /// The list of wrenches.
    Wrenches,
    /// One contact's wrench.
    Wrench(ContactId),
    /// Time since the last usable state.
    Gap,
    /// Speed of the base.
    LinearVelocity,
    /// Angular speed of the base.
    AngularVelocity,
    /// Speed of a joint.
    JointVelocity(JointId),
    /// Change of the base's velocity since the last usable state, by time.
    LinearAcceleration,
    /// Change of the base's angular velocity, by time.
    AngularAcceleration,
    /// Change of a joint's velocity, by time.
    JointAcceleration(JointId),
    /// Change of the base's position since the last usable state.
    PositionJump,
    /// Angle that the base has turned.
    RotationJump,
    /// Change of a joint's position.
    JointJump(JointId),
    /// Force at a contact.
    Force(ContactId),
    /// Moment at a contact.
    Moment(ContactId),
}

impl Fault {
    /// Whether it is about the time stamp, which then says nothing of how much time has passed.
    pub(crate) fn is_of_the_stamp(self) -> bool {
        match self {
            Self::NotFinite(quantity) | Self::Implausible { quantity, .. } => {
                matches!(quantity, Quantity::Time | Quantity::Gap)
            }
            _ => false,
        }
    }

    /// Whether it is about measured wrenches: the state is usable.
    pub(crate) fn is_of_a_wrench(self) -> bool {
        match self {
            Self::NotFinite(quantity) | Self::WrongSize(quantity) => {
                matches!(quantity, Quantity::Wrench(_) | Quantity::Wrenches)
            }
            Self::Implausible { quantity, .. } => {
                matches!(quantity, Quantity::Force(_) | Quantity::Moment(_))
            }
            _ => false,
        }
    }
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
            Self::Implausible {
                quantity,
                value,
                limit,
            } => quantity.write_beyond([*value, *limit], f),
            Self::FirstError(task) => write!(
                f,
                "the error of task {task} in the first tick is larger than `max_first_error` allows"
            ),
            Self::Rows(entry) => write!(f, "entry {entry} wrote a number that is not finite"),
            Self::MassMatrix => f.write_str("the mass matrix is not positive definite"),
            Self::Dynamics => f.write_str("the equations of motion are not finite at this state"),
            Self::Infeasible => f.write_str("limits contradict one another"),
            Self::Solver => f.write_str("the solver gave no usable solution"),
            Self::CutEffort { actuator, .. } => write!(
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
            other => f.write_str(other.what()),
        }
    }
}
