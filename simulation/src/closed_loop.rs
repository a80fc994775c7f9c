//! One case of a scenario period by period, for whoever brings a controller: what [`run`](crate::run()) does, without
//! the log.

use nalgebra::Vector6;
use wbqp::{
    contact::Detector,
    controller::{Command, Controller, Measurement},
    robot::RobotModel,
};

use crate::{
    CommandDelay, Plant, PlantCommand, PlantError, Sensors, World,
    scenario::{Case, Event, ScenarioError},
};

/// What stands between a case's controller and its world: sensors, the delay of commands, the clock.
///
/// The controller sees nothing of the world but the sensors.
#[derive(Debug)]
pub struct Link {
    robot: RobotModel,
    sensors: Sensors,
    delay: CommandDelay,
    measurement: Measurement,
    computed: PlantCommand,
    /// Which force-torque sensor belongs to each of the controller's contacts.
    contact_sensors: Vec<Option<usize>>,
    period: f64,
    tick: usize,
}

impl Link {
    /// At time 0. `seed` is the noise's.
    ///
    /// # Errors
    /// What the sensors refuse.
    pub fn new(
        case: &Case,
        controller: &Controller,
        world: &dyn World,
        seed: u64,
    ) -> Result<Self, ScenarioError> {
        let robot = controller.robot().clone();
        let sensors = case.make_sensors(world, seed)?;
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
        Ok(Self {
            delay: CommandDelay::new(case.plant().command_delay, computed.clone()),
            measurement: Measurement::home(&robot, contact_sensors.len()),
            period: 1.0 / controller.settings().rate,
            tick: 0,
            robot,
            sensors,
            computed,
            contact_sensors,
        })
    }

    /// What the sensors say now; draws new noise.
    pub fn measure(&mut self, world: &dyn World) -> &Measurement {
        let reading = self.sensors.sample(world);
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

    /// Takes the command that was computed from the last measurement and puts the one that is due for the next period
    /// into `due`.
    pub fn exchange(&mut self, command: &Command, due: &mut PlantCommand) {
        self.computed.take(&self.robot, command);
        due.copy_from(self.delay.exchange(&self.computed));
        self.tick += 1;
    }

    /// Lets the sensors' filters follow the world. To be called after every integration step.
    pub fn observe(&mut self, world: &dyn World) {
        self.sensors.observe(world);
    }

    /// The last command that was computed, the hover command at first.
    pub fn computed(&self) -> &PlantCommand {
        &self.computed
    }

    /// The controller's period, s.
    pub fn period(&self) -> f64 {
        self.period
    }
}

/// The plant and the sensors of a case: [`ClosedLoop::measure`], the controller's tick, [`ClosedLoop::advance`].
///
/// The controller sees nothing of the plant but the sensors.
#[derive(Debug)]
pub struct ClosedLoop {
    plant: Plant,
    link: Link,
    due: PlantCommand,
}

impl ClosedLoop {
    /// At time 0, with rotors at the controller's hover command. `seed` is the noise's.
    ///
    /// # Errors
    /// What plant and sensors refuse.
    pub fn new(case: &Case, controller: &Controller, seed: u64) -> Result<Self, ScenarioError> {
        let plant = settled_plant(case, controller)?;
        let link = Link::new(case, controller, &plant, seed)?;
        Ok(Self {
            due: link.computed.clone(),
            plant,
            link,
        })
    }

    /// What the sensors say now; draws new noise.
    pub fn measure(&mut self) -> &Measurement {
        self.link.measure(&self.plant)
    }

    /// The last measurement.
    pub fn measurement(&self) -> &Measurement {
        &self.link.measurement
    }

    /// Takes the command that was computed from the last measurement and moves the plant on by one period.
    ///
    /// # Errors
    /// What the plant refuses.
    pub fn advance(&mut self, command: &Command) -> Result<(), PlantError> {
        let Self { plant, link, due } = self;
        link.exchange(command, due);
        plant.advance_with(due, link.period, |plant| link.observe(plant))
    }

    /// The truth, to be pulled at and to have its walls moved.
    pub fn plant_mut(&mut self) -> &mut Plant {
        &mut self.plant
    }

    /// The truth.
    pub fn plant(&self) -> &Plant {
        &self.plant
    }
}

/// The plant of a case at time 0, with rotors at the controller's hover command.
pub(crate) fn settled_plant(case: &Case, controller: &Controller) -> Result<Plant, ScenarioError> {
    let robot = controller.robot();
    let mut plant = case.make_plant(robot)?;
    plant
        .settle_rotors(&PlantCommand::of(robot, controller.command()))
        .map_err(|e| case.plant_error("plant", e))?;
    Ok(plant)
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

    /// After a tick: switches contacts by the force measured in it. Counts from the next tick on. A tick without a
    /// solution has no such force, and changes nothing.
    pub fn detect(&mut self, controller: &mut Controller, measurement: &Measurement) {
        if !controller.report().level.is_solved() {
            return;
        }
        for detector in &mut self.detectors {
            // Names were checked when the scenario was loaded.
            let Ok(contact) = controller.contact(&detector.contact) else {
                continue;
            };
            let normal = controller.report().contacts[contact.index()].measured[2];
            if !detector.update(measurement.time, normal) {
                continue;
            }
            let _ = if detector.is_touching() {
                controller.activate_contact(&detector.contact)
            } else {
                controller.deactivate_contact(&detector.contact)
            };
        }
    }
}
