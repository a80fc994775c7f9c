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

use nalgebra::{Vector3, Vector6};
use wbqp::{
    actuator::{ActuatorKind, Drive},
    contact::{Detector, Touch},
    controller::{Command, Controller, Measurement, Rung, Stopwatch},
    log::{
        ControllerLog, LogSink, Timeline, TrueContact, state_message, state_schema, write_rotors,
        write_run,
    },
    robot::RobotModel,
};

use crate::{
    CommandDelay, Plant, PlantCommand,
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
}

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
    let case = scenario.case(case)?;
    let config = case.controller_config()?;
    let source = config.source.clone();
    let controller = case.make_controller(config)?;
    let mut controller = controller.with_stopwatch(Box::new(WallClock(Instant::now())));
    let robot = controller.robot().clone();
    let mut plant = case.make_plant(&robot)?;
    let mut sensors = case.make_sensors(&plant, seed)?;
    let contacts = Contacts::new(case, &controller);

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
    let mut log = ControllerLog::new(&controller, sink)?;
    let truth_channel = sink.channel("/plant", "PlantState", &state_schema(&robot.model))?;
    let mut message = Vec::new();
    let mut truth = vec![None; contacts.sensors.len()];
    let mut timeline = disturbance_marks(case);

    let mut measurement = Measurement::home(&robot, contacts.sensors.len());
    let mut computed = PlantCommand::rest(&robot);
    write_command(&robot, controller.command(), &mut computed);
    plant.settle_rotors(&computed)?;
    let mut delay = CommandDelay::new(case.plant().command_delay, computed.clone());
    let mut detectors: Vec<Detector> = case.detectors().to_vec();
    let mut events: Vec<_> = case.events().iter().collect();
    events.sort_by(|a, b| a.at.total_cmp(&b.at));
    let mut events = events.into_iter().peekable();

    let period = 1.0 / controller.settings().rate;
    let ticks = case.ticks(controller.settings().rate);
    let mut summary = Summary::default();
    for k in 0..ticks {
        if k % (ticks / 100).max(1) == 0 {
            progress(k as f64 / ticks as f64);
        }
        let reading = sensors.sample(&plant);
        measurement.time = k as f64 * period;
        measurement.state.copy_from(&reading.state);
        contacts.copy_wrenches(&reading.wrenches, &mut measurement.wrenches);
        // A little slack: k × period is not exact.
        while let Some(event) = events.next_if(|e| e.at <= measurement.time + 1e-6 * period) {
            event
                .apply(&mut controller)
                .map_err(|what| RunError::Event { at: event.at, what })?;
            if let Some(mark) = &event.mark {
                timeline = timeline.mark(mark, measurement.time);
            }
        }
        let (command, report) = controller.tick(&measurement);
        write_command(&robot, command, &mut computed);
        summary.ticks += 1;
        summary.held += usize::from(report.rung != Rung::Optimal);
        detect(&mut detectors, &mut controller, &measurement);

        contacts.truth(&plant, &controller, &mut truth);
        log.record(&controller, &measurement, &truth, sink)?;
        state_message(&robot.model, plant.state(), &mut message);
        sink.write(truth_channel, measurement.time, &message)?;

        let applied = delay.exchange(&computed);
        plant.advance_with(applied, period, |plant| sensors.observe(plant))?;
        if plant.is_diverged() {
            summary.diverged = Some(plant.time());
            break;
        }
    }
    timeline.write(sink)?;
    progress(1.0);
    Ok(summary)
}

/// Switches contacts by the force measured in this tick; it counts from the next tick on.
fn detect(detectors: &mut [Detector], controller: &mut Controller, measurement: &Measurement) {
    for detector in detectors {
        // Names were checked when the scenario was loaded.
        let Ok(contact) = controller.contact(&detector.contact) else {
            continue;
        };
        let normal = controller.report().contacts[contact.index()].measured[2];
        let _ = match detector.update(measurement.time, normal) {
            Some(Touch::Made) => controller.activate_contact(&detector.contact),
            Some(Touch::Lost) => controller.deactivate_contact(&detector.contact),
            None => Ok(()),
        };
    }
}

/// Which sensor and which point of the plant belong to each of the controller's contacts.
struct Contacts {
    sensors: Vec<Option<usize>>,
    points: Vec<String>,
}

impl Contacts {
    fn new(case: &Case, controller: &Controller) -> Self {
        let frames: Vec<String> = controller
            .contact_names()
            .filter_map(|name| controller.contact(name).ok())
            .map(|id| controller.contact_spec(id).frame.clone())
            .collect();
        let sensor_of = |frame: &String| {
            let sensors = &case.sensors().force_torque;
            sensors.iter().position(|s| &s.frame == frame)
        };
        Self {
            sensors: frames.iter().map(sensor_of).collect(),
            points: frames,
        }
    }

    fn copy_wrenches(&self, readings: &[Vector6<f64>], out: &mut [Vector6<f64>]) {
        for (sensor, out) in self.sensors.iter().zip(out) {
            *out = sensor.map_or_else(Vector6::zeros, |s| readings[s]);
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

/// Thrusts, torques, or velocity references, by what each actuator takes.
fn write_command(robot: &RobotModel, command: &Command, out: &mut PlantCommand) {
    for (i, (actuator, out)) in robot.actuators.iter().zip(out.values_mut()).enumerate() {
        *out = match &actuator.kind {
            ActuatorKind::Joint(motor) if motor.drive == Drive::Velocity => {
                command.joint_velocity[motor.joint.index()]
            }
            _ => command.effort[i],
        };
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
