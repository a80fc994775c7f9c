//! A command without a solution: the last efforts, kept for a short time, and then a law that needs no solver.

use super::{Age, Fallback, Moment};
use crate::{
    controller::{Command, output::leaked, report::FallbackLevel, world::World},
    fault::Fault,
    plugin::EntryState,
    settings::Settings,
};
use wbqp_dynamics::{model::Model, state::State};
use wbqp_robot_model::RobotModel;

impl Fallback {
    /// Writes a command for a tick with a fault; says from which level.
    pub(in super::super) fn command(
        &mut self,
        fault: Fault,
        robot: &RobotModel,
        settings: &Settings,
        world: &World,
        now: Moment,
        command: &mut Command,
    ) -> FallbackLevel {
        let period = world.period;
        let time = if fault.is_of_the_stamp() {
            f64::NAN
        } else {
            now.stamp
        };
        let age = self.without_solution.seconds(time, period);
        // Periods do not add up exactly.
        let level = if age <= settings.extrapolation + 1e-6 * period {
            FallbackLevel::Extrapolated
        } else {
            FallbackLevel::Safe
        };
        let changed = self.level != level || self.on_level.ticks == 0;
        if level == FallbackLevel::Extrapolated {
            let (model, state) = (&robot.model, &world.state);
            if changed {
                command.engage(model, state);
            }
            command.coast(model, state, now.since_last_tick, settings.velocity_leak);
            return level;
        }
        let tick = world.tick(EntryState::ON);
        if changed || self.without_state.is_first {
            // Until then it did not know where the robot is.
            self.law.engage(&tick);
        }
        let age = self.without_state.seconds(time, period);
        let efforts = &mut command.effort;
        self.law.efforts(&tick, age, efforts);
        for (i, (effort, actuator)) in efforts.iter_mut().zip(&robot.actuators).enumerate() {
            if !effort.is_finite() {
                *effort = self.hover[i];
            }
            let (sent, most) = (tick.last_effort[i], actuator.slew * tick.slew_time);
            let near = effort.max(sent - most).min(sent + most);
            *effort = near.max(actuator.lower).min(actuator.upper);
        }
        command.stop_joints();
        level
    }
}

impl Age {
    /// Seconds: by the clock or by the number of ticks, whichever is longer; infinite if it never was.
    pub(in super::super) fn seconds(&self, now: f64, period: f64) -> f64 {
        self.last.map_or(f64::INFINITY, |(time, ticks)| {
            let passed = ticks as f64 * period;
            // A stamp that is not a number says nothing.
            if now.is_finite() {
                passed.max(now - time)
            } else {
                passed
            }
        })
    }
}

impl Command {
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
}
