//! What a configuration says about a contact.
#![allow(non_snake_case)]

use nalgebra::{Matrix3, Rotation3, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::ContactKind;
use crate::error::BindError;

/// What is put into the dynamics for the forces in the free directions (`f_f` of (5a)).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FreeForce {
    /// Nothing. Right where the free directions are moments, whose measurement is mostly noise.
    #[default]
    Zero,
    /// The measured force, translations only, low-passed and clipped to `free_force_limit`.
    Measured,
}

/// The surface's frame C.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Surface {
    /// Outward normal in world axes (towards the robot); normalised when read.
    pub normal: [f64; 3],
    /// Direction of the surface's x axis in world axes; projected onto the surface.
    pub x_axis: [f64; 3],
    /// A point of the surface, m, world: the origin of surface coordinates.
    #[serde(default)]
    #[schemars(extend("x-unit" = "m"))]
    pub origin: [f64; 3],
}

impl Surface {
    /// `R_WC` with z the normal and x the projected `x_axis`.
    ///
    /// # Errors
    /// If the normal is zero, a number is not finite, or `x_axis` is parallel to the normal.
    pub fn rotation(&self) -> Result<Rotation3<f64>, BindError> {
        let z = Vector3::from(self.normal);
        let x = Vector3::from(self.x_axis);
        let finite = self
            .normal
            .iter()
            .chain(&self.x_axis)
            .chain(&self.origin)
            .all(|v| v.is_finite());
        let unusable = || {
            BindError::value(
                "surface",
                "needs finite numbers and a normal that is not zero",
            )
        };
        if !finite {
            return Err(unusable());
        }
        let z = z.try_normalize(1e-9).ok_or_else(unusable)?;
        let x = (x - z * z.dot(&x)).try_normalize(1e-6).ok_or_else(|| {
            BindError::value("surface.x_axis", "must not be parallel to the normal")
        })?;
        let y = z.cross(&x);
        Ok(Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[
            x, y, z,
        ])))
    }
}

/// A contact between a frame of the robot and a surface of the world.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactSpec {
    /// How tasks, constraints, logs and events call it.
    pub name: String,
    /// Frame E of the robot that touches.
    pub frame: String,
    /// Contact point in E, m.
    #[serde(default)]
    #[schemars(extend("x-unit" = "m"))]
    pub offset: [f64; 3],
    /// Which motions are constrained.
    pub kind: ContactKind,
    /// The surface's frame.
    pub surface: Surface,
    /// Coulomb friction coefficient that the controller assumes.
    #[serde(default = "default_friction")]
    #[schemars(extend("x-unit" = "1"))]
    pub friction: f64,
    /// Smallest normal force while on, N.
    #[serde(default = "default_force_min")]
    #[schemars(extend("x-unit" = "N"))]
    pub force_min: f64,
    /// Largest normal force, N.
    #[serde(default = "default_force_max")]
    #[schemars(extend("x-unit" = "N"))]
    pub force_max: f64,
    /// What is assumed of the force in the free directions.
    #[serde(default)]
    pub free_force: FreeForce,
    /// Clip of the measured free force, N, per axis.
    #[serde(default = "default_free_force_limit")]
    #[schemars(extend("x-unit" = "N"))]
    pub free_force_limit: f64,
    /// Cut-off of the first-order low-pass on the measured free force, Hz; `inf` for no filter.
    #[serde(default = "default_free_force_cutoff")]
    #[schemars(extend("x-unit" = "Hz"))]
    pub free_force_cutoff: f64,
    /// Whether the contact is on at the start.
    #[serde(default)]
    pub active: bool,
    /// Duration of the ramp when it is switched on or off, s.
    #[serde(default)]
    #[schemars(extend("x-unit" = "s"))]
    pub transition: f64,
}

fn default_friction() -> f64 {
    0.5
}
fn default_force_min() -> f64 {
    0.0
}
fn default_force_max() -> f64 {
    1e3
}
fn default_free_force_cutoff() -> f64 {
    15.0
}
fn default_free_force_limit() -> f64 {
    20.0
}

impl ContactSpec {
    /// A contact that is off at the start, with the default friction and limits.
    pub fn new(name: &str, frame: &str, kind: ContactKind, surface: Surface) -> Self {
        Self {
            name: name.to_owned(),
            frame: frame.to_owned(),
            offset: [0.0; 3],
            kind,
            surface,
            friction: default_friction(),
            force_min: default_force_min(),
            force_max: default_force_max(),
            free_force: FreeForce::default(),
            free_force_limit: default_free_force_limit(),
            free_force_cutoff: default_free_force_cutoff(),
            active: false,
            transition: 0.0,
        }
    }

    /// Checks the numbers.
    ///
    /// # Errors
    /// Names the key: friction or limits negative, not finite or reversed, a bad surface.
    pub fn validate(&self) -> Result<(), BindError> {
        for (key, value) in [
            ("friction", self.friction),
            ("force_min", self.force_min),
            ("force_max", self.force_max),
            ("free_force_limit", self.free_force_limit),
            ("transition", self.transition),
        ] {
            if !value.is_finite() || value < 0.0 {
                return Err(BindError::value(
                    key,
                    format!("is {value}, must be finite and not negative"),
                ));
            }
        }
        if self.free_force_cutoff.is_nan() || self.free_force_cutoff <= 0.0 {
            return Err(BindError::value(
                "free_force_cutoff",
                format!("is {} Hz, must be positive", self.free_force_cutoff),
            ));
        }
        if self.force_max <= self.force_min {
            return Err(BindError::value(
                "force_max",
                format!(
                    "is {}, must be above force_min = {}",
                    self.force_max, self.force_min
                ),
            ));
        }
        if !self.offset.iter().all(|x| x.is_finite()) {
            return Err(BindError::value(
                "offset",
                "has a number that is not finite",
            ));
        }
        self.surface.rotation().map(|_| ())
    }
}
