//! What barriers share.
//!
//! # Mathematics
//! For a function h(q) that shall not become negative, `ḧ + (a₁ + a₂) ḣ + a₁ a₂ h ≥ 0` makes `ḣ + a₁ h` decay no faster
//! than with a₂, and h no faster than with a₁: h stays positive if both are at the start. An exponential control
//! barrier function of relative degree two: Nguyen and Sreenath, *Exponential control barrier functions for enforcing
//! high relative-degree safety-critical constraints*, ACC 2016.

use wbqp::error::BindError;

use crate::check;

/// Checks a rate: positive, and slow enough for the control period.
pub(super) fn validate_rate(key: &str, rate: f64, period: f64) -> Result<(), BindError> {
    check::positive(key, rate)?;
    if rate * period > 1.0 {
        let most = 1.0 / period;
        let problem = format!("is {rate} 1/s, must be at most {most}: one over the control period");
        return Err(BindError::value(key, problem));
    }
    Ok(())
}

/// The least `ḧ` for `h` and `ḣ`.
pub(super) fn least(rates: [f64; 2], h: f64, hdot: f64) -> f64 {
    -(rates[0] + rates[1]) * hdot - rates[0] * rates[1] * h
}

/// What rates are unless they are given, 1/s.
pub(super) const DEFAULT_RATE: f64 = 10.0;
