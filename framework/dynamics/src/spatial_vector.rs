//! Pairs of a linear and an angular vector, and how they move from a body's origin to its parent's.
//!
//! # Notation
//! World axes. `r` is the position of the body's origin from its parent's origin, `p_PB_W`. These are the
//! spatial vectors of RBDA chapter 2, kept as two 3-vectors at the body's own origin.

use std::ops::{Add, AddAssign, Mul, Sub};

use nalgebra::Vector3;

/// Velocity (m/s, rad/s) or classical acceleration (m/s², rad/s²) of a body at its origin; also a joint axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Motion {
    pub(super) linear: Vector3<f64>,
    pub(super) angular: Vector3<f64>,
}

/// Force (N) and moment about the body's origin (N·m); also a momentum (kg·m/s, kg·m²/s).
#[derive(Clone, Copy, Debug)]
pub(super) struct Force {
    pub(super) linear: Vector3<f64>,
    pub(super) angular: Vector3<f64>,
}

impl Motion {
    pub(super) fn zero() -> Self {
        Self {
            linear: Vector3::zeros(),
            angular: Vector3::zeros(),
        }
    }

    /// The part of the child's motion that it shares with its parent.
    pub(super) fn at_child(&self, r: &Vector3<f64>) -> Self {
        Self {
            linear: self.linear + self.angular.cross(r),
            angular: self.angular,
        }
    }

    /// Power of a force, or its component along a joint axis.
    pub(super) fn dot(&self, force: &Force) -> f64 {
        self.linear.dot(&force.linear) + self.angular.dot(&force.angular)
    }
}

impl Force {
    pub(super) fn zero() -> Self {
        Self {
            linear: Vector3::zeros(),
            angular: Vector3::zeros(),
        }
    }

    /// The same force with its moment about the parent's origin.
    pub(super) fn at_parent(&self, r: &Vector3<f64>) -> Self {
        Self {
            linear: self.linear,
            angular: self.angular + r.cross(&self.linear),
        }
    }
}

macro_rules! vector_space {
    ($($pair:ident),*) => {$(
        impl Add for $pair {
            type Output = $pair;
            fn add(self, other: $pair) -> $pair {
                $pair {
                    linear: self.linear + other.linear,
                    angular: self.angular + other.angular,
                }
            }
        }

        impl Sub for $pair {
            type Output = $pair;
            fn sub(self, other: $pair) -> $pair {
                $pair {
                    linear: self.linear - other.linear,
                    angular: self.angular - other.angular,
                }
            }
        }

        impl AddAssign for $pair {
            fn add_assign(&mut self, other: $pair) {
                *self = *self + other;
            }
        }

        impl Mul<f64> for $pair {
            type Output = $pair;
            fn mul(self, factor: f64) -> $pair {
                $pair {
                    linear: self.linear * factor,
                    angular: self.angular * factor,
                }
            }
        }
    )*};
}
vector_space!(Motion, Force);
