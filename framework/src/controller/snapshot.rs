//! What a tick took and gave, copied.

use nalgebra::Vector6;

use super::{Command, Controller, Measurement, Report, running::RunningPlugin};
use crate::{contact::SurfaceMotion, plugin::Sample};
use wbqp_robot_model::RobotModel;

/// What a tick took and gave, copied without allocation: for a log or a view that another thread writes.
/// The numbers in its report have their names there ([`Report::row`], [`Report::explain`]).
///
/// ```no_run
/// # fn send(_: &wbqp::controller::Snapshot) {}
/// # fn run(mut controller: wbqp::Controller) {
/// let mut measurement = controller.measurement();
/// let mut snapshot = controller.snapshot();
/// loop {
///     controller.tick(&measurement);
///     snapshot.take(&controller, &measurement);
///     send(&snapshot);
/// #   measurement.time += 0.001;
/// }
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct Snapshot {
    /// What the tick was given.
    pub measurement: Measurement,
    /// What it gave.
    pub command: Command,
    /// What it says of itself.
    pub report: Report,
    /// Where each contact's surface is and how it moves, in the configuration's order.
    pub surfaces: Vec<SurfaceMotion>,
    /// What each task followed, one sample for each of its references.
    pub references: Vec<Vec<Sample>>,
}

impl Snapshot {
    /// Command and report of the last tick, with room for all that a later one may say; the measurement is home.
    pub(super) fn of(controller: &Controller) -> Self {
        let tasks = controller.plugins[..controller.task_count].iter();
        let samples = |plugin: &RunningPlugin| {
            let followed = plugin.references.iter();
            followed.map(|followed| followed.sample.clone()).collect()
        };
        Self {
            measurement: controller.measurement(),
            command: controller.command.clone(),
            report: controller.report.with_room(),
            surfaces: controller.world.bindings.iter().map(|b| b.motion).collect(),
            references: tasks.map(samples).collect(),
        }
    }

    /// Takes the last tick over, of the controller that made this. Does not allocate. A measurement of other sizes,
    /// which the tick has refused, is left out but for its time.
    pub fn take(&mut self, controller: &Controller, measurement: &Measurement) {
        self.measurement.copy_from(measurement);
        self.command.copy_from(&controller.command);
        self.report.copy_from(&controller.report);
        for (out, binding) in self.surfaces.iter_mut().zip(&controller.world.bindings) {
            *out = binding.motion;
        }
        for (out, plugin) in self.references.iter_mut().zip(&controller.plugins) {
            for (out, followed) in out.iter_mut().zip(&plugin.references) {
                copy(out, &followed.sample);
            }
        }
    }
}

fn copy(out: &mut Sample, sample: &Sample) {
    match (out, sample) {
        (Sample::Vector(out), Sample::Vector(sample)) => {
            out.value.clone_from(&sample.value);
            out.rate.clone_from(&sample.rate);
            out.acceleration.clone_from(&sample.acceleration);
        }
        (Sample::Rotation(out), Sample::Rotation(sample)) => *out = *sample,
        // A reference is replaced by one of the same space only.
        _ => {}
    }
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
}
