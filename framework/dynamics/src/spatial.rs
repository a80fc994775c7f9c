//! Vectors and rotations: exponential, logarithm, skew map and the two rotation errors.
//!
//! # Notation
//! `R_AB` rotates coordinates from frame B into frame A; `w` is an angular velocity. With world-aligned
//! velocities `Ṙ_WB = S(w) R_WB`, so an increment in **world** axes multiplies on the left:
//! `R_WB⁺ = exp(S(w) dt) R_WB`.
#![allow(non_snake_case)]

use std::f64::consts::PI;

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3, Vector6};

use crate::elementary;

/// A linear and an angular vector in one, the linear one first.
pub fn stack(linear: &Vector3<f64>, angular: &Vector3<f64>) -> Vector6<f64> {
    Vector6::new(
        linear.x, linear.y, linear.z, angular.x, angular.y, angular.z,
    )
}

/// Length of a vector, also where its square overflows.
pub fn length(vector: [f64; 3]) -> f64 {
    let squares = |s: f64| vector.iter().fold(0.0, |sum, x| sum + (s * x) * (s * x));
    let length = Some(squares(1.0).sqrt()).filter(|length| length.is_finite());
    length.unwrap_or_else(|| squares(1e-160).sqrt() / 1e-160)
}

/// The skew-symmetric matrix `S(x)` with `S(x) y = x × y`.
pub fn skew(x: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -x.z, x.y, x.z, 0.0, -x.x, -x.y, x.x, 0.0)
}

/// Inverse of [`skew`] on the skew-symmetric part: `½[A − Aᵀ]∨`.
pub fn vee(A: &Matrix3<f64>) -> Vector3<f64> {
    Vector3::new(
        0.5 * (A[(2, 1)] - A[(1, 2)]),
        0.5 * (A[(0, 2)] - A[(2, 0)]),
        0.5 * (A[(1, 0)] - A[(0, 1)]),
    )
}

/// `exp(S(x))` as a unit quaternion; `x` is a rotation vector in rad.
pub fn exp(x: &Vector3<f64>) -> UnitQuaternion<f64> {
    let angle = x.norm();
    let (sin, cos) = elementary::sin_cos(0.5 * angle);
    // The limit of sin(angle / 2) / angle.
    let ratio = if angle > 0.0 { sin / angle } else { 0.5 };
    UnitQuaternion::new_unchecked(Quaternion::from_parts(cos, x * ratio))
}

/// The rotation vector `log(R)∨`, rad, of magnitude at most π.
pub fn log(R: &UnitQuaternion<f64>) -> Vector3<f64> {
    let sin = R.imag().norm();
    if sin <= 0.0 {
        return Vector3::zeros();
    }
    // Of the two quaternions of a rotation the one of the shorter way.
    let angle = 2.0 * elementary::atan2(sin, R.w.abs());
    let sign = if R.w < 0.0 { -1.0 } else { 1.0 };
    R.imag() * (sign * angle / sin)
}

/// Limits on an angle below this, rad, are too near to rounding for the short way of [`angle_above`].
const SMALL: f64 = 1e-6;

/// The angle between two orientations, rad, if it is above a limit; neither need be of unit length.
///
/// `θ ≤ π sin ½θ` tells most of those that are below it without an arctangent: the sine follows from the product of the
/// two quaternions, `cos ½θ = a·b / (‖a‖ ‖b‖)`, as far as it is more than rounding.
pub fn angle_above(
    R_WA: &UnitQuaternion<f64>,
    R_WB: &UnitQuaternion<f64>,
    limit: f64,
) -> Option<f64> {
    let (a, b) = (&R_WA.coords, &R_WB.coords);
    let (along, square) = (a.dot(b), a.norm_squared() * b.norm_squared());
    let sine_squared = (square - along * along) / square;
    if limit > SMALL && PI * PI * sine_squared <= limit * limit {
        return None;
    }
    let angle = R_WA.angle_to(&UnitQuaternion::new_normalize(**R_WB));
    (angle > limit).then_some(angle)
}

/// Rotation error in world axes from the matrices, `e_W = ½[R R_dᵀ − R_d Rᵀ]∨` (rad for small angles).
///
/// Its magnitude is `sin θ`: it grows until 90° and vanishes again at 180°. The error of the paper's (11)
/// has the wrong sign; this is the correct form for angular velocities in world axes (`w = … − K_P e_W`).
pub fn error_matrix(R_WB: &UnitQuaternion<f64>, R_WD: &UnitQuaternion<f64>) -> Vector3<f64> {
    let E = R_WB.to_rotation_matrix() * R_WD.to_rotation_matrix().transpose();
    vee(E.matrix())
}

