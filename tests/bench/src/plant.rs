//! Closed loops with other steps of the plant's integrator: how exact and how fast they are.

use std::time::Instant;

use anyhow::Result;
use nalgebra::Vector3;
use wbqp::nalgebra;
use wbqp_sim::{ClosedLoop, Requests, Scenario, Variation, scenario::Case};
use wbqp_terminal::scenario_file;

/// How the plant is integrated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Steps {
    /// Equal ones of so many seconds.
    Equal(f64),
    /// With this tolerance.
    Controlled(f64),
}

/// What a loop was at the start of a period.
#[derive(Clone, Debug)]
pub struct Sample {
    /// Of the base, m.
    pub position: Vector3<f64>,
    /// Of all walls on the tool, N.
    pub force: Vector3<f64>,
    /// What the force-torque sensor says, N.
    pub measured: Vector3<f64>,
    /// Of the rotors, N.
    pub thrusts: Vec<f64>,
}

/// The largest differences of two runs.
#[derive(Clone, Copy, Debug, Default)]
pub struct Differences {
    /// m
    pub position: f64,
    /// N
    pub force: f64,
    /// N
    pub measured: f64,
    /// N
    pub thrust: f64,
}

/// A shipped scenario with these steps, with its noise or without.
///
/// # Errors
/// A scenario that is not there, or refuses the steps.
pub fn scenario(name: &str, steps: Steps, noise: Noise) -> Result<Scenario> {
    let mut variation = match steps {
        Steps::Equal(step) => Variation::new().change("plant.step", step),
        Steps::Controlled(tolerance) => Variation::new().change("plant.tolerance", tolerance),
    };
    if noise == Noise::Without {
        for key in [
            "base.position_sd",
            "base.rotation_sd",
            "base.linear_sd",
            "base.angular_sd",
            "joints.position_sd",
            "joints.velocity_sd",
            "force_torque.tool.force_sd",
        ] {
            variation = variation.change(&format!("sensors.{key}"), 0.0);
        }
    }
    Ok(Scenario::from_file(&scenario_file(name, None))?.varied(&variation)?)
}

/// Whether sensors are noisy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Noise {
    /// As in the file.
    With,
    /// None at all.
    Without,
}

/// Runs a case; `each` sees the loop before every tick. Says how long it took, s, controller and setting up included.
///
/// # Errors
/// A case that is refused.
pub fn run(case: &Case, seed: u64, mut each: impl FnMut(&ClosedLoop)) -> Result<f64> {
    let begin = Instant::now();
    let mut controller = case.make_controller(case.controller_config()?)?;
    let rate = controller.settings().rate;
    let mut requests = Requests::new(case, rate);
    let mut closed_loop = ClosedLoop::new(case, &controller, seed)?;
    for _ in 0..case.ticks(rate) {
        let measurement = closed_loop.measure();
        while let Some(event) = requests.due(measurement.time) {
            let applied = event.apply(&mut controller);
            applied.map_err(|what| anyhow::anyhow!("event at {} s: {what}", event.at))?;
        }
        each(&closed_loop);
        let measurement = closed_loop.measurement();
        controller.tick(measurement);
        requests.detect(&mut controller, measurement);
        closed_loop.advance(controller.command())?;
    }
    Ok(begin.elapsed().as_secs_f64())
}

/// Every period of a case.
///
/// # Errors
/// A case that is refused.
pub fn trajectory(case: &Case) -> Result<Vec<Sample>> {
    let mut samples = Vec::new();
    run(case, 1, |closed_loop| {
        let plant = closed_loop.plant();
        let contact = plant.contact(0);
        samples.push(Sample {
            position: plant.state().p_WR,
            force: contact.map_or_else(Vector3::zeros, |contact| contact.force_W),
            measured: closed_loop
                .measurement()
                .wrenches
                .first()
                .map_or_else(Vector3::zeros, |wrench| wrench.fixed_rows::<3>(0).into()),
            thrusts: plant.thrusts().to_vec(),
        });
    })?;
    Ok(samples)
}

impl Differences {
    /// Between two runs of the same length.
    pub fn of(one: &[Sample], other: &[Sample]) -> Self {
        let mut most = Self::default();
        for (a, b) in one.iter().zip(other) {
            let thrusts = a.thrusts.iter().zip(&b.thrusts);
            most.position = most.position.max((a.position - b.position).norm());
            most.force = most.force.max((a.force - b.force).norm());
            most.measured = most.measured.max((a.measured - b.measured).norm());
            most.thrust = thrusts.fold(most.thrust, |most, (a, b)| most.max((a - b).abs()));
        }
        most
    }
}
