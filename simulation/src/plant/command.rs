//! What the plant is told, and how late.

use std::collections::VecDeque;

use wbqp::{
    actuator::{ActuatorKind, Drive},
    controller::Command,
    robot::RobotModel,
};

/// One value per actuator, in the order of `u`, held during a control period.
///
/// A rotor takes its thrust in N, a torque-driven joint its effort in N·m or N, a servoed joint
/// ([`Drive::Velocity`](wbqp::actuator::Drive::Velocity)) its velocity reference in rad/s or m/s. Values beyond
/// what the actuator can do are cut off by the plant; one that is not finite makes it diverge.
#[derive(Clone, Debug, PartialEq)]
pub struct PlantCommand {
    values: Vec<f64>,
}

impl PlantCommand {
    /// Rotors at their lowest thrust, no torque, servos standing still.
    pub fn rest(robot: &RobotModel) -> Self {
        let rest = |lower: f64, upper: f64| 0.0_f64.max(lower).min(upper);
        let values = robot.actuators.iter();
        Self {
            values: values.map(|a| rest(a.lower, a.upper)).collect(),
        }
    }

    /// What a controller's command says to each actuator; see [`PlantCommand::take`].
    pub fn of(robot: &RobotModel, command: &Command) -> Self {
        let mut taken = Self::rest(robot);
        taken.take(robot, command);
        taken
    }

    /// Takes over a controller's command without allocating, by what each actuator takes: the thrust of a rotor, the
    /// effort of a torque-driven joint, and the velocity reference of a servoed one, whose effort is what the solver
    /// expects of the servo and not an input of it.
    ///
    /// Both are for the same robot; what a command of another one does not have stays as it was.
    pub fn take(&mut self, robot: &RobotModel, command: &Command) {
        for (i, (actuator, out)) in robot.actuators.iter().zip(&mut self.values).enumerate() {
            let value = match &actuator.kind {
                ActuatorKind::Joint(motor) if motor.drive == Drive::Velocity => {
                    command.joint_velocity.get(motor.joint.index())
                }
                _ => command.effort.get(i),
            };
            if let Some(value) = value {
                *out = *value;
            }
        }
    }

    /// The values, in the order of `u`.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The values, to be written.
    pub fn values_mut(&mut self) -> &mut [f64] {
        &mut self.values
    }

    /// Copies another command without allocating if both are for the same robot.
    pub fn copy_from(&mut self, other: &Self) {
        self.values.clone_from(&other.values);
    }
}

/// Time that passes between a measurement and its command, in control periods.
#[derive(Clone, Debug)]
pub struct CommandDelay {
    waiting: VecDeque<PlantCommand>,
    applied: PlantCommand,
}

impl CommandDelay {
    /// A delay of so many periods, in which `initial` is applied.
    pub fn new(periods: usize, initial: PlantCommand) -> Self {
        Self {
            waiting: vec![initial.clone(); periods].into(),
            applied: initial,
        }
    }

    /// Takes the command computed from the sample at `t_k` and hands out the one for `[t_k, t_k+1)`: the
    /// command of `periods` samples before.
    pub fn exchange(&mut self, computed: &PlantCommand) -> &PlantCommand {
        match self.waiting.pop_front() {
            None => self.applied.copy_from(computed),
            Some(due) => {
                // The storage of the command that has been applied carries the new one.
                let mut storage = std::mem::replace(&mut self.applied, due);
                storage.copy_from(computed);
                self.waiting.push_back(storage);
            }
        }
        &self.applied
    }
}
