//! A controller on a plant, period by period, for tests that look into both.

use wbqp::{
    contact::Detector,
    controller::{Controller, Measurement},
    state::State,
};
use wbqp_sim::{
    CommandDelay, Plant, PlantCommand, PlantConfig, PlantError, Sensors, SensorsConfig,
};

/// A running loop with one contact; its force is what the first force-torque sensor says.
#[derive(Debug)]
pub struct ClosedLoop {
    /// The controller, for requests between two steps.
    pub controller: Controller,
    /// The plant.
    pub plant: Plant,
    /// What switches the contact, if anything.
    pub detector: Option<Detector>,
    sensors: Sensors,
    delay: CommandDelay,
    measurement: Measurement,
    computed: PlantCommand,
    tick: usize,
}

impl ClosedLoop {
    /// At time 0, with rotors at the controller's hover command.
    ///
    /// # Errors
    /// What plant and sensors refuse.
    pub fn new(
        controller: Controller,
        plant: &PlantConfig,
        sensors: &SensorsConfig,
        initial: State,
    ) -> Result<Self, PlantError> {
        let robot = controller.robot().clone();
        let periods = plant.command_delay;
        let mut plant = Plant::new(&robot, plant, initial)?;
        let sensors = Sensors::new(sensors, &plant, 1)?;
        let computed = PlantCommand::of(&robot, controller.command());
        plant.settle_rotors(&computed)?;
        Ok(Self {
            delay: CommandDelay::new(periods, computed.clone()),
            measurement: Measurement::home(&robot, 1),
            detector: None,
            tick: 0,
            controller,
            plant,
            sensors,
            computed,
        })
    }

    /// Time of the next step, s.
    pub fn time(&self) -> f64 {
        self.tick as f64 / self.controller.settings().rate
    }

    /// Measures, ticks, and moves the plant on by one period. The controller keeps the tick's report and command.
    ///
    /// # Errors
    /// What the plant refuses.
    pub fn step(&mut self) -> Result<(), PlantError> {
        self.step_with(|_| ())
    }

    /// As [`ClosedLoop::step`], with something done to what is measured.
    ///
    /// # Errors
    /// What the plant refuses.
    pub fn step_with(&mut self, spoil: impl FnOnce(&mut Measurement)) -> Result<(), PlantError> {
        let reading = self.sensors.sample(&self.plant);
        self.measurement.time = self.tick as f64 / self.controller.settings().rate;
        self.measurement.state.copy_from(&reading.state);
        self.measurement.wrenches[0] = reading.wrenches[0];
        spoil(&mut self.measurement);
        self.controller.tick(&self.measurement);
        self.computed
            .take(self.controller.robot(), self.controller.command());
        self.detect();
        let applied = self.delay.exchange(&self.computed);
        let period = 1.0 / self.controller.settings().rate;
        let sensors = &mut self.sensors;
        self.plant
            .advance_with(applied, period, |plant| sensors.observe(plant))?;
        self.tick += 1;
        Ok(())
    }

    fn detect(&mut self) {
        let Some(detector) = &mut self.detector else {
            return;
        };
        if !self.controller.report().level.is_solved() {
            return;
        }
        let normal = self.controller.report().contacts[0].measured[2];
        if !detector.update(self.measurement.time, normal) {
            return;
        }
        let contact = detector.contact.as_str();
        let switched = if detector.is_touching() {
            self.controller.activate_contact(contact)
        } else {
            self.controller.deactivate_contact(contact)
        };
        switched.expect("the detector's contact exists");
    }
}
