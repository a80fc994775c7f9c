//! Checks of single numbers, with errors that name the key.

use wbqp::error::BindError;

/// Finite and not negative.
pub(crate) fn not_negative(key: &str, value: f64) -> Result<(), BindError> {
    require(
        key,
        value,
        value.is_finite() && value >= 0.0,
        "finite and not negative",
    )
}

/// Finite and above zero.
pub(crate) fn positive(key: &str, value: f64) -> Result<(), BindError> {
    require(
        key,
        value,
        value.is_finite() && value > 0.0,
        "finite and above zero",
    )
}

/// Finite.
pub(crate) fn finite_number(key: &str, value: f64) -> Result<(), BindError> {
    require(key, value, value.is_finite(), "finite")
}

/// All finite.
pub(crate) fn finite(key: &str, values: &[f64]) -> Result<(), BindError> {
    for (index, x) in values.iter().enumerate() {
        require(&format!("{key}[{index}]"), *x, x.is_finite(), "finite")?;
    }
    Ok(())
}

fn require(key: &str, value: f64, holds: bool, what: &str) -> Result<(), BindError> {
    if holds {
        Ok(())
    } else {
        Err(BindError::value(key, format!("is {value}, must be {what}")))
    }
}
