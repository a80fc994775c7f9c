//! A tick, from top to bottom: measurement → kinematics and dynamics → rows of tasks and constraints → quadratic
//! program → solver → command and report.

use super::{
    Command, Controller, FallbackLevel, Measurement, Report,
    fallback::{Moment, Pace, elapsed, is_continuous},
    record::{Record, recall_rows, record_inputs, record_outcome, record_rows},
};
use crate::{
    fault::Fault,
    plugin::EntryState,
    problem::Solved,
    qp::{Budget, Status},
    stopwatch::{StageTimes, Stopwatch},
};

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
    pub(super) fn run(&mut self, measurement: &Measurement, recorded: Option<&Record>) {
        if self.recorder.is_some() {
            record_inputs(self, measurement);
        }
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
        self.report.undeclared = None;
        self.report.times = StageTimes::default();
        self.fallback.is_proven = false;
        self.fallback.without_solution.pass();
        self.fallback.without_state.pass();
        let mut last = self.fallback.without_state.time();
        let period = self.world.period;
        let now = Moment {
            stamp: measurement.time,
            since_last_tick: elapsed(measurement.time, self.fallback.clock.previous, period),
        };
        let clock = &mut self.fallback.clock;
        let pace = Pace {
            period,
            max_gap: self.plausible.gap,
        };
        if clock.was_set(measurement.time, last, pace) {
            self.world.rebase(measurement.time);
            let unseen = self.fallback.without_state.seconds(f64::NAN, period);
            self.plausible.restart(measurement.time - unseen);
            last = None;
        }
        self.world.elapsed = elapsed(measurement.time, last, period);
        self.world.is_continuous = is_continuous(measurement.time, last, period);
        self.world.slew_time = now.since_last_tick.min(period);
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
            Err(fault) => self.fallback.command(
                fault,
                &self.robot,
                &self.settings,
                &self.world,
                now,
                &mut self.command,
            ),
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
        self.fallback.on_level.step(changed, measurement.time, last);
        self.fallback.level = level;
        self.report.level = level;
        self.report.level_since = self.fallback.on_level.since;
        self.report.level_ticks = self.fallback.on_level.ticks;
        if self.recorder.is_some() {
            record_outcome(self, changed && !is_first);
        }
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

    /// Takes the state over from a measurement whose wrenches are not usable, for the fallback law.
    fn look(&mut self, measurement: &Measurement) {
        self.world.look(measurement, self.fallback.level);
        self.report.disturbance = self.world.disturbance();
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
        if self.recorder.is_some() {
            record_rows(self);
        }
        if is_first {
            let tasks = &self.entries[..self.task_count];
            if let Err(fault) = self.first.check(tasks, &mut self.report.tasks) {
                self.world.origin = None;
                return Err(fault);
            }
        }
        let written = self.stopwatch.now();
        self.assemble()?;
        let built = self.stopwatch.now();
        let fault = self.optimise(recorded)?;
        let solved = self.stopwatch.now();
        let x = &self.solution.x[..self.qp.n()];
        self.problem.recover(&self.entries, x);
        let Solved { vdot, effort, .. } = &self.problem.solved;
        if !vdot.iter().chain(effort).all(|x| x.is_finite()) {
            self.report.relaxed.clear();
            return Err(Fault::Dynamics);
        }
        let cut = self.gate.first_cut(&self.robot, effort);
        let fault = fault.or(cut);
        let level = fault.map_or(FallbackLevel::Optimal, |_| FallbackLevel::Relaxed);
        let tasks = &self.entries[..self.task_count];
        self.world.remember(&mut self.problem, tasks);
        self.report
            .fill(&self.problem, tasks, &self.world, &self.qp, &self.solution);
        self.send(level);
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

    /// Builds the problem.
    fn assemble(&mut self) -> Result<(), Fault> {
        let terms = self.world.terms();
        if self.fallback.is_alert() {
            // Rows that hold by substitution are part of a contradiction like all others.
            self.problem
                .build_with_all_rows(&terms, &self.entries, &mut self.qp)
        } else {
            self.problem.build(&terms, &self.entries, &mut self.qp)
        }
    }

    /// The optimum; or, with the fault that made it that, the one with limits given up.
    fn optimise(&mut self, recorded: Option<&Record>) -> Result<Option<Fault>, Fault> {
        let is_alert = self.fallback.is_alert();
        let is_proven = is_alert && self.fallback.prove_again(&self.qp, &mut self.solution);
        if is_alert && !is_proven {
            let terms = self.world.terms();
            self.problem.build(&terms, &self.entries, &mut self.qp)?;
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
        let x = &self.solution.x[..self.qp.n()];
        if status == Status::Optimal && x.iter().all(|x| x.is_finite()) {
            self.fallback.calm();
            return Ok(None);
        }
        self.fallback.relaxation.bind_efforts(&self.gate.window);
        let fault = self.fallback.relax(
            &mut self.problem,
            &self.world.terms(),
            &self.entries,
            &mut self.qp,
            &mut self.solution,
            &mut self.report,
        )?;
        Ok(Some(fault))
    }

    /// Takes the solution's efforts and velocity references.
    fn send(&mut self, level: FallbackLevel) {
        self.command
            .effort
            .copy_from_slice(&self.problem.solved.effort);
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

    /// Lets every live plug-in write its rows.
    fn update_rows(&mut self) {
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
}

impl Controller {
    /// Lets stage times be measured.
    pub fn with_stopwatch(mut self, stopwatch: Box<dyn Stopwatch>) -> Self {
        self.stopwatch = stopwatch;
        self
    }
}

/// No clock: all stage times are zero.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct NoStopwatch;

impl Stopwatch for NoStopwatch {
    fn now(&mut self) -> f64 {
        0.0
    }
}
