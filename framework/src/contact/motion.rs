//! A surface that moves.
//!
//! # Notation
//! S is the origin of surface coordinates, a material point of the surface; C its axes.
#![allow(non_snake_case)]

use nalgebra::{Rotation3, Vector3, Vector6};

/// Pose, twist and acceleration of a surface, given to
/// [`Controller::move_surface`](crate::controller::Controller::move_surface).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceMotion {
    /// Orientation: z is the outward normal.
    pub R_WC: Rotation3<f64>,
    /// Position of the origin, m, world.
    pub p_WS: Vector3<f64>,
    /// Velocity of the origin, m/s, world axes.
    pub v_WS: Vector3<f64>,
    /// Angular velocity, rad/s, world axes.
    pub w_WC: Vector3<f64>,
    /// Acceleration of the origin, m/s², world axes.
    pub a_WS: Vector3<f64>,
    /// Angular acceleration, rad/s², world axes.
    pub alpha_WC: Vector3<f64>,
}

impl SurfaceMotion {
    /// A surface at rest.
    pub fn fixed(R_WC: Rotation3<f64>, p_WS: Vector3<f64>) -> Self {
        Self {
            R_WC,
            p_WS,
            v_WS: Vector3::zeros(),
            w_WC: Vector3::zeros(),
            a_WS: Vector3::zeros(),
            alpha_WC: Vector3::zeros(),
        }
    }

    /// Whether every number is finite.
    pub fn is_finite(&self) -> bool {
        let vectors = [self.p_WS, self.v_WS, self.w_WC, self.a_WS, self.alpha_WC];
        vectors.iter().all(|v| v.iter().all(|x| x.is_finite()))
            && self.R_WC.matrix().iter().all(|x| x.is_finite())
    }

    /// Velocity `[linear; angular]` of the material point at `p`, m world; world axes.
    pub fn velocity_at(&self, p: &Vector3<f64>) -> Vector6<f64> {
        stack(&(self.v_WS + self.w_WC.cross(&(p - self.p_WS))), &self.w_WC)
    }

    /// Acceleration `[linear; angular]` of the material point at `p`, m world; world axes.
    pub fn acceleration_at(&self, p: &Vector3<f64>) -> Vector6<f64> {
        let r = p - self.p_WS;
        let linear = self.a_WS + self.alpha_WC.cross(&r) + self.w_WC.cross(&self.w_WC.cross(&r));
        stack(&linear, &self.alpha_WC)
    }
}

fn stack(linear: &Vector3<f64>, angular: &Vector3<f64>) -> Vector6<f64> {
    Vector6::new(
        linear.x, linear.y, linear.z, angular.x, angular.y, angular.z,
    )
}
