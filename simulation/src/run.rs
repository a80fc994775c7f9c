//! Runs one case of a scenario: sample, tick, log, advance.
//!
//! # Notation
//! C is a contact's surface frame; `R_WC` turns its axes into the world's.
//!
//! At every period `t_k` the sensors are sampled, events that are due are applied, the controller ticks, and
//! its command reaches the plant after the configured delay and is held for a period. The controller sees
//! nothing of the plant but the sensors.
#![allow(non_snake_case)]

use std::time::Instant;

use serde::Serialize;
use wbqp::{
    controller::{Controller, FallbackLevel, Snapshot},
    robot::SourceFile,
    stopwatch::Stopwatch,
};
use wbqp_log::{
    ChannelId, ControllerLog, LogSink, Timeline, TrueContact, state_schema, write_diagnostics,
    write_rotors, write_run, write_state,
};
use wbqp_replay::DumpError;

use crate::{
    Link, PlantCommand, Requests, RunOptions, World,
    closed_loop::settled_plant,
    plant::divergence,
    scenario::{Case, RunError, Scenario, ScenarioError},
};

/// How a run ended.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    /// Control periods that were run.
    pub ticks: usize,
    /// Ticks whose command was not that tick's optimum.
    pub held: usize,
    /// The first of these.
    pub first_held: Option<Held>,
    /// Time at which the plant diverged, s, if it did.
    pub diverged: Option<f64>,
    /// Why there was no use in going on then, in words.
    pub divergence: Option<&'static str>,
    /// How long the plant was in steps that could not get as short as its tolerance asks for, s.
    pub beyond_tolerance: f64,
    /// A task or constraint that wrote coefficients which its layout does not declare, and which do nothing.
    pub undeclared: Option<String>,
    /// Where the last tick's command came from.
    pub last_level: FallbackLevel,
    /// Why it was not that tick's optimum, in words.
    pub why: Option<String>,
}

/// A tick whose command was not its optimum.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Held {
    /// When, s.
    pub time: f64,
    /// Why, in words.
    pub why: String,
}

/// Ticks that a dump holds.
const RECORDED_TICKS: usize = 8;

/// Runs a case and logs it. `progress` hears the finished fraction, 0 to 1, about a hundred times.
///
/// # Errors
/// [`RunError`] if the scenario, the log or the plant refuses. Divergence is not an error but in the summary.
pub fn run(
    scenario: &Scenario,
    case: &str,
    seed: u64,
    sink: &mut dyn LogSink,
    progress: &mut dyn FnMut(f64),
) -> Result<Summary, RunError> {
    let options = RunOptions {
        progress: Some(progress),
        ..RunOptions::default()
    };
    run_with(scenario, case, seed, sink, options)
}

/// Like [`run()`], with options: dumps of the ticks before a change of the level, and whoever follows the run.
///
/// # Errors
/// Those of [`run()`], of a dump that cannot be written and of whoever follows.
pub fn run_with(
    scenario: &Scenario,
    case: &str,
    seed: u64,
    sink: &mut dyn LogSink,
    options: RunOptions<'_>,
) -> Result<Summary, RunError> {
    run_case(scenario, scenario.case(case)?, seed, sink, options)
}

/// Like [`run_with`], for a case of the scenario that is not as the scenario has it: of
/// [`Scenario::varied_case`](crate::Scenario::varied_case).
///
/// # Errors
/// Those of [`run_with`].
pub fn run_case(
    scenario: &Scenario,
    case: &Case,
    seed: u64,
    sink: &mut dyn LogSink,
    mut options: RunOptions<'_>,
) -> Result<Summary, RunError> {
    let (mut controller, source) = CaseRun::controller(case)?;
    if options.dumps.is_some() {
        controller = controller
            .with_recorder(RECORDED_TICKS)
            .map_err(DumpError::from)?;
    }
    let mut plant = settled_plant(case, &controller)?;
    let mut run = CaseRun::new(scenario, case, (controller, source), seed, &plant, sink)?;
    run.begin(sink, &mut options)?;
    let mut due = run.link.computed().clone();
    let ticks = run.ticks();
    while !run.is_over() {
        let done = run.summary.ticks;
        if done.is_multiple_of((ticks / 100).max(1)) {
            options.tell(done as f64 / ticks as f64);
        }
        run.tick(&plant, sink, &mut options)?;
        run.exchange(&mut due);
        plant.advance_with(&due, run.period(), |plant| run.observe(plant))?;
        run.note_divergence(&plant);
    }
    let mut summary = run.finish(sink)?;
    summary.beyond_tolerance = plant.beyond_tolerance();
    options.tell(1.0);
    Ok(summary)
}

