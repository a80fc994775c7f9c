//! Sine, cosine, their like and what is made of them, with the same bits everywhere.
//!
//! Those of the standard library are the platform's, and each rounds otherwise: a command in a browser, or of another
//! operating system, would differ in its tenth digit. What a tick computes takes these.

/// Sine and cosine of an angle in rad.
#[inline]
pub fn sin_cos(angle: f64) -> (f64, f64) {
    libm::sincos(angle)
}

/// The angle of the point (`x`, `y`), rad, from −π to π.
#[inline]
pub fn atan2(y: f64, x: f64) -> f64 {
    libm::atan2(y, x)
}

/// The exponential function.
#[inline]
pub fn exp(x: f64) -> f64 {
    libm::exp(x)
}

/// A positive number to any power.
#[inline]
pub fn pow(base: f64, exponent: f64) -> f64 {
    libm::pow(base, exponent)
}

/// Share of a new sample in a first-order low-pass with this cutoff, Hz, so many seconds after the one before:
/// `1 − exp(−2π f t)`.
#[inline]
pub fn low_pass(cutoff: f64, seconds: f64) -> f64 {
    1.0 - exp(-std::f64::consts::TAU * cutoff * seconds)
}
