//! What the controller is told of the plant.
//!
//! # Notation
//! State as in [`wbqp::state`]: world-aligned velocities. Wrenches `[force; moment]` are those of the
//! environment on the robot, in the axes of the sensor's frame, about its origin.
//!
//! # Noise
//! One seed for all sensors; each sensor draws from its own stream of ChaCha8, always the same number of values
//! per sample. So a run is bit-reproducible, and changing one sensor's noise leaves the others' as they were.
#![allow(non_snake_case)]

mod config;
mod force_torque;
mod outage;
mod velocity;

use nalgebra::{Vector3, Vector6};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use wbqp::{spatial, state::State};

pub use config::{BaseSensorConfig, ForceTorqueConfig, JointSensorConfig, SensorsConfig};
pub(crate) use outage::BUILT_IN;
pub use outage::{OutageConfig, Reads};

use crate::{
    check::{Problems, unknown_frame},
    plant::PlantError,
    world::World,
};
use force_torque::ForceTorque;
use outage::Outage;
use velocity::VelocityEstimate;

/// Streams of the generator. Force-torque sensor i has `FORCE_TORQUE + i`.
const BASE: u64 = 0;
const JOINTS: u64 = 1;
const FORCE_TORQUE: u64 = 16;

/// What all sensors say at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorReading {
    /// Time of the sample, s.
    pub time: f64,
    /// Measured configuration and velocity.
    pub state: State,
    /// One wrench per force-torque sensor, in the order of the configuration: `[force; moment]` of the
    /// environment on the robot, N and N·m, in the axes of the sensor's frame, about its origin.
    pub wrenches: Vec<Vector6<f64>>,
}

impl SensorReading {
    /// Does not allocate.
    fn copy_from(&mut self, other: &Self) {
        self.time = other.time;
        self.state.copy_from(&other.state);
        self.wrenches.copy_from_slice(&other.wrenches);
    }
}

/// All sensors of a plant, with their noise and filters.
#[derive(Clone, Debug)]
pub struct Sensors {
    config: SensorsConfig,
    base: ChaCha8Rng,
    joints: ChaCha8Rng,
    velocity: VelocityEstimate,
    force_torque: Vec<ForceTorque>,
    outages: Vec<Outage>,
    reading: SensorReading,
    /// The reading before, as it was told.
    last: SensorReading,
}

impl Sensors {
    /// Sensors of that plant, drawing all noise from `seed`.
    ///
    /// # Errors
    /// Numbers that cannot be, and frames that the robot does not have, all at once.
    pub fn new(config: &SensorsConfig, plant: &dyn World, seed: u64) -> Result<Self, PlantError> {
        config.validate()?;
        let mut problems = Problems::default();
        let mut force_torque = Vec::new();
        for (i, sensor) in config.force_torque.iter().enumerate() {
            match plant.model().frame(&sensor.frame) {
                Some(frame) => {
                    let rng = stream(seed, FORCE_TORQUE + i as u64);
                    force_torque.push(ForceTorque::new(sensor, frame, plant, rng));
                }
                None => problems.add(
                    &format!("force_torque[{i}].frame"),
                    &unknown_frame(plant.model(), &sensor.frame),
                ),
            }
        }
        let outages = Outage::all(config, plant, &mut problems);
        problems.into_result(|problems| PlantError::Config { problems })?;
        let reading = SensorReading {
            time: plant.time(),
            state: plant.state().clone(),
            wrenches: vec![Vector6::zeros(); force_torque.len()],
        };
        Ok(Self {
            config: config.clone(),
            base: stream(seed, BASE),
            joints: stream(seed, JOINTS),
            velocity: VelocityEstimate::new(
                config.base.velocity_cutoff,
                config.joints.velocity_cutoff,
                plant.state(),
            ),
            last: reading.clone(),
            reading,
            force_torque,
            outages,
        })
    }

    /// Lets the filters follow the world. To be called after every integration step
    /// ([`Plant::advance_with`](crate::Plant::advance_with)); without it the filters take the wrench for linear between
    /// two samples.
    pub fn observe(&mut self, plant: &dyn World) {
        for sensor in &mut self.force_torque {
            sensor.observe(plant);
        }
    }

    /// Measures: draws new noise and hands out the reading. Does not allocate.
    pub fn sample(&mut self, plant: &dyn World) -> &SensorReading {
        let reading = &mut self.reading;
        reading.time = plant.time();
        reading.state.copy_from(plant.state());

        let state = &mut reading.state;
        let base = self.config.base;
        let [position, rotation, linear, angular] = std::array::from_fn(|_| vector(&mut self.base));
        let offset = plant.model().joint_offset();
        if offset == 6 {
            state.p_WR += position * base.position_sd;
            state.R_WR = spatial::exp(&(rotation * base.rotation_sd)) * state.R_WR;
            for axis in 0..3 {
                state.v[axis] += linear[axis] * base.linear_sd;
                state.v[3 + axis] += angular[axis] * base.angular_sd;
            }
        }
        for i in 0..state.q.len() {
            state.q[i] += self.config.joints.position_sd * noise(&mut self.joints);
            state.v[offset + i] += self.config.joints.velocity_sd * noise(&mut self.joints);
        }
        self.velocity.replace(reading.time, state);
        for (wrench, sensor) in reading.wrenches.iter_mut().zip(&mut self.force_torque) {
            *wrench = sensor.sample(plant);
        }
        for outage in &self.outages {
            outage.apply(&self.last, &mut self.reading);
        }
        self.last.copy_from(&self.reading);
        &self.reading
    }
}

fn stream(seed: u64, stream: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(stream);
    rng
}

/// A standard normal number.
fn noise(rng: &mut ChaCha8Rng) -> f64 {
    rng.sample(StandardNormal)
}

fn vector(rng: &mut ChaCha8Rng) -> Vector3<f64> {
    Vector3::new(noise(rng), noise(rng), noise(rng))
}
