//! One thing at a time that is not as the controller believes, in the plant and the sensors alone: masses, thrusts, a
//! constant error of the force sensor, differences between rotors, velocities that are estimated from positions,
//! stiffer and softer walls, faster and slower servos.

use toml::Value;

use super::{Scenario, ScenarioError, Variation};

/// One thing that is not as the controller believes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Perturbation {
    /// Nothing: as it ships.
    None,
    /// Factor on every mass and inertia.
    Mass(f64),
    /// Factor on the thrust of every rotor.
    Thrust(f64),
    /// Constant error of the force sensors along each of their axes, N.
    ForceBias(f64),
    /// Rotors are stronger and weaker by this share, in turn.
    RotorsInTurn(f64),
    /// The first half of the rotors is stronger, the other weaker by this share.
    RotorsByHalves(f64),
    /// All velocities are differences of measured positions through a low-pass with this cut-off, Hz.
    EstimatedVelocities(f64),
    /// Stiffness of the walls, N/m.
    Wall(f64),
    /// Factor on the time constant of the joints' servos.
    Servo(f64),
}

impl Perturbation {
    /// In words.
    pub fn words(self) -> String {
        match self {
            Self::None => "as it ships".to_owned(),
            Self::Mass(scale) => format!("mass × {scale}"),
            Self::Thrust(scale) => format!("thrust × {scale}"),
            Self::ForceBias(bias) => format!("force bias {bias} N"),
            Self::RotorsInTurn(share) => format!("rotors ± {} % in turn", 100.0 * share),
            Self::RotorsByHalves(share) => format!("rotors ± {} % by halves", 100.0 * share),
            Self::EstimatedVelocities(cutoff) => format!("velocities estimated, {cutoff} Hz"),
            Self::Wall(stiffness) => format!("wall {} kN/m", stiffness / 1e3),
            Self::Servo(scale) => format!("servo time × {scale}"),
        }
    }

    /// All that is tried.
    pub const ALL: [Self; 15] = [
        Self::None,
        Self::Mass(0.95),
        Self::Mass(1.05),
        Self::Thrust(0.95),
        Self::Thrust(1.05),
        Self::ForceBias(-0.2),
        Self::ForceBias(0.2),
        Self::RotorsInTurn(0.02),
        Self::RotorsByHalves(0.02),
        Self::EstimatedVelocities(30.0),
        Self::Wall(5e3),
        Self::Wall(2e4),
        Self::Wall(1e5),
        Self::Servo(0.5),
        Self::Servo(1.5),
    ];

    /// What a case is changed by.
    ///
    /// # Errors
    /// [`ScenarioError`] if the scenario has no such case, or its controller is refused.
    pub fn variation(self, scenario: &Scenario, case: &str) -> Result<Variation, ScenarioError> {
        let none = Variation::new();
        let found = scenario.case(case)?;
        let plant = found.plant();
        let rotors = |scale: &dyn Fn(usize, usize) -> f64| {
            let controller = found.make_controller(found.controller_config()?)?;
            let count = controller.robot().rotors().count();
            let scales = (0..count).map(|i| Value::from(scale(i, count)));
            let scales = Value::Array(scales.collect());
            Ok(Variation::new().change("plant.mismatch.rotor_scales", scales))
        };
        Ok(match self {
            Self::None => none,
            Self::Mass(scale) => {
                let own = plant.mismatch.mass_scale;
                none.change("plant.mismatch.mass_scale", scale * own)
            }
            Self::Thrust(scale) => {
                let own = plant.mismatch.thrust_scale;
                none.change("plant.mismatch.thrust_scale", scale * own)
            }
            Self::ForceBias(bias) => {
                let sensors = found.sensors().force_torque.iter();
                sensors.fold(none, |variation, sensor| {
                    let biased = sensor.force_bias.map(|own| Value::from(own + bias));
                    let frame = Value::from(sensor.frame.as_str());
                    let path = format!("sensors.force_torque.{frame}.force_bias");
                    variation.change(&path, Value::Array(biased.to_vec()))
                })
            }
            Self::RotorsInTurn(share) => {
                rotors(&|i, _| if i % 2 == 0 { 1.0 + share } else { 1.0 - share })?
            }
            Self::RotorsByHalves(share) => {
                rotors(&|i, n| if 2 * i < n { 1.0 + share } else { 1.0 - share })?
            }
            Self::EstimatedVelocities(cutoff) => none
                .change("sensors.base.velocity_cutoff", cutoff)
                .change("sensors.joints.velocity_cutoff", cutoff),
            Self::Wall(stiffness) => plant.walls.iter().fold(none, |variation, wall| {
                let path = format!("plant.wall.{}.stiffness", Value::from(wall.name.as_str()));
                variation.change(&path, stiffness)
            }),
            Self::Servo(scale) => {
                let own = plant.servo.time_constant;
                none.change("plant.servo.time_constant", scale * own)
            }
        })
    }
}
