//! References: the trajectories that tasks follow.
//!
//! A task declares in `bind` that it follows one, in which space, and what is measured of it
//! ([`Setup::follow_vector`](crate::plugin::Setup::follow_vector) and its like); the framework binds it, lets it begin
//! at what is measured, samples it before each update of the task, and replaces it while running.

use std::{any::Any, borrow::Cow, fmt::Debug};

use nalgebra::{UnitQuaternion, Vector3};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

use crate::{
    error::BindError,
    plugin::{BoundReference, Tick},
};

/// A trajectory: value, rate and acceleration as a function of time, or of what the tick knows (an
/// attitude computed from a desired force, say).
///
/// The type that implements it is its parameters, with the attribute [`reference`](macro@crate::reference), and named
/// by `reference = { type = "tag", … }` in a task. What it remembers is [`Reference::Running`].
pub trait Reference: AnyReference + Clone {
    /// Whatever is not a parameter: where it begins, buffers.
    type Running: Debug + Send + 'static;

    /// Checks the parameters against the task's space, and makes room for what is remembered.
    ///
    /// # Errors
    /// [`BindError`] when lengths or numbers do not fit.
    fn bind(&self, space: Space) -> Result<Self::Running, BindError>;

    /// Takes over where another one, or the robot, stands; any number of times. It begins at `time`, s, from which
    /// times in its configuration count; `from` is what the task followed until then, at the start what was measured.
    /// Called after [`bind`](Reference::bind), with zero or the identity and then with the home posture's value, in the
    /// first tick with what was measured if the robot stands elsewhere, and for one that replaces another. No
    /// allocation, no panic.
    fn start(&self, running: &mut Self::Running, time: f64, from: &Sample);

    /// Writes the sample for this tick, which is of the space it was bound to. No allocation, no panic.
    fn sample(&self, running: &mut Self::Running, tick: &Tick<'_>, out: &mut Sample);

    /// The values that its parameters name, each with its key. Of a reference that prescribes a normal force, N, one
    /// below zero or above the contact's `force_max` is refused before it is followed.
    fn values(&self) -> Vec<(String, &[f64])> {
        Vec::new()
    }
}

/// Value, rate and acceleration of a reference at one time.
#[derive(Clone, Debug, PartialEq)]
pub enum Sample {
    /// In a [`Space::Vector`](super::Space::Vector).
    Vector(VectorSample),
    /// In [`Space::Rotation`](super::Space::Rotation).
    Rotation(RotationSample),
}

/// Value, rate and acceleration of a vector. The three have the same length.
#[derive(Clone, Debug, PartialEq)]
pub struct VectorSample {
    /// The value, in the task's unit.
    pub value: Vec<f64>,
    /// Its first derivative.
    pub rate: Vec<f64>,
    /// Its second derivative.
    pub acceleration: Vec<f64>,
}

/// Orientation, angular velocity and acceleration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotationSample {
    /// The orientation.
    pub rotation: UnitQuaternion<f64>,
    /// Angular velocity, rad/s, in the axes that the rotation leads to (world axes of `R_WB`).
    pub rate: Vector3<f64>,
    /// Angular acceleration, rad/s², in the same axes.
    pub acceleration: Vector3<f64>,
}

/// Any reference: what a task's parameters hold. Implemented by the attribute
/// [`reference`](macro@crate::reference).
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no reference that files can name",
    label = "without the attribute `#[wbqp::reference(\"…\")]`",
    note = "write `#[wbqp::reference(\"PREFIX.NAME\")]` above its definition; that derives `Clone` and `Debug`, too"
)]
#[typetag::serialize(tag = "type")]
pub trait AnyReference: Any + Send + Debug {
    /// Binds the reference, as [`Reference::bind`].
    ///
    /// # Errors
    /// What the reference refuses.
    fn bind_any(&self, space: Space) -> Result<BoundReference, BindError>;

    /// As [`Reference::values`].
    fn named_values(&self) -> Vec<(String, &[f64])> {
        Vec::new()
    }

    /// A copy.
    fn boxed(&self) -> Box<dyn AnyReference>;
}

impl Clone for Box<dyn AnyReference> {
    fn clone(&self) -> Self {
        (**self).boxed()
    }
}

impl<R: AnyReference> From<R> for Box<dyn AnyReference> {
    fn from(reference: R) -> Self {
        Box::new(reference)
    }
}

impl JsonSchema for dyn AnyReference {
    fn schema_name() -> Cow<'static, str> {
        "Reference".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "object", "x-plugin": "reference", "required": ["type"] })
    }
}

/// What the values of a task are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Space {
    /// That many independent scalars.
    Vector(usize),
    /// Orientations. Configurations give them as roll, pitch, yaw in rad (rotations about world x, then y,
    /// then z, that is `R_z(yaw) R_y(pitch) R_x(roll)`); rates and accelerations are in world axes.
    Rotation,
}

impl Sample {
    /// At zero, or at the identity, standing still.
    pub fn new(space: Space) -> Self {
        match space {
            Space::Vector(n) => Self::at_rest(std::iter::repeat_n(0.0, n)),
            Space::Rotation => Self::turned(UnitQuaternion::identity()),
        }
    }

    /// This value of a vector space, standing still.
    pub fn at_rest(value: impl IntoIterator<Item = f64>) -> Self {
        Self::Vector(VectorSample::at_rest(value))
    }

    /// This orientation, standing still.
    pub fn turned(rotation: UnitQuaternion<f64>) -> Self {
        Self::Rotation(RotationSample::at_rest(rotation))
    }

    /// The space that it is of.
    pub fn space(&self) -> Space {
        match self {
            Self::Vector(sample) => Space::Vector(sample.value.len()),
            Self::Rotation(_) => Space::Rotation,
        }
    }
}

impl VectorSample {
    /// This value, standing still.
    pub fn at_rest(value: impl IntoIterator<Item = f64>) -> Self {
        let value: Vec<f64> = value.into_iter().collect();
        let zeros = vec![0.0; value.len()];
        Self {
            value,
            rate: zeros.clone(),
            acceleration: zeros,
        }
    }
}
