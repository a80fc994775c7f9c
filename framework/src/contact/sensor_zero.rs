//! The zero of a force-torque sensor, taken while nothing is touched.
//!
//! # Mathematics
//! A first-order low-pass with a time constant of 0.25 s follows the reading m, `m̄ += (m − m̄) s`, and
//! [`SensorZero::take`] makes it the zero m₀: from then on `m − m₀` counts as the wrench.

use nalgebra::Vector6;

/// Of the mean reading, Hz: a time constant of 0.25 s.
pub(crate) const CUTOFF: f64 = 4.0 / std::f64::consts::TAU;

/// The mean reading, and what of a reading counts as zero. `[force; moment]`, N and N·m, in the sensor's axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct SensorZero {
    /// None before the first reading.
    pub(crate) mean: Option<Vector6<f64>>,
    pub(crate) offset: Vector6<f64>,
}

impl SensorZero {
    /// Follows a reading, of which so much is new.
    pub(crate) fn follow(&mut self, reading: &Vector6<f64>, share: f64) {
        let mean = self.mean.get_or_insert(*reading);
        *mean += (reading - *mean) * share;
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
            zero.follow(&bias.add_scalar(noise), 0.016);
        }
        assert_eq!(zero.correct(&bias), bias);
        zero.take();
        assert!(zero.correct(&bias).amax() < 1e-3);
    }
}
