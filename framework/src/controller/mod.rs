//! The controller: bind once, then tick.
//!
//! A tick is measurement → kinematics and dynamics → rows of tasks and constraints → quadratic program →
//! solver → command and report. Nothing is allocated after
//! [`Controller::new`] except inside a solver that needs it.

mod bind;
mod change;
mod command;
mod contact_binding;
mod elapsed;
mod entry_id;
mod entry_view;
mod error;
mod explanation;
mod fallback;
mod first;
mod fit;
mod gate;
mod home;
mod hover;
mod low_pass;
mod measurement;
mod memory;
mod misfits;
mod names;
mod observer;
mod output;
mod planned_force;
mod plausible;
mod probe;
mod record;
mod report;
mod requests;
mod running;
mod sensitivity;
mod snapshot;
mod world;

pub use change::Change;
pub use command::Command;
pub use entry_id::{EntryId, EntryRef};
pub use entry_view::EntryView;
pub use error::RequestError;
pub use explanation::{Explanation, Limit};
pub use gate::CutEffort;
pub use measurement::Measurement;
pub use memory::Memory;
pub use names::Names;
pub use planned_force::PlannedForce;
pub use probe::{Probe, ProbeInputs, WrittenRows};
pub use record::{Dump, Record, Source};
pub use report::{
    ActiveRow, ConflictRow, ContactReport, FallbackLevel, OnLevel, RelaxedRow, Report, Side,
    TaskReport,
};
pub use sensitivity::{
    Effect, Influence, Note, Parameter, ParameterKind, Sensitivity, SensitivityError,
};
pub use snapshot::{ContactSurface, Snapshot};

pub(crate) use bind::{Bound, Parts};
pub(crate) use misfits::{Misfit, MisfitKind};
pub(crate) use record::{CommandRecord, FORMAT, MadeFrom, misfit, rerun};

use nalgebra::DVector;

use crate::{
    fault::Fault,
    plugin::EntryState,
    problem::{BoundEntry, Problem, RowInfo, Solved, Table, VarInfo},
    qp::{Budget, Qp, RowId, Solution, Solver, Status, VarId},
    robot::RobotModel,
    settings::{MeasurementLimits, Settings},
    stopwatch::{StageTimes, Stopwatch},
};
use elapsed::elapsed;
use entry_id::Stamp;
use fallback::Fallback;
use first::FirstTick;
use gate::Gate;
use plausible::Plausible;
use record::{Recorder, recall_rows, record_inputs, record_outcome, record_rows};
use running::RunningPlugin;
use sensitivity::Before;
use wbqp_dynamics::Actuation;
use world::World;

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
    /// What ids of tasks must have.
    stamp: Stamp,
    /// What the last tick began with, if that is kept.
    before: Option<Box<Before>>,
    /// Counts changes of plug-ins' keys.
    revision: u64,
}

impl Controller {
    /// One control period: from a measurement to a command.
    ///
    /// Always returns a finite command within the actuators' limits, and within their `slew` of the last one: the
    /// optimum, or what the [`FallbackLevel`] of the report says, with the reason beside it. Does not allocate (unless
    /// the solver does), lock, block or read a clock.
    pub fn tick(&mut self, measurement: &Measurement) -> (&Command, &Report) {
        self.run(measurement, None);
        (&self.command, &self.report)
    }

