//! The optional integral of a motion task.

use crate::{check, gain::Gain};
use wbqp::setup::BindError;

/// `K_I ∫ e dt` per axis, each clamped. The gain is inside the integral, so that changing it makes no jump.
#[derive(Clone, Debug, Default)]
pub(crate) struct Integral(Vec<f64>);

impl Integral {
    pub(crate) fn new(axes: usize) -> Self {
        Self(vec![0.0; axes])
    }

    /// Checks gain and clamp.
    pub(crate) fn validate(ki: &Gain, limit: f64, axes: usize) -> Result<(), BindError> {
        ki.validate("ki", axes)?;
        check::positive("integral_limit", limit)
    }

    pub(crate) fn reset(&mut self) {
        self.0.fill(0.0);
    }

    /// Adds one period of one axis's error; gives the term to subtract from the acceleration.
    pub(crate) fn step(&mut self, axis: usize, rate: f64, period: f64, limit: f64) -> f64 {
        let Some(term) = self.0.get_mut(axis) else {
            return 0.0;
        };
        let next = *term + rate * period;
        if next.is_finite() {
            // `max` and `min` rather than `clamp`, which panics if the limit was set to NaN.
            *term = next.min(limit).max(-limit);
        }
        *term
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integrates_stops_at_the_clamp_and_returns_at_once() {
        let mut integral = Integral::new(2);
        assert_eq!(integral.step(1, 2.0, 0.1, 0.5), 0.2);
        for _ in 0..10 {
            integral.step(1, 2.0, 0.1, 0.5);
        }
        assert_eq!(integral.step(1, 0.0, 0.1, 0.5), 0.5);
        assert_eq!(integral.step(1, -1.0, 0.1, 0.5), 0.4);
        assert_eq!(integral.step(0, 0.0, 0.1, 0.5), 0.0, "axes are separate");
        assert_eq!(integral.step(7, 1.0, 0.1, 0.5), 0.0);
        assert_eq!(integral.step(1, f64::NAN, 0.1, 0.5), 0.4);
        integral.reset();
        assert_eq!(integral.step(1, 0.0, 0.1, 0.5), 0.0);
    }
}
