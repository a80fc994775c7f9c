//! The first-order low-pass of everything that the controller filters.

use wbqp_dynamics::elementary;

/// Share of a new sample in a low-pass with this cutoff, Hz, so many seconds after the one before.
pub(super) fn low_pass(cutoff: f64, seconds: f64) -> f64 {
    1.0 - elementary::exp(-std::f64::consts::TAU * cutoff * seconds)
}