/// One case of a scenario whose world somebody else moves: sample, events, tick, log, as in [`run()`].
///
/// Every period is [`CaseRun::tick`], [`CaseRun::exchange`] for the command that is due, and then integration steps of
/// the world with [`CaseRun::observe`] after each.
#[derive(Debug)]
pub struct CaseRun {
    controller: Controller,
    link: Link,
    requests: Requests,
    contacts: Contacts,
    log: ControllerLog,
    snapshot: Snapshot,
    truth_channel: ChannelId,
    message: Vec<u8>,
    truth: Vec<Option<TrueContact>>,
    timeline: Timeline,
    ticks: usize,
    summary: Summary,
}

impl CaseRun {
    /// The controller of a case, with a stopwatch, and the file that it was read from.
    ///
    /// # Errors
    /// A configuration that is refused.
    pub fn controller(case: &Case) -> Result<(Controller, Option<SourceFile>), ScenarioError> {
        let config = case.controller_config()?;
        let source = config.source.clone();
        let controller = case.make_controller(config)?;
        let clock = Box::new(WallClock(Instant::now()));
        Ok((controller.with_stopwatch(clock), source))
    }

    /// At time 0; what is to be known of the run goes into the log. The world has the controller's robot in the case's
    /// initial state.
    ///
    /// # Errors
    /// [`RunError`] if scenario or log refuse.
    pub fn new(
        scenario: &Scenario,
        case: &Case,
        (controller, source): (Controller, Option<SourceFile>),
        seed: u64,
        world: &dyn World,
        sink: &mut dyn LogSink,
    ) -> Result<Self, RunError> {
        let link = Link::new(case, &controller, world, seed)?;
        let robot = controller.robot();
        write_run(
            sink,
            seed,
            std::iter::once(scenario.source())
                .chain(&case.variation().source())
                .chain(&source)
                .chain(&robot.sources),
        )?;
        let names = [("name", scenario.name()), ("case", case.name())];
        let names = names.map(|(key, value)| (key.to_owned(), value.to_owned()));
        sink.metadata("scenario", &names.into())?;
        write_rotors(sink, robot)?;
        write_diagnostics(sink, robot)?;
        let log = ControllerLog::new(&controller, sink)?;
        let truth_channel = sink.channel("/plant", "PlantState", &state_schema(&robot.model))?;
        let contacts = Contacts::new(&controller);
        let rate = controller.settings().rate;
        Ok(Self {
            link,
            requests: Requests::new(case, rate),
            log,
            snapshot: controller.snapshot(),
            truth_channel,
            message: Vec::new(),
            truth: vec![None; contacts.points.len()],
            contacts,
            timeline: disturbance_marks(case),
            ticks: case.ticks(rate),
            summary: Summary::default(),
            controller,
        })
    }

    /// Before the first tick: lets those who follow the run open their channels.
    ///
    /// # Errors
    /// What one of them refuses.
    pub fn begin(
        &self,
        sink: &mut dyn LogSink,
        options: &mut RunOptions<'_>,
    ) -> Result<(), RunError> {
        for watcher in &mut options.watchers {
            watcher.begin(&self.controller, sink)?;
        }
        Ok(())
    }

    /// One control period: samples the sensors, applies events that are due, ticks, logs.
    ///
    /// # Errors
    /// An event that is refused, a log or a dump that cannot be written.
    pub fn tick(
        &mut self,
        world: &dyn World,
        sink: &mut dyn LogSink,
        options: &mut RunOptions<'_>,
    ) -> Result<(), RunError> {
        let Self {
            controller,
            link,
            summary,
            ..
        } = self;
        let measurement = link.measure(world);
        while let Some(event) = self.requests.due(measurement.time) {
            event
                .apply(controller)
                .map_err(|what| RunError::Event { at: event.at, what })?;
            if let Some(mark) = &event.mark {
                self.timeline = std::mem::take(&mut self.timeline).mark(mark, measurement.time);
            }
        }
        let (_, report) = controller.tick(measurement);
        summary.ticks += 1;
        summary.held += usize::from(report.level != FallbackLevel::Optimal);
        summary.last_level = report.level;
        if summary.first_held.is_none()
            && let Some(why) = report.explain()
        {
            let time = measurement.time;
            summary.first_held = Some(Held { time, why });
        }
        if let Some(index) = report.undeclared
            && summary.undeclared.is_none()
        {
            summary.undeclared = controller.entry_names().nth(index).map(str::to_owned);
        }
        self.requests.detect(controller, measurement);
        if let Some(dumps) = &mut options.dumps {
            dumps.write_if_changed(controller)?;
        }
        let time = measurement.time;
        self.contacts.truth(world, controller, &mut self.truth);
        self.snapshot.take(controller, link.measurement());
        self.log.record(&self.snapshot, &self.truth, sink)?;
        let model = &controller.robot().model;
        let message = (self.truth_channel, time);
        write_state(sink, message, &mut self.message, model, world.state())?;
        for watcher in &mut options.watchers {
            watcher.after_tick(&mut self.controller, &self.snapshot, &self.truth, sink)?;
        }
        Ok(())
    }

