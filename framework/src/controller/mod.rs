//! The controller: bind once, then tick.
//!
//! A tick is measurement → kinematics and dynamics → rows of tasks and constraints → quadratic program →
//! solver → command and report. Nothing is allocated after
//! [`Controller::new`] except inside a solver that needs it.

mod bind;
mod bounds;
mod change;
mod command;
mod entry_id;
mod error;
mod explanation;
mod fallback;
mod first;
mod fit;
mod home;
mod hover;
mod inquiries;
mod measurement;
mod memory;
mod misfits;
mod names;
mod observer;
mod output;
mod parameters;
mod planned_force;
mod probe;
mod record;
mod report;
mod requests;
mod reset;
mod running;
mod sensitivity;
mod snapshot;
mod tick;
mod world;

pub use change::Change;
pub use command::Command;
pub use entry_id::EntryId;
pub use error::RequestError;
pub use measurement::Measurement;
pub use memory::Memory;
pub use probe::{Probe, ProbeInputs, WrittenRows};
pub use record::Dump;
pub use report::{ContactReport, FallbackLevel, LimitRow, Report, Side, TaskReport};
pub use sensitivity::{Effect, Parameter, ParameterKind, Sensitivity};
pub use snapshot::Snapshot;

pub(crate) use bind::{Bound, Parts};
pub(crate) use misfits::{Misfit, MisfitKind};
pub(crate) use record::MadeFrom;

use bounds::Plausible;
use command::Gate;
use entry_id::Stamp;
use fallback::Fallback;
use first::FirstTick;
use nalgebra::DVector;
use record::Recorder;
use running::RunningPlugin;
use sensitivity::Before;
use world::World;

use crate::{
    problem::{BoundEntry, Problem, Table},
    qp::{Qp, Solution, Solver},
    settings::Settings,
    stopwatch::Stopwatch,
};
use wbqp_dynamics::Actuation;
use wbqp_robot_model::RobotModel;

/// A whole-body controller bound to a robot.
///
/// Made by [`Controller::new`]; [`Controller::tick`] is the real-time part. Switching, replacing references and
/// changing weights happen between ticks.
#[derive(Debug)]
pub struct Controller {
    settings: Settings,
    robot: RobotModel,
    /// One per task, then one per constraint.
    plugins: Vec<RunningPlugin>,
    /// Their rows.
    entries: Vec<BoundEntry>,
    task_count: usize,
    table: Table,
    problem: Problem,
    actuation: Actuation,
    qp: Qp,
    solution: Solution,
    solver: Box<dyn Solver>,
    world: World,
    command: Command,
    gate: Gate,
    plausible: Plausible,
    report: Report,
    fallback: Fallback,
    /// Where dumps find what the controller was made from.
    made_from: MadeFrom,
    recorder: Option<Recorder>,
    hover_residual: DVector<f64>,
    stopwatch: Box<dyn Stopwatch>,
    first: FirstTick,
    /// What a [`Sensitivity`] of this controller must have.
    stamp: Stamp,
    /// What the last tick began with, if that is kept.
    before: Option<Box<Before>>,
    /// Counts changes of plug-ins' keys.
    revision: u64,
}