    /// A tick, with the plug-ins' rows or recorded ones.
    fn run(&mut self, measurement: &Measurement, recorded: Option<&Record>) {
        record_inputs(self, measurement);
        if let Some(before) = &mut self.before {
            before.forget();
        }
        self.report.time = measurement.time;
        self.report.active.clear();
        self.report.conflict.clear();
        self.report.relaxed.clear();
        self.report.resolves = 0;
        self.report.status = Status::Unsolved;
        self.report.iterations = 0;
        self.report.objective = 0.0;
        self.report.times = StageTimes::default();
        self.fallback.is_proven = false;
        self.fallback.without_solution.pass();
        self.fallback.without_state.pass();
        let mut last = self.fallback.without_state.time();
        let period = self.world.period;
        let since_last_tick = elapsed(measurement.time, self.fallback.clock.previous, period);
        if self.fallback.clock.was_set(measurement.time, last, period) {
            self.world.rebase(measurement.time);
            let unseen = self.fallback.without_state.seconds(f64::NAN, period);
            self.plausible.restart(measurement.time - unseen);
            last = None;
        }
        self.world.elapsed = elapsed(measurement.time, last, period);
        self.world.slew_time = since_last_tick.min(period);
        self.gate
            .open(&self.robot, &self.command, self.world.slew_time);
        let outcome = match self.fault(measurement, last) {
            Some(fault) => {
                if fault.is_of_a_wrench() {
                    self.look(measurement);
                }
                Err(fault)
            }
            None => self.solve(measurement, recorded),
        };
        let mut level = match outcome {
            Ok(None) => FallbackLevel::Optimal,
            Ok(Some(_)) => FallbackLevel::Relaxed,
            Err(_) => self.fall_back(measurement.time, since_last_tick),
        };
        let cut = self.gate.pass(&self.robot, &mut self.command);
        self.world.last.effort.copy_from_slice(&self.command.effort);
        self.report.cut = cut.effort;
        self.report.fault = match outcome {
            Ok(None) => cut.fault(),
            Ok(Some(fault)) | Err(fault) => Some(fault),
        };
        if level == FallbackLevel::Optimal && self.report.fault.is_some() {
            level = FallbackLevel::Relaxed;
        }
        let changed = level != self.fallback.level;
        let is_first = self.fallback.on_level.ticks == 0;
        self.fallback.on_level.step(changed, measurement, last);
        self.fallback.level = level;
        self.report.level = level;
        self.report.on_level = self.fallback.on_level;
        record_outcome(self, changed && !is_first);
    }

    /// What makes a measurement unusable, if anything does: what is wrong with the state before what is wrong with
    /// wrenches. `last` is the time stamp of the last usable state.
    fn fault(&mut self, measurement: &Measurement, last: Option<f64>) -> Option<Fault> {
        let fault = measurement.fault(&self.robot, self.world.contacts.len(), last);
        if fault.is_some_and(|fault| !fault.is_of_a_wrench()) {
            return fault;
        }
        let state = &self.world.state;
        let implausible = self.plausible.fault(measurement, state, last);
        match implausible {
            Some(other) if other.is_of_a_wrench() => fault.or(implausible),
            _ => implausible.or(fault),
        }
    }

    /// Takes the state over from a measurement whose wrenches are not usable, for the law of last resort.
    fn look(&mut self, measurement: &Measurement) {
        self.world.look(measurement, self.fallback.level);
        self.fallback.without_state.renew(measurement.time);
        if !self.first.is_over {
            self.world.origin = None;
        }
    }

