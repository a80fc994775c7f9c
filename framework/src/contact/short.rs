//! A contact in a few words, which brings its own constraints.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{ContactKind, Surface};

/// How the motion of a contact is kept, by the constraints that it brings itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Motion {
    /// It does not move: rows that hold.
    Hard,
    /// It is kept from moving, at the price of the rows' default weight.
    Soft,
    /// It may move: only its force is limited.
    Free,
}

/// A contact as a file says it with the key `motion`: it brings its friction cone, or the wrench cone of its sole, and
/// the constraint of its motion. For [`ControllerConfig::with_contacts`](crate::ControllerConfig::with_contacts).
///
/// What is `None` has the default that it has in a file.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ShortContact {
    /// Frame E of the robot that touches.
    pub frame: String,
    /// How the motion is kept.
    motion: Motion,
    /// How tasks, constraints, logs and events call it; the frame's name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Lengths of a flat sole along the surface's x and y, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size: Option<[f64; 2]>,
    /// Which motions are constrained; `full` with a sole, `point` without.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kind: Option<ContactKind>,
    /// The surface's frame; the ground, z = 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub surface: Option<Surface>,
    /// Contact point in E, m; its origin.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub offset: Option<[f64; 3]>,
    /// Coulomb friction coefficient that the controller assumes; 0.5.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
    /// Smallest normal force while on, N; 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub force_min: Option<f64>,
    /// Largest normal force, N; 10 000.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub force_max: Option<f64>,
    /// Whether it is on at the start; it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub active: Option<bool>,
    /// Duration of the ramp when it is switched, s; 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transition: Option<f64>,
}

impl ShortContact {
    fn new(frame: impl Into<String>, motion: Motion) -> Self {
        Self {
            frame: frame.into(),
            motion,
            name: None,
            size: None,
            kind: None,
            surface: None,
            offset: None,
            friction: None,
            force_min: None,
            force_max: None,
            active: None,
            transition: None,
        }
    }

    /// A point on the ground that does not move.
    pub fn hard(frame: impl Into<String>) -> Self {
        Self::new(frame, Motion::Hard)
    }

    /// A point on the ground that is kept from moving.
    pub fn soft(frame: impl Into<String>) -> Self {
        Self::new(frame, Motion::Soft)
    }

    /// A point on the ground that may move.
    pub fn free(frame: impl Into<String>) -> Self {
        Self::new(frame, Motion::Free)
    }

    /// With a flat sole of these lengths, m, along the surface's x and y.
    pub fn with_sole(self, size: [f64; 2]) -> Self {
        Self {
            size: Some(size),
            ..self
        }
    }

    /// With this friction coefficient.
    pub fn with_friction(self, friction: f64) -> Self {
        Self {
            friction: Some(friction),
            ..self
        }
    }

    /// On another surface.
    pub fn on(self, surface: Surface) -> Self {
        Self {
            surface: Some(surface),
            ..self
        }
    }

    /// Called by another name than its frame's.
    pub fn named(self, name: impl Into<String>) -> Self {
        Self {
            name: Some(name.into()),
            ..self
        }
    }
}
