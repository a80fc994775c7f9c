//! One case of a scenario period by period, for whoever brings a controller: what [`run`](crate::run()) does, without
//! the log.

use nalgebra::Vector6;
use wbqp::{
    contact::{ContactEvent, Detector},
    controller::{Command, Controller, Measurement},
    robot::RobotModel,
};

use crate::{
    CommandDelay, Plant, PlantCommand, PlantError, Sensors,
    scenario::{Case, Event, ScenarioError},
};

/// The plant and the sensors of a case: [`ClosedLoop::measure`], the controller's tick, [`ClosedLoop::advance`].
///
/// The controller sees nothing of the plant but the sensors.
#[derive(Debug)]
pub struct ClosedLoop {
    robot: RobotModel,
    plant: Plant,
    sensors: Sensors,
    delay: CommandDelay,
    measurement: Measurement,
    computed: PlantCommand,
    /// Which force-torque sensor belongs to each of the controller's contacts.
    contact_sensors: Vec<Option<usize>>,
    period: f64,
    tick: usize,
}

impl ClosedLoop {
    /// At time 0, with rotors at the controller's hover command. `seed` is the noise's.
    ///
    /// # Errors
    /// What plant and sensors refuse.
    pub fn new(case: &Case, controller: &Controller, seed: u64) -> Result<Self, ScenarioError> {
        let robot = controller.robot().clone();
        let mut plant = case.make_plant(&robot)?;
        let sensors = case.make_sensors(&plant, seed)?;
        let sensor_of = |frame: &str| {
            let sensors = &case.sensors().force_torque;
            sensors.iter().position(|s| s.frame == frame)
        };
        let contacts = controller.contact_names();
        let contact_sensors: Vec<_> = contacts
            .filter_map(|name| controller.contact(name).ok())
            .map(|id| sensor_of(&controller.contact_spec(id).frame))
            .collect();
        let computed = PlantCommand::of(&robot, controller.command());
        plant
            .settle_rotors(&computed)
            .map_err(|e| case.plant_error("plant", e))?;
        Ok(Self {
            delay: CommandDelay::new(case.plant().command_delay, computed.clone()),
            measurement: Measurement::home(&robot, contact_sensors.len()),
            period: 1.0 / controller.settings().rate,
            tick: 0,
            robot,
            plant,
            sensors,
            computed,
            contact_sensors,
        })
    }

    /// What the sensors say now; draws new noise.
    pub fn measure(&mut self) -> &Measurement {
        let reading = self.sensors.sample(&self.plant);
        let m = &mut self.measurement;
        m.time = self.tick as f64 * self.period;
        m.state.copy_from(&reading.state);
        for (sensor, out) in self.contact_sensors.iter().zip(&mut m.wrenches) {
            *out = sensor.map_or_else(Vector6::zeros, |s| reading.wrenches[s]);
        }
        m
    }

    /// The last measurement.
    pub fn measurement(&self) -> &Measurement {
        &self.measurement
    }

    /// Takes the command that was computed from the last measurement and moves the plant on by one period.
    ///
    /// # Errors
    /// What the plant refuses.
    pub fn advance(&mut self, command: &Command) -> Result<(), PlantError> {
        self.computed.take(&self.robot, command);
        let applied = self.delay.exchange(&self.computed);
        let sensors = &mut self.sensors;
        self.plant
            .advance_with(applied, self.period, |plant| sensors.observe(plant))?;
        self.tick += 1;
        Ok(())
    }

    /// The truth.
    pub fn plant(&self) -> &Plant {
        &self.plant
    }
}

/// What a case asks of a controller while it runs: its events when they are due, and contacts switched by measured
/// force.
#[derive(Clone, Debug)]
pub struct Requests {
    /// In the order of their times.
    events: Vec<Event>,
    next: usize,
    detectors: Vec<Detector>,
    /// An event is due a little early: a multiple of the period is not exact.
    slack: f64,
}

impl Requests {
    /// Those of a case, from its beginning, for a controller with this rate in Hz.
    pub fn new(case: &Case, rate: f64) -> Self {
        let mut events = case.events().to_vec();
        events.sort_by(|a, b| a.at.total_cmp(&b.at));
        Self {
            events,
            next: 0,
            detectors: case.detectors().to_vec(),
            slack: 1e-6 / rate,
        }
    }

    /// The next event that is due at a time, s, before that time's tick; each is handed out once.
    pub fn due(&mut self, time: f64) -> Option<&Event> {
        let event = self.events.get(self.next)?;
        if event.at > time + self.slack {
            return None;
        }
        self.next += 1;
        Some(event)
    }

    /// After a tick: switches contacts by the force measured in it. Counts from the next tick on.
    pub fn detect(&mut self, controller: &mut Controller, measurement: &Measurement) {
        for detector in &mut self.detectors {
            // Names were checked when the scenario was loaded.
            let Ok(contact) = controller.contact(&detector.contact) else {
                continue;
            };
            let normal = controller.report().contacts[contact.index()].measured[2];
            let _ = match detector.update(measurement.time, normal) {
                Some(ContactEvent::Made) => controller.activate_contact(&detector.contact),
                Some(ContactEvent::Lost) => controller.deactivate_contact(&detector.contact),
                None => Ok(()),
            };
        }
    }
}
