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

use nalgebra::Vector3;
use wbqp::{
    controller::{Controller, FallbackLevel},
    replay::{DumpError, DumpFolder},
    stopwatch::Stopwatch,
};
use wbqp_log::{
    ControllerLog, LogSink, Timeline, TrueContact, state_message, state_schema, write_diagnostics,
    write_rotors, write_run,
};

use crate::{
    ClosedLoop, Plant, Requests,
    scenario::{Case, RunError, Scenario},
};

/// How a run ended.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    /// Control periods that were run.
    pub ticks: usize,
    /// Ticks whose command was not that tick's optimum.
    pub held: usize,
    /// Time at which the plant diverged, s, if it did.
    pub diverged: Option<f64>,
    /// Where the last tick's command came from.
    pub last_level: FallbackLevel,
    /// Why it was not that tick's optimum, in words.
    pub why: Option<String>,
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
    run_case(scenario, case, seed, sink, progress, None)
}

/// Like [`run()`]; the ticks before a change of the level are written into files, for `replay`.
///
/// # Errors
/// Those of [`run()`], and [`RunError::Dump`].
pub fn run_with_dumps(
    scenario: &Scenario,
    case: &str,
    seed: u64,
    sink: &mut dyn LogSink,
    progress: &mut dyn FnMut(f64),
    dumps: &mut DumpFolder,
) -> Result<Summary, RunError> {
    run_case(scenario, case, seed, sink, progress, Some(dumps))
}

fn run_case(
    scenario: &Scenario,
    case: &str,
    seed: u64,
    sink: &mut dyn LogSink,
    progress: &mut dyn FnMut(f64),
    mut dumps: Option<&mut DumpFolder>,
) -> Result<Summary, RunError> {
    let case = scenario.case(case)?;
    let config = case.controller_config()?;
    let source = config.source.clone();
    let controller = case.make_controller(config)?;
    let mut controller = controller.with_stopwatch(Box::new(WallClock(Instant::now())));
    if dumps.is_some() {
        controller = controller
            .with_recorder(RECORDED_TICKS)
            .map_err(DumpError::from)?;
    }
    let robot = controller.robot().clone();
    let mut closed_loop = ClosedLoop::new(case, &controller, seed)?;
    let mut requests = Requests::new(case, controller.settings().rate);
    let contacts = Contacts::new(&controller);

    write_run(
        sink,
        seed,
        std::iter::once(scenario.source())
            .chain(&scenario.variation().source())
            .chain(&source)
            .chain(&robot.sources),
    )?;
    let names = [("name", scenario.name()), ("case", case.name())];
    let names = names.map(|(key, value)| (key.to_owned(), value.to_owned()));
    sink.metadata("scenario", &names.into())?;
    write_rotors(sink, &robot)?;
    write_diagnostics(sink, &robot)?;
    let mut log = ControllerLog::new(&controller, sink)?;
    let truth_channel = sink.channel("/plant", "PlantState", &state_schema(&robot.model))?;
    let mut message = Vec::new();
    let mut truth = vec![None; contacts.points.len()];
    let mut timeline = disturbance_marks(case);

    let ticks = case.ticks(controller.settings().rate);
    let mut summary = Summary::default();
    for k in 0..ticks {
        if k % (ticks / 100).max(1) == 0 {
            progress(k as f64 / ticks as f64);
        }
        let measurement = closed_loop.measure();
        while let Some(event) = requests.due(measurement.time) {
            event
                .apply(&mut controller)
                .map_err(|what| RunError::Event { at: event.at, what })?;
            if let Some(mark) = &event.mark {
                timeline = timeline.mark(mark, measurement.time);
            }
        }
        let (_, report) = controller.tick(measurement);
        summary.ticks += 1;
        summary.held += usize::from(report.level != FallbackLevel::Optimal);
        summary.last_level = report.level;
        requests.detect(&mut controller, measurement);
        if let Some(dumps) = &mut dumps {
            dumps.write_if_changed(&mut controller)?;
        }

        let time = measurement.time;
        contacts.truth(closed_loop.plant(), &controller, &mut truth);
        log.record(&controller, closed_loop.measurement(), &truth, sink)?;
        state_message(&robot.model, closed_loop.plant().state(), &mut message);
        sink.write(truth_channel, time, &message)?;

        closed_loop.advance(controller.command())?;
        let plant = closed_loop.plant();
        if plant.is_diverged() {
            summary.diverged = Some(plant.time());
            break;
        }
    }
    timeline.write(sink)?;
    progress(1.0);
    summary.why = controller.explain().map(|why| why.to_string());
    Ok(summary)
}

/// Which point of the plant belongs to each of the controller's contacts.
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
    fn truth(&self, plant: &Plant, controller: &Controller, out: &mut [Option<TrueContact>]) {
        let names = controller.contact_names();
        for ((frame, name), out) in self.points.iter().zip(names).zip(out) {
            let at_frame = || {
                let contacts = plant.contacts();
                contacts.filter(|(point, _, _)| &point.frame == frame)
            };
            let force_W: Vector3<f64> = at_frame().map(|(_, _, truth)| truth.force_W).sum();
            let p_WC = at_frame().map(|(_, _, truth)| truth.p_WC).next();
            *out = controller.contact(name).ok().zip(p_WC).map(|(id, p_WC)| {
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