    /// From a usable measurement to command and report; with a fault if limits were given up.
    fn solve(
        &mut self,
        measurement: &Measurement,
        recorded: Option<&Record>,
    ) -> Result<Option<Fault>, Fault> {
        let start = self.stopwatch.now();
        if let Some(before) = &mut self.before {
            before.keep_world(&self.world, measurement, self.fallback.level);
        }
        self.world.measure(measurement, self.fallback.level);
        self.report.disturbance = self.world.disturbance();
        self.fallback.without_state.renew(measurement.time);
        let measured = self.stopwatch.now();
        let is_first = !self.first.is_over;
        match recorded {
            None => {
                if is_first {
                    let start = self.settings.start;
                    self.first.begin(start, &self.world, &mut self.plugins);
                }
                self.update_rows();
            }
            Some(record) => recall_rows(self, &record.entries),
        }
        record_rows(self);
        if is_first {
            let tasks = &self.entries[..self.task_count];
            if let Err(fault) = self.first.check(tasks, &mut self.report.tasks) {
                self.world.origin = None;
                return Err(fault);
            }
        }
        let written = self.stopwatch.now();
        let terms = self.world.terms();
        let is_alert = self.fallback.is_alert();
        let assembled = if is_alert {
            // Rows that hold by substitution are part of a contradiction like all others.
            self.problem
                .build_with_all_rows(&terms, &self.entries, &mut self.qp)
        } else {
            self.problem.build(&terms, &self.entries, &mut self.qp)
        };
        let mut built = self.stopwatch.now();
        assembled?;
        let is_proven = is_alert
            && self
                .fallback
                .is_still_infeasible(&self.qp, &mut self.solution);
        if is_alert && !is_proven {
            self.problem.build(&terms, &self.entries, &mut self.qp)?;
            built = self.stopwatch.now();
        }
        if !self.fallback.level.is_solved() {
            // What was active some time ago is no good guess.
            self.solver.reset();
        }
        let budget = match recorded {
            None => Budget::Clock(&mut *self.stopwatch),
            Some(record) => Budget::Iterations(record.outcome.solved_in),
        };
        let status = if is_proven {
            Status::Infeasible
        } else {
            self.solver
                .solve(&self.qp, budget, &mut self.solution)
                .unwrap_or_default()
        };
        if let Some(recorder) = &mut self.recorder {
            recorder.solved_in(self.solution.iterations);
        }
        self.report.status = status;
        self.report.iterations = self.solution.iterations;
        self.report.regularisation = self.problem.regularisation_weight;
        let mut n = self.qp.n();
        let finite = self.solution.x[..n].iter().all(|x| x.is_finite());
        let fault = if status == Status::Optimal && finite {
            self.fallback.calm();
            None
        } else {
            if !status.was_cut_short() && self.problem.has_determined() {
                // Rows that hold by substitution are part of a contradiction like all others, and may be given up.
                self.problem
                    .build_with_all_rows(&terms, &self.entries, &mut self.qp)?;
                self.solution.status = Status::Unsolved;
                n = self.qp.n();
            }
            self.fallback.relaxation.bind_efforts(self.gate.window());
            Some(self.fallback.relax(
                &self.problem,
                &terms,
                &self.entries,
                &self.qp,
                &mut self.solution,
                &mut self.report,
            )?)
        };
        let solved = self.stopwatch.now();
        let x = &self.solution.x[..n];
        self.problem.recover(&self.entries, x);
        let Solved { vdot, effort, .. } = self.problem.solved();
        if !vdot.iter().chain(effort).all(|x| x.is_finite()) {
            self.report.relaxed.clear();
            return Err(Fault::Dynamics);
        }
        let cut = self.gate.first_cut(&self.robot, effort);
        let fault = fault.or(cut.map(|cut| Fault::CutEffort(cut.actuator)));
        let level = match fault {
            None => FallbackLevel::Optimal,
            Some(_) => FallbackLevel::Relaxed,
        };
        let tasks = &self.entries[..self.task_count];
        self.world.remember(&mut self.problem, tasks);
        self.send(level);
        self.report.fill(
            &self.problem,
            &self.entries[..self.task_count],
            &self.world,
            &self.qp,
            &self.solution,
        );
        self.fallback.without_solution.renew(measurement.time);
        let done = self.stopwatch.now();
        self.report.times = StageTimes {
            dynamics: measured - start,
            rows: written - measured,
            assembly: built - written,
            solve: solved - built,
            output: done - solved,
        };
        Ok(fault)
    }

    /// Takes the solution's efforts and velocity references.
    fn send(&mut self, level: FallbackLevel) {
        self.command
            .effort
            .copy_from_slice(&self.problem.solved().effort);
        if self.fallback.level != level || self.fallback.on_level.ticks == 0 {
            // Velocity references start anew from the measured velocities.
            self.command.engage(&self.robot.model, &self.world.state);
        }
        self.command.integrate(
            &self.robot.model,
            &self.world.state,
            self.world.last.vdot.as_slice(),
            self.world.elapsed,
            self.settings.velocity_leak,
        );
    }

    /// A command without a solution.
    fn fall_back(&mut self, time: f64, since_last_tick: f64) -> FallbackLevel {
        let period = self.world.period;
        let age = self.fallback.without_solution.seconds(time, period);
        // Periods do not add up exactly.
        let level = if age <= self.settings.extrapolation + 1e-6 * period {
            FallbackLevel::Extrapolated
        } else {
            FallbackLevel::Safe
        };
        let changed = self.fallback.level != level || self.fallback.on_level.ticks == 0;
        let model = &self.robot.model;
        if level == FallbackLevel::Extrapolated {
            if changed {
                self.command.engage(model, &self.world.state);
            }
            self.command.coast(
                model,
                &self.world.state,
                since_last_tick,
                self.settings.velocity_leak,
            );
            return level;
        }
        let tick = self.world.tick(EntryState::ON);
        if changed {
            self.fallback.law.engage(&tick);
        }
        let age = self.fallback.without_state.seconds(time, period);
        let efforts = &mut self.command.effort;
        self.fallback.law.efforts(&tick, age, efforts);
        for (i, (effort, actuator)) in efforts.iter_mut().zip(&self.robot.actuators).enumerate() {
            if !effort.is_finite() {
                *effort = self.fallback.hover[i];
            }
            let (sent, most) = (tick.last.effort[i], actuator.slew * tick.slew_time);
            let near = effort.max(sent - most).min(sent + most);
            *effort = near.max(actuator.lower).min(actuator.upper);
        }
        self.command.stop_joints();
        level
    }