/// Rotation error in world axes from the logarithm, `e_W = log(R R_dᵀ)∨`, rad, monotone up to 180°.
pub fn error_log(R_WB: &UnitQuaternion<f64>, R_WD: &UnitQuaternion<f64>) -> Vector3<f64> {
    log(&(R_WB * R_WD.inverse()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponential_and_logarithm_are_those_of_the_library_of_quaternions() {
        let axis = Vector3::new(0.4, -0.9, 0.3).normalize();
        for angle in [0.0, 1e-300, 1e-12, 0.3, 1.5, 3.0, 3.1, 4.0, 6.2, -2.0] {
            let x = axis * angle;
            let R = exp(&x);
            let expected = UnitQuaternion::from_scaled_axis(x);
            assert!((R.coords - expected.coords).norm() < 1e-15, "{angle}");
            assert!((log(&R) - R.scaled_axis()).norm() < 1e-14, "{angle}");
            assert!(log(&R).norm() <= std::f64::consts::PI, "{angle}");
        }
    }

    #[test]
    fn lengths_are_those_of_the_library_and_do_not_overflow() {
        for size in [0.0, 1e-300, 1e-3, 1.0, 1e150, 1e300] {
            let expected = size * Vector3::new(2.0, -3.0, 6.0).norm();
            let found = length([2.0 * size, -3.0 * size, 6.0 * size]);
            // Squares of what is as small as 1e-300 are nothing.
            let expected = if size == 1e-300 { 0.0 } else { expected };
            assert!((found - expected).abs() <= 1e-14 * expected, "{size}");
        }
        assert!(length([f64::NAN, 0.0, 0.0]).is_nan());
        assert_eq!(length([f64::INFINITY, 0.0, 0.0]), f64::INFINITY);
    }

    #[test]
    fn an_angle_above_a_limit_is_the_library_s_and_one_below_is_none() {
        let R_WA = exp(&Vector3::new(0.4, -0.9, 0.3));
        let axis = Vector3::new(-0.2, 0.5, 0.7).normalize();
        let angles = [0.0, 1e-9, 1e-7, 1e-6, 1e-3, 0.3, 1.5, 3.0, 3.13];
        for angle in angles {
            let R_WB = R_WA * exp(&(axis * angle));
            for size in [0.9, 1.0, 1.1, -1.0] {
                let R_WB = UnitQuaternion::new_unchecked(*R_WB * size);
                for limit in angles {
                    for limit in [limit, 0.99 * limit, 1.01 * limit, 0.6 * limit, 1.6 * limit] {
                        let expected = R_WA.angle_to(&UnitQuaternion::new_normalize(*R_WB));
                        let expected = Some(expected).filter(|angle| *angle > limit);
                        assert_eq!(
                            angle_above(&R_WA, &R_WB, limit),
                            expected,
                            "{angle} {limit}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn errors_point_from_desired_to_actual_and_agree_for_small_angles() {
        let R_WD = exp(&Vector3::new(0.4, -0.9, 0.3));
        let d = Vector3::new(2e-4, -1e-4, 3e-4);
        let R_WB = exp(&d) * R_WD;
        assert!((error_log(&R_WB, &R_WD) - d).norm() < 1e-12);
        assert!((error_matrix(&R_WB, &R_WD) - d).norm() < 1e-10);
    }

    #[test]
    fn matrix_error_is_the_sine_of_the_angle() {
        let R_WD = exp(&Vector3::new(0.1, 0.2, 0.3));
        for angle in [0.3, 1.0, 2.0, 3.1_f64] {
            let R_WB = exp(&(Vector3::y() * angle)) * R_WD;
            assert!((error_matrix(&R_WB, &R_WD) - Vector3::y() * angle.sin()).norm() < 1e-12);
            assert!((error_log(&R_WB, &R_WD) - Vector3::y() * angle).norm() < 1e-12);
        }
    }

    #[test]
    fn vee_inverts_skew() {
        let x = Vector3::new(1.0, -2.0, 3.0);
        assert_eq!(vee(&skew(&x)), x);
    }
}
