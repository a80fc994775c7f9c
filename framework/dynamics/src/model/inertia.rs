//! Mass, first moment and rotational inertia of a body about its origin.
//!
//! # Notation
//! `p_BBcm` is the centre of mass in body axes from the body's origin; `I_BBo` the rotational inertia about
//! the origin, `I_BBcm` about the centre of mass: `I_BBo = I_BBcm + m (p·p 1 − p pᵀ)`.
#![allow(non_snake_case)]

use nalgebra::{Isometry3, Matrix3, Vector3};

use super::ModelError;

/// Ten inertial parameters in the form the algorithms use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertia {
    /// Mass, kg.
    pub mass: f64,
    /// First moment `m p_BBcm`, kg·m, body axes.
    pub first_moment: Vector3<f64>,
    /// Rotational inertia about the body's **origin**, kg·m², body axes; symmetric.
    pub I_BBo: Matrix3<f64>,
}

impl Inertia {
    /// No mass at all.
    pub fn zero() -> Self {
        Self {
            mass: 0.0,
            first_moment: Vector3::zeros(),
            I_BBo: Matrix3::zeros(),
        }
    }

    /// From mass (kg), centre of mass (m) and inertia about the centre of mass (kg·m²), all in body axes.
    pub fn from_com(mass: f64, p_BBcm: Vector3<f64>, I_BBcm: Matrix3<f64>) -> Self {
        Self {
            mass,
            first_moment: p_BBcm * mass,
            I_BBo: I_BBcm + shift(mass, &p_BBcm),
        }
    }

    /// Centre of mass in body axes, m; the origin if there is no mass.
    pub fn com(&self) -> Vector3<f64> {
        if self.mass > 0.0 {
            self.first_moment / self.mass
        } else {
            Vector3::zeros()
        }
    }

    /// Rotational inertia about the centre of mass, kg·m², body axes.
    pub fn I_BBcm(&self) -> Matrix3<f64> {
        self.I_BBo - shift(self.mass, &self.com())
    }

    /// The same body seen from another frame `A` in which the body's frame has pose `X_AB`.
    pub fn transformed(&self, X_AB: &Isometry3<f64>) -> Self {
        let R_AB = X_AB.rotation.to_rotation_matrix();
        let I_cm = R_AB.matrix() * self.I_BBcm() * R_AB.matrix().transpose();
        Self::from_com(
            self.mass,
            X_AB.transform_point(&self.com().into()).coords,
            I_cm,
        )
    }

    /// Both together, about the same origin.
    pub fn merged(&self, other: &Inertia) -> Self {
        Self {
            mass: self.mass + other.mass,
            first_moment: self.first_moment + other.first_moment,
            I_BBo: self.I_BBo + other.I_BBo,
        }
    }

    /// Checks what dynamics cannot do without: numbers that are finite, and a mass that is not negative.
    ///
    /// # Errors
    /// Names `body` and what is wrong.
    pub fn check_numbers(&self, body: &str) -> Result<(), ModelError> {
        let finite = self.mass.is_finite()
            && self.first_moment.iter().all(|x| x.is_finite())
            && self.I_BBo.iter().all(|x| x.is_finite());
        let what = if !finite {
            "has a number that is not finite".to_owned()
        } else if self.mass < 0.0 {
            format!("mass is {} kg, must not be negative", self.mass)
        } else {
            return Ok(());
        };
        let body = body.to_owned();
        Err(ModelError::Inertia { body, what })
    }

    /// Checks that a rigid body could have these parameters.
    ///
    /// # Errors
    /// Names `body` and what is wrong: a number that is not finite, mass not positive, inertia about the
    /// centre of mass not symmetric, not positive definite, or against the triangle inequality.
    pub fn validate(&self, body: &str) -> Result<(), ModelError> {
        let refuse = |what: String| {
            Err(ModelError::Inertia {
                body: body.to_owned(),
                what,
            })
        };
        let finite = self.mass.is_finite()
            && self.first_moment.iter().all(|x| x.is_finite())
            && self.I_BBo.iter().all(|x| x.is_finite());
        if !finite {
            return refuse("has a number that is not finite".into());
        }
        if self.mass <= 0.0 {
            return refuse(format!("mass is {} kg, must be positive", self.mass));
        }
        let I = self.I_BBcm();
        // Finite parameters can overflow on the way to the centre of mass.
        if !I.iter().all(|x| x.is_finite()) {
            return refuse("about the centre of mass is not finite".into());
        }
        let scale = I.abs().max();
        if (I - I.transpose()).abs().max() > 1e-9 * scale {
            return refuse("is not symmetric".into());
        }
        let moments = I.symmetric_eigenvalues();
        let (small, large) = (moments.min(), moments.max());
        if small <= 0.0 {
            return refuse(format!(
                "about the centre of mass is not positive definite: smallest principal moment is {small:.3e} kg·m²"
            ));
        }
        let middle = moments.sum() - small - large;
        // A lamina meets the inequality with equality: allow for rounding in the file.
        if small + middle < large * (1.0 - 1e-6) {
            return refuse(format!(
                "breaks the triangle inequality: principal moments {small:.3e} + {middle:.3e} < {large:.3e} kg·m² \
                 (by {:.1e})",
                large - small - middle
            ));
        }
        Ok(())
    }
}

/// `m (p·p 1 − p pᵀ)`: what a point mass at `p` adds to the inertia about the origin.
fn shift(mass: f64, p: &Vector3<f64>) -> Matrix3<f64> {
    (Matrix3::identity() * p.dot(p) - p * p.transpose()) * mass
}
