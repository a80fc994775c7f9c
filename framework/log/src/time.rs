//! When a message is of.

use crate::LogError;

/// A message's time in s as whole nanoseconds: files have no others.
///
/// # Errors
/// [`LogError::Time`] if it is negative or not finite.
pub fn nanoseconds(time: f64) -> Result<u64, LogError> {
    if time.is_finite() && time >= 0.0 {
        Ok((time * 1e9).round() as u64)
    } else {
        Err(LogError::Time(time))
    }
}
