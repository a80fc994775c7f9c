//! What a batch computes: where it is in one memory, quantity by quantity.

use wbqp::{Controller, controller::FallbackLevel};

use crate::views::Memory;

/// What is computed per controller.
#[derive(Clone, Copy)]
pub(super) struct Shape {
    pub(super) actuators: usize,
    pub(super) joints: usize,
    pub(super) velocities: usize,
    pub(super) contacts: usize,
}

impl Shape {
    /// Numbers of a controller.
    pub(super) fn cells(self) -> usize {
        2 * self.actuators + 2 * self.joints + self.velocities + 6 * self.contacts + 1
    }
}

/// Where the outputs of a controller are.
pub(super) struct Outputs {
    pub(super) effort: usize,
    pub(super) rotor_speed: usize,
    pub(super) joint_acceleration: usize,
    pub(super) joint_velocity: usize,
    pub(super) vdot: usize,
    pub(super) contact: usize,
    pub(super) level: usize,
}

impl Outputs {
    /// Those of number `i` of `n`.
    pub(super) fn of(shape: Shape, i: usize, n: usize) -> Self {
        let rotor_speed = shape.actuators * n;
        let joint_acceleration = rotor_speed + shape.actuators * n;
        let joint_velocity = joint_acceleration + shape.joints * n;
        let vdot = joint_velocity + shape.joints * n;
        let contact = vdot + shape.velocities * n;
        let level = contact + 6 * shape.contacts * n;
        Self {
            effort: shape.actuators * i,
            rotor_speed: rotor_speed + shape.actuators * i,
            joint_acceleration: joint_acceleration + shape.joints * i,
            joint_velocity: joint_velocity + shape.joints * i,
            vdot: vdot + shape.velocities * i,
            contact: contact + 6 * shape.contacts * i,
            level: level + i,
        }
    }

    /// Takes over what a controller of the same shape gave last.
    pub(super) fn write(&self, memory: &Memory, controller: &Controller) {
        let (command, report) = (controller.command(), controller.report());
        memory.write(self.effort, &command.effort);
        memory.write(self.rotor_speed, &command.rotor_speed);
        memory.write(self.joint_acceleration, &command.joint_acceleration);
        memory.write(self.joint_velocity, &command.joint_velocity);
        memory.write(self.vdot, report.vdot.as_slice());
        for (k, contact) in report.contacts.iter().enumerate() {
            memory.write(self.contact + 6 * k, contact.solution.as_slice());
        }
        let levels = FallbackLevel::ALL.iter();
        let level = levels.take_while(|level| **level != report.level).count();
        memory.set(self.level, level as f64);
    }
}
