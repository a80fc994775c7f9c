//! Inertial parameters of a link that replace the file's.
#![allow(non_snake_case)]

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use wbqp::{
    model::Inertia,
    nalgebra::{Matrix3, Vector3},
};

use crate::size::{LARGEST_NUMBER, SMALLEST_MASS};

/// Mass, centre of mass and rotational inertia of a link, in its own frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LinkInertia {
    /// kg, not negative.
    #[schemars(extend("x-unit" = "kg"))]
    pub mass: f64,
    /// Centre of mass in the link's frame, m.
    #[serde(default)]
    #[schemars(extend("x-unit" = "m"))]
    pub com: [f64; 3],
    /// `[ixx, iyy, izz]` about the centre of mass, axes of the link, kg·m².
    #[schemars(extend("x-unit" = "kg·m²"))]
    pub moments: [f64; 3],
    /// `[ixy, ixz, iyz]` about the centre of mass, kg·m².
    #[serde(default)]
    #[schemars(extend("x-unit" = "kg·m²"))]
    pub products: [f64; 3],
}

impl LinkInertia {
    /// What no link can have, in words.
    pub(crate) fn problem(&self) -> Option<String> {
        let Self {
            mass,
            com,
            moments,
            products,
        } = *self;
        if !mass.is_finite() || mass < 0.0 {
            return Some(format!(
                "mass is {mass} kg, must be finite and not negative"
            ));
        }
        if mass > LARGEST_NUMBER || (mass > 0.0 && mass < SMALLEST_MASS) {
            return Some(format!(
                "mass is {mass:e} kg, must be 0 or from {SMALLEST_MASS:e} to {LARGEST_NUMBER:e} kg"
            ));
        }
        let numbers = [("com", com), ("moments", moments), ("products", products)];
        numbers.into_iter().find_map(|(key, values)| {
            let is_wrong = |x: &&f64| !x.is_finite() || x.abs() > LARGEST_NUMBER;
            let wrong = values.iter().find(is_wrong)?;
            Some(format!(
                "{key} has {wrong:e}, must be finite and at most {LARGEST_NUMBER:e} (SI units)"
            ))
        })
    }

    pub(crate) fn inertia(&self) -> Inertia {
        let [ixx, iyy, izz] = self.moments;
        let [ixy, ixz, iyz] = self.products;
        let I_cm = Matrix3::new(
            ixx, ixy, ixz, //
            ixy, iyy, iyz, //
            ixz, iyz, izz,
        );
        Inertia::from_com(self.mass, Vector3::from(self.com), I_cm)
    }
}