    /// Lets every live plug-in write its rows.
    fn update_rows(&mut self) {
        self.report.undeclared = None;
        let now = self.world.time;
        let entries = self.entries.iter_mut().zip(&mut self.plugins);
        for (index, (entry, plugin)) in entries.enumerate() {
            let (contact_alpha, contact_live, contact_on) = match entry.layout.contact {
                Some(c) => {
                    let contact = &self.world.contacts[c.index()];
                    let binding = &self.world.bindings[c.index()];
                    (contact.alpha, contact.live, binding.switched_on)
                }
                None => (1.0, true, false),
            };
            if entry.settle(now) || contact_on {
                plugin.plugin.activate();
            }
            entry.live = entry.switch.is_live(now) && contact_live;
            entry.alpha = entry.switch.alpha(now) * contact_alpha;
            if !entry.live {
                continue;
            }
            let state = EntryState {
                alpha: entry.alpha,
                since: entry.switch.since(),
            };
            if let Some(before) = &mut self.before {
                before.keep_plugin(index, plugin);
            }
            plugin.update(&self.world, state, &entry.layout, &mut entry.store);
            if entry.store.undeclared && self.report.undeclared.is_none() {
                self.report.undeclared = Some(index);
            }
        }
        if let Some(before) = &mut self.before {
            before.complete();
        }
    }

    /// The robot.
    pub fn robot(&self) -> &RobotModel {
        &self.robot
    }

    /// Rate, formulation and the other settings.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The last command; before the first tick, the one that comes nearest to holding the home posture.
    pub fn command(&self) -> &Command {
        &self.command
    }

    /// The last report.
    pub fn report(&self) -> &Report {
        &self.report
    }

    /// What the command before the first tick leaves unbalanced, `g − S u` at home, N and N·m. Not zero where
    /// the actuators' limits, or a missing direction of thrust, forbid to hold still.
    pub fn hover_residual(&self) -> &DVector<f64> {
        &self.hover_residual
    }

    /// The problem of the last tick, in physical units.
    pub fn problem(&self) -> &Qp {
        &self.qp
    }

    /// Its solution, in physical units; on the level [`FallbackLevel::Relaxed`] that of the relaxed problem, as far as
    /// it is about the same variables and rows.
    pub fn solution(&self) -> &Solution {
        &self.solution
    }

    /// What the substitution of variables took from row `i` of [`Controller::problem`]: its value, and its limits, as
    /// its owner wrote them are larger by that, in the row's unit.
    pub fn row_constant(&self, i: usize) -> f64 {
        self.problem.constant(i)
    }

    /// A measurement of the right sizes: the home posture at rest at time 0, no force. For drivers to write into.
    pub fn measurement(&self) -> Measurement {
        Measurement::home(&self.robot, self.world.contacts.len())
    }

    /// What a measurement may be: the bounds of the configuration, and those derived from the robot where it says
    /// nothing; of joints and contacts the largest.
    pub fn measurement_limits(&self) -> MeasurementLimits {
        self.plausible.limits()
    }

    /// Name and unit of a row.
    pub fn row(&self, row: RowId) -> Option<&RowInfo> {
        self.table.rows.get(row.index())
    }

    /// Name and unit of a variable.
    pub fn variable(&self, var: VarId) -> Option<&VarInfo> {
        self.table.vars.get(var.index())
    }

    /// Lets stage times be measured.
    pub fn with_stopwatch(mut self, stopwatch: Box<dyn Stopwatch>) -> Self {
        self.stopwatch = stopwatch;
        self
    }
}
