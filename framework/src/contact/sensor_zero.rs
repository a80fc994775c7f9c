//! The zero of a force-torque sensor, taken while nothing is touched.
//!
//! # Mathematics
//! `m̄ += (m − m̄)(1 − exp(−Δt/τ))` with τ = 0.25 s follows the reading m, and [`SensorZero::take`] makes it the zero m₀:
//! from then on `m − m₀` counts as the wrench.

use nalgebra::Vector6;

/// s.
const TIME_CONSTANT: f64 = 0.25;

/// The mean reading, and what of a reading counts as zero. `[force; moment]`, N and N·m, in the sensor's axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct SensorZero {
    /// None before the first reading.
    pub(crate) mean: Option<Vector6<f64>>,
    pub(crate) offset: Vector6<f64>,
}

impl SensorZero {
    /// Follows a reading, so many seconds after the one before.
    pub(crate) fn follow(&mut self, reading: &Vector6<f64>, elapsed: f64) {
        let mean = self.mean.get_or_insert(*reading);
        *mean += (reading - *mean) * (1.0 - (-elapsed / TIME_CONSTANT).exp());
    }

    /// The wrench that a reading means.
    pub(crate) fn correct(&self, reading: &Vector6<f64>) -> Vector6<f64> {
        reading - self.offset
    }

    /// The mean reading is zero from now on. Before the first reading nothing changes.
    pub(crate) fn take(&mut self) {
        if let Some(mean) = self.mean {
            self.offset = mean;
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector6;

    use super::SensorZero;

    #[test]
    fn what_is_read_on_average_becomes_zero() {
        let mut zero = SensorZero::default();
        let bias = Vector6::new(0.2, -0.1, 0.3, 0.01, 0.0, -0.02);
        zero.take();
        assert_eq!(zero.correct(&bias), bias);
        for k in 0..500 {
            let noise = if k % 2 == 0 { 0.05 } else { -0.05 };
            zero.follow(&bias.add_scalar(noise), 0.004);
        }
        assert_eq!(zero.correct(&bias), bias);
        zero.take();
        assert!(zero.correct(&bias).amax() < 1e-3);
    }
}
