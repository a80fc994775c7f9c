//! The controller: bind once, then tick.
//!
//! A tick is measurement → kinematics and dynamics → rows of tasks and constraints → quadratic program →
//! solver → command and report. No step looks back, and nothing is allocated after
//! [`Controller::new`] except inside a solver that needs it.

pub(crate) mod bind;
mod command;
mod error;
mod faults;
mod hover;
mod measurement;
mod rehearsal;
mod report;
mod requests;
mod stopwatch;
pub(crate) mod switch;
pub(crate) mod world;

pub use command::Command;
pub use error::{ControllerError, RequestError};
pub use measurement::{Fault, Measurement, Quantity};
pub use rehearsal::PlannedForce;
pub use report::{ActiveRow, ContactReport, Report, Rung, Side, TaskReport};
pub use stopwatch::{NoStopwatch, StageTimes, Stopwatch};

use nalgebra::DVector;

use crate::{
    assembly::{Actuation, Assembly, Group, RowInfo, Table, VarInfo},
    config::Settings,
    constraint::Constraint,
    qp::{Qp, QpSolver, RowId, Solution, Status, VarId},
    robot::RobotModel,
    rows::{ConstraintRows, Rows},
    task::Task,
    tick::EntryState,
};
use world::World;

/// A whole-body controller bound to a robot.
///
/// Made by [`Controller::new`]; [`Controller::tick`] is the real-time part. Switching, replacing references and
/// changing weights happen between ticks.
#[derive(Debug)]
pub struct Controller {
    settings: Settings,
    robot: RobotModel,
    tasks: Vec<Box<dyn Task>>,
    constraints: Vec<Box<dyn Constraint>>,
    /// One per task, then one per constraint.
    groups: Vec<Group>,
    table: Table,
    assembly: Assembly,
    actuation: Actuation,
    qp: Qp,
    solution: Solution,
    solver: Box<dyn QpSolver>,
    world: World,
    command: Command,
    report: Report,
    /// Whether a tick has produced a command yet.
    engaged: bool,
    hover_residual: DVector<f64>,
    stopwatch: Box<dyn Stopwatch>,
}

impl Controller {
    /// One control period: from a measurement to a command.
    ///
    /// Always returns a command. If the measurement is unusable or the solver fails, it is the last one, and
    /// the report says so. Does not allocate (unless the solver does), lock, block or read a clock.
    pub fn tick(&mut self, measurement: &Measurement) -> (&Command, &Report) {
        self.report.time = measurement.time;
        self.report.active.clear();
        self.report.status = Status::Failed;
        self.report.iterations = 0;
        self.report.objective = 0.0;
        self.report.times = StageTimes::default();
        let fault = measurement.fault(&self.robot, self.world.contacts.len());
        let fault = fault.or_else(|| self.solve(measurement).err());
        self.report.fault = fault;
        if fault.is_some() {
            // Velocity references start anew from the measured velocities once there is a solution again.
            self.engaged = false;
        }
        self.report.rung = if fault.is_none() {
            Rung::Optimal
        } else {
            Rung::Held
        };
        (&self.command, &self.report)
    }

    fn solve(&mut self, measurement: &Measurement) -> Result<(), Fault> {
        let start = self.stopwatch.now();
        self.world.measure(measurement);
        let measured = self.stopwatch.now();
        self.update_rows();
        let written = self.stopwatch.now();
        let terms = Self::terms(&self.world);
        let assembled = self
            .assembly
            .assemble(&terms, &mut self.groups, &mut self.qp);
        let built = self.stopwatch.now();
        assembled?;
        self.solver.solve(&self.qp, &mut self.solution);
        let solved = self.stopwatch.now();
        self.report.status = self.solution.status;
        self.report.iterations = self.solution.iterations;
        self.report.regularisation = self.assembly.regularisation_weight;
        let n = self.qp.n();
        let finite = self.solution.x[..n].iter().all(|x| x.is_finite());
        if !(self.solution.status.is_usable() && finite) {
            return Err(Fault::Solver);
        }
        self.output();
        let done = self.stopwatch.now();
        self.report.times = StageTimes {
            dynamics: measured - start,
            rows: written - measured,
            assembly: built - written,
            solve: solved - built,
            output: done - solved,
        };
        Ok(())
    }

    /// Lets every live plug-in write its rows.
    fn update_rows(&mut self) {
        self.report.undeclared = None;
        let now = self.world.time;
        for (index, group) in self.groups.iter_mut().enumerate() {
            let (contact_alpha, contact_live, contact_on) = match group.layout.contact {
                Some(c) => {
                    let contact = &self.world.contacts[c.index()];
                    let binding = &self.world.bindings[c.index()];
                    (contact.alpha, contact.live, binding.switched_on)
                }
                None => (1.0, true, false),
            };
            if group.settle(now) || contact_on {
                match self.tasks.get_mut(index) {
                    Some(task) => task.activate(),
                    None => self.constraints[index - self.tasks.len()].activate(),
                }
            }
            group.live = group.switch.is_live(now) && contact_live;
            group.alpha = group.switch.alpha(now) * contact_alpha;
            if !group.live {
                continue;
            }
            let tick = self.world.tick(EntryState {
                alpha: group.alpha,
                since: group.switch.since(),
            });
            match self.tasks.get_mut(index) {
                Some(task) => task.update(&tick, &mut Rows::new(&group.layout, &mut group.store)),
                None => self.constraints[index - self.tasks.len()].update(
                    &tick,
                    &mut ConstraintRows::new(&group.layout, &mut group.store),
                ),
            }
            if group.store.undeclared && self.report.undeclared.is_none() {
                self.report.undeclared = Some(index);
            }
        }
    }

