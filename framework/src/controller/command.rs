//! The command of a tick, and what its last gate keeps.

use crate::fault::Fault;
use wbqp_dynamics::model::JointId;
use wbqp_robot_model::RobotModel;

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
}

/// What the gate changed by more than rounding, the first of each kind.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cut {
    /// [`Fault::CutEffort`].
    pub(super) effort: Option<Fault>,
    pub(super) velocity: Option<JointId>,
}

/// What was sent last, and where efforts may go in this tick. In storage made once.
#[derive(Clone, Debug)]
pub(super) struct Gate {
    pub(super) last: Command,
    /// Where each effort may go.
    pub(super) window: Vec<[f64; 2]>,
}

impl Gate {
    pub(super) fn new(robot: &RobotModel) -> Self {
        Self {
            last: Command::new(robot),
            window: robot.actuators.iter().map(|a| [a.lower, a.upper]).collect(),
        }
    }
}