    /// After a tick: the command that is due for the next period, which is an earlier one where commands are delayed.
    pub fn exchange(&mut self, due: &mut PlantCommand) {
        self.link.exchange(self.controller.command(), due);
    }

    /// Lets the sensors' filters follow the world. To be called after every integration step.
    pub fn observe(&mut self, world: &dyn World) {
        self.link.observe(world);
    }

    /// After a period: a world that has diverged ends the run.
    pub fn note_divergence(&mut self, world: &dyn World) {
        if world.is_diverged() {
            self.summary.diverged = Some(world.time());
            // Where the state is as it should be, what moves it is not.
            let rates = "forces on the simulated robot, or its accelerations, are not finite";
            self.summary.divergence = divergence(world.state()).or(Some(rates));
        }
    }

    /// Whether every period was run, or the world has diverged.
    pub fn is_over(&self) -> bool {
        self.summary.diverged.is_some() || self.summary.ticks >= self.ticks
    }

    /// Control periods of the whole run.
    pub fn ticks(&self) -> usize {
        self.ticks
    }

    /// The controller's period, s.
    pub fn period(&self) -> f64 {
        self.link.period()
    }

    /// The command at the start: the controller's hover command.
    pub fn first_command(&self) -> &PlantCommand {
        self.link.computed()
    }

    /// What there is to be told so far.
    pub fn summary(&self) -> &Summary {
        &self.summary
    }

    /// Ends the run and its log.
    ///
    /// # Errors
    /// A log that cannot be written.
    pub fn finish(mut self, sink: &mut dyn LogSink) -> Result<Summary, RunError> {
        self.timeline.write(sink)?;
        self.summary.why = self.controller.explain();
        Ok(self.summary)
    }
}

/// Which point of the plant belongs to each of the controller's contacts.
#[derive(Debug)]
struct Contacts {
    points: Vec<String>,
}

impl Contacts {
    fn new(controller: &Controller) -> Self {
        let names = controller.contact_names();
        let contacts = names.filter_map(|name| controller.contact(name).ok());
        Self {
            points: contacts
                .map(|id| controller.contact_spec(id).frame.clone())
                .collect(),
        }
    }

    /// The real force and place of each contact; nothing where the plant has no such point or no wall.
    fn truth(&self, world: &dyn World, controller: &Controller, out: &mut [Option<TrueContact>]) {
        let names = controller.contact_names();
        for ((frame, name), out) in self.points.iter().zip(names).zip(out) {
            let contact = controller.contact(name).ok();
            *out = contact
                .zip(world.contact_at(frame))
                .map(|(id, (force_W, p_WC))| {
                    let contact = controller.contact_state(id);
                    let R_CW = contact.R_WC.inverse();
                    TrueContact {
                        force: R_CW * force_W,
                        position: R_CW * (p_WC - contact.p_WS),
                    }
                });
        }
    }
}

/// `<name>_start` and `<name>_end` of every disturbance; of several with one name, the first's.
fn disturbance_marks(case: &Case) -> Timeline {
    let disturbances = case.plant().disturbances.iter().rev();
    disturbances.fold(Timeline::default(), |timeline, d| {
        timeline
            .mark(&format!("{}_start", d.name), d.from)
            .mark(&format!("{}_end", d.name), d.until)
    })
}

/// The clock of the stage times in the log.
#[derive(Debug)]
struct WallClock(Instant);

impl Stopwatch for WallClock {
    fn now(&mut self) -> f64 {
        self.0.elapsed().as_secs_f64()
    }
}
