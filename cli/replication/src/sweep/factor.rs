//! What a sweep varies, and how a variation gets into a case.

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};
use toml::{Table, Value};
use wbqp_sim::{Scenario, Variation};

/// A quantity that is scaled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Factor {
    /// Largest thrust of every rotor, in plant and controller: it is the robot's.
    ThrustMax,
    /// Friction of the walls, in the plant alone.
    Friction,
    /// K_P of the tasks that turn the base.
    RotationGain,
    /// Mass and inertia of every body, in the plant alone.
    Mass,
}

impl Factor {
    /// All, in the order of tables.
    pub const ALL: [Self; 4] = [
        Self::ThrustMax,
        Self::Friction,
        Self::RotationGain,
        Self::Mass,
    ];

    /// Short name for tables.
    pub fn label(self) -> &'static str {
        match self {
            Self::ThrustMax => "f_max",
            Self::Friction => "friction",
            Self::RotationGain => "rotation K_P",
            Self::Mass => "mass",
        }
    }
}

/// The values of one case that factors scale.
#[derive(Clone, Debug)]
pub(super) struct Nominal {
    /// N.
    thrust_max: f64,
    /// By wall.
    friction: Vec<(String, f64)>,
    /// By task; a number or one per axis.
    rotation_gain: Vec<(String, Value)>,
    mass_scale: f64,
}

impl Nominal {
    pub(super) fn of(scenario: &Scenario, case: &str) -> Result<Self> {
        let config = scenario.controller_config(case)?;
        let robot = config.robot.load(&config.directory)?;
        let limits = robot.rotors().map(|(_, actuator, _)| actuator.upper);
        let thrust_max = limits.reduce(f64::max).context("the robot has no rotor")?;
        let plant = scenario.case(case)?.plant();
        let walls = plant.walls.iter();
        let file: Table = config.to_toml()?.parse()?;
        let tasks = file.get("task").and_then(Value::as_array);
        let tasks = tasks.into_iter().flatten().filter_map(Value::as_table);
        let rotating = tasks.filter(|t| {
            t.get("type")
                .is_some_and(|tag| tag.as_str() == Some(ROTATION))
        });
        let gain = |task: &Table| {
            Some((
                task.get("name")?.as_str()?.to_owned(),
                task.get("kp")?.clone(),
            ))
        };
        Ok(Self {
            thrust_max,
            friction: walls.map(|w| (w.name.clone(), w.friction)).collect(),
            rotation_gain: rotating.filter_map(gain).collect(),
            mass_scale: plant.mismatch.mass_scale,
        })
    }

    /// Adds a factor to a variation.
    pub(super) fn scaled(&self, variation: Variation, factor: Factor, scale: f64) -> Variation {
        match factor {
            Factor::ThrustMax => variation.set("robot.thrust_max", scale * self.thrust_max),
            Factor::Friction => self.friction.iter().fold(variation, |v, (wall, friction)| {
                v.change(
                    &format!("plant.wall.{}.friction", quoted(wall)),
                    scale * friction,
                )
            }),
            Factor::RotationGain => self
                .rotation_gain
                .iter()
                .fold(variation, |v, (task, gain)| {
                    v.set(&format!("task.{}.kp", quoted(task)), times(gain, scale))
                }),
            Factor::Mass => variation.change("plant.mismatch.mass_scale", scale * self.mass_scale),
        }
    }
}

/// The task that turns the base.
const ROTATION: &str = "base_orientation";

/// A name as a key of a path, whatever characters it has.
fn quoted(name: &str) -> Value {
    Value::from(name)
}

fn times(value: &Value, scale: f64) -> Value {
    match value {
        Value::Float(x) => Value::Float(scale * x),
        Value::Integer(i) => Value::Float(scale * *i as f64),
        Value::Array(all) => Value::Array(all.iter().map(|v| times(v, scale)).collect()),
        other => other.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wbqp_terminal::scenario_file;

    use crate::experiments;

    #[test]
    fn every_factor_changes_every_case_that_ships_and_nothing_else() {
        for experiment in experiments::ALL {
            let scenario =
                Scenario::from_file(&scenario_file(experiment.measures.name, None)).unwrap();
            for case in scenario.cases() {
                let nominal = Nominal::of(&scenario, case).unwrap();
                let mut variation = Variation::new();
                for factor in Factor::ALL {
                    variation = nominal.scaled(variation, factor, 1.05);
                }
                let varied = scenario.varied(&variation).unwrap();
                let found = Nominal::of(&varied, case).unwrap();
                let near = |a: f64, b: f64| assert!((a - 1.05 * b).abs() < 1e-12, "{case}");
                near(found.thrust_max, nominal.thrust_max);
                near(found.mass_scale, nominal.mass_scale);
                for (found, nominal) in found.friction.iter().zip(&nominal.friction) {
                    near(found.1, nominal.1);
                }
                assert_eq!(found.rotation_gain.len(), 1);
                let expected = times(&nominal.rotation_gain[0].1, 1.05);
                assert_eq!(found.rotation_gain[0].1, expected);
                // The controller's idea of friction stays.
                let contacts = |s: &Scenario| s.controller_config(case).unwrap().contacts;
                let friction =
                    |s: &Scenario| contacts(s).iter().map(|c| c.friction).collect::<Vec<_>>();
                assert_eq!(friction(&varied), friction(&scenario));
            }
        }
    }
}
