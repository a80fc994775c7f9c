//! A force-torque sensor with its low-pass.
//!
//! # Notation
//! `w` the true wrench in the sensor frame's axes, `b` the bias, `n_k` the noise of sample k, `y` the reading,
//! `τ = 1 / (2π cutoff)`.
//! ```text
//! y = F[w] + b + m_k        F first order with τ, exact for w linear between two observations, and for a parabola
//!                           through the middle of a step where that is shown
//! m_k = e m_k-1 + (1 − e) n_k,  e = exp(−T/τ), T the time since the last sample
//! ```
//! The truth is filtered at the rate of the observations (the plant's steps), the noise at the rate of the
//! samples: the sum is a sensor that filters its noisy samples, whatever the plant's step.
#![allow(non_snake_case)]

use std::f64::consts::TAU;

use nalgebra::Vector6;
use rand_chacha::ChaCha8Rng;
use wbqp::{dynamics::elementary, model::FrameId};

use super::{ForceTorqueConfig, noise};
use crate::World;

#[derive(Clone, Debug)]
pub(super) struct ForceTorque {
    frame: FrameId,
    bias: Vector6<f64>,
    sd: [f64; 2],
    time_constant: f64,
    rng: ChaCha8Rng,
    /// Time of the last observation, s, and the truth then.
    observed: f64,
    truth: Vector6<f64>,
    /// The truth in the middle of the step that is being observed.
    middle: Option<Vector6<f64>>,
    filtered: Vector6<f64>,
    sampled: f64,
    noise: Vector6<f64>,
}

impl ForceTorque {
    /// A sensor that has been in the plant's present state for long.
    pub(super) fn new(
        config: &ForceTorqueConfig,
        frame: FrameId,
        plant: &dyn World,
        rng: ChaCha8Rng,
    ) -> Self {
        let [fx, fy, fz] = config.force_bias;
        let [mx, my, mz] = config.moment_bias;
        let truth = plant.wrench_at(frame);
        Self {
            frame,
            bias: Vector6::new(fx, fy, fz, mx, my, mz),
            sd: [config.force_sd, config.moment_sd],
            time_constant: 1.0 / (TAU * config.cutoff),
            rng,
            observed: plant.time(),
            truth,
            middle: None,
            filtered: truth,
            sampled: plant.time(),
            noise: Vector6::zeros(),
        }
    }

    /// Filters the truth up to the plant's present time.
    pub(super) fn observe(&mut self, plant: &dyn World) {
        let elapsed = plant.time() - self.observed;
        if elapsed < 0.0 {
            return;
        }
        let truth = plant.wrench_at(self.frame);
        if plant.is_within_step() {
            self.middle = Some(truth);
            return;
        }
        // Without time between, a jump.
        if elapsed > 0.0 {
            self.filtered = match self.middle.take() {
                Some(middle) => self.after_parabola(elapsed, &middle, &truth),
                None => self.after_line(elapsed, &truth),
            };
        }
        self.truth = truth;
        self.observed = plant.time();
    }

    /// Response of the filter to an input that goes straight from the last truth to this one.
    fn after_line(&self, elapsed: f64, truth: &Vector6<f64>) -> Vector6<f64> {
        let decay = self.decay(elapsed);
        let slope = (1.0 - decay) * self.time_constant / elapsed;
        (self.filtered - self.truth) * decay + truth - (truth - self.truth) * slope
    }

    /// Response to a parabola from the last truth through one half way to this one: `y = w − τ ẇ + τ² ẅ` solves
    /// `τ ẏ = w − y`, and what the filter differs from it decays.
    fn after_parabola(
        &self,
        elapsed: f64,
        middle: &Vector6<f64>,
        truth: &Vector6<f64>,
    ) -> Vector6<f64> {
        let decay = self.decay(elapsed);
        let unit = self.time_constant / elapsed;
        let bend = (self.truth - middle * 2.0 + truth) * 4.0;
        let rise = truth - self.truth;
        let first = self.truth - (rise - bend * 0.5) * unit + bend * (unit * unit);
        let last = truth - (rise + bend * 0.5) * unit + bend * (unit * unit);
        (self.filtered - first) * decay + last
    }

    /// The reading at the plant's present time; draws new noise.
    pub(super) fn sample(&mut self, plant: &dyn World) -> Vector6<f64> {
        self.observe(plant);
        let elapsed = plant.time() - self.sampled;
        self.sampled = plant.time();
        let decay = self.decay(elapsed);
        for axis in 0..6 {
            let fresh = self.sd[axis / 3] * noise(&mut self.rng);
            self.noise[axis] += (1.0 - decay) * (fresh - self.noise[axis]);
        }
        self.filtered + self.bias + self.noise
    }

    /// What is left of the filter's memory after `elapsed` s.
    fn decay(&self, elapsed: f64) -> f64 {
        if self.time_constant > 0.0 {
            elementary::exp(-elapsed / self.time_constant)
        } else {
            0.0
        }
    }
}