    /// Turns the solution into command and report.
    fn output(&mut self) {
        let x = &self.solution.x[..self.qp.n()];
        let terms = Self::terms(&self.world);
        self.assembly.recover(&self.groups, &terms, x);
        self.world.last.vdot.copy_from_slice(self.assembly.vdot());
        self.report.vdot.copy_from(&self.world.last.vdot);
        let tasks = &self.groups[..self.tasks.len()];
        for (column, asked) in self.world.last.virtual_input.iter_mut().enumerate() {
            *asked = Group::virtual_input(tasks, column);
        }
        self.command
            .take_efforts(&self.robot, self.assembly.effort());
        self.world.last.effort.copy_from_slice(&self.command.effort);
        if !self.engaged {
            self.command.engage(&self.robot.model, &self.world.state);
            self.engaged = true;
        }
        self.command.integrate(
            &self.robot.model,
            &self.world.state,
            self.world.last.vdot.as_slice(),
            self.world.period,
            self.settings.velocity_leak,
        );
        for (i, contact) in self.world.contacts.iter_mut().enumerate() {
            contact.solution.fill(0.0);
            contact.set_point.fill(0.0);
            if let Some(force) = self.assembly.force(i) {
                for (&direction, f) in contact.kind.constrained().iter().zip(force) {
                    contact.solution[direction] = *f;
                }
            }
            self.report.contacts[i] = ContactReport {
                on: self.world.bindings[i].switch.is_on(),
                alpha: contact.alpha,
                task: None,
                solution: contact.solution,
                measured: contact.measured,
                position: contact.p_SC,
            };
        }
        self.report.objective = self.assembly.objective();
        self.report_tasks();
        self.report_active();
    }

    fn report_tasks(&mut self) {
        for ((group, task), report) in self
            .groups
            .iter()
            .zip(&self.tasks)
            .zip(&mut self.report.tasks)
        {
            report.alpha = if group.live { group.alpha } else { 0.0 };
            let residuals = if group.live {
                self.assembly.residuals(group)
            } else {
                None
            };
            for k in 0..group.layout.len() {
                let [r, w] = residuals.map_or([0.0; 2], |residuals| residuals[k]);
                report.error[k] = if group.live {
                    group.store.error[k]
                } else {
                    0.0
                };
                report.residual[k] = r;
                report.cost[k] = w * r * r;
            }
            if let (true, Some(force)) = (group.live, task.force_report())
                && let Some(contact) = self.report.contacts.get_mut(force.contact.index())
                && let Some(state) = self.world.contacts.get_mut(force.contact.index())
            {
                contact.task = Some(force);
                state.set_point = force.reference;
            }
        }
    }

    /// Collects inequality rows and bounds at a limit that have a multiplier.
    fn report_active(&mut self) {
        let qp = &self.qp;
        let Solution { x, y, z, .. } = &self.solution;
        let scale = qp.g().iter().fold(1.0_f64, |a, g| a.max(g.abs()));
        let is_active = |distance: f64, limit: f64, multiplier: f64| {
            distance <= 1e-6 * (1.0 + limit.abs()) && multiplier.abs() > 1e-9 * scale
        };
        for (i, &row) in qp.rows().iter().enumerate() {
            let (lower, upper) = (qp.row_lower()[i], qp.row_upper()[i]);
            if lower == upper {
                continue;
            }
            let ax: f64 = qp.row(i).iter().zip(x).map(|(a, x)| a * x).sum();
            let (side, limit) = near(ax, lower, upper);
            if is_active((ax - limit).abs(), limit, y[i]) {
                self.report.active.push(ActiveRow {
                    row,
                    side,
                    multiplier: y[i],
                });
            }
        }
        for j in 0..qp.n() {
            let (side, limit) = near(x[j], qp.lower()[j], qp.upper()[j]);
            let owner = self.assembly.bound_owner[j][usize::from(side == Side::Upper)];
            if let Some(row) = owner
                && is_active((x[j] - limit).abs(), limit, z[j])
            {
                self.report.active.push(ActiveRow {
                    row,
                    side,
                    multiplier: z[j],
                });
            }
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

    /// Its solution, in physical units.
    pub fn solution(&self) -> &Solution {
        &self.solution
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

/// The nearer limit and its side.
fn near(value: f64, lower: f64, upper: f64) -> (Side, f64) {
    if (value - lower).abs() < (upper - value).abs() {
        (Side::Lower, lower)
    } else {
        (Side::Upper, upper)
    }
}
