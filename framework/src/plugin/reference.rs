//! References: trajectories that tasks follow.

use std::{any::Any, borrow::Cow, fmt::Debug};

use nalgebra::{UnitQuaternion, Vector3};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

use crate::{error::BindError, plugin::Tick};

/// The space a reference lives in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Space {
    /// That many independent scalars.
    Vector(usize),
    /// Orientations. Configurations give them as roll, pitch, yaw in rad (rotations about world x, then y,
    /// then z, that is `R_z(yaw) R_y(pitch) R_x(roll)`); rates and accelerations are in world axes.
    Rotation,
}

impl Space {
    /// Number of rates: the vector's length, or 3.
    pub fn dimension(self) -> usize {
        match self {
            Self::Vector(n) => n,
            Self::Rotation => 3,
        }
    }
}

/// Value, rate and acceleration of a reference at one time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sample {
    /// The value in a vector space; left alone for rotations.
    pub value: Vec<f64>,
    /// The value for rotations; left alone in a vector space.
    pub rotation: UnitQuaternion<f64>,
    /// First derivative; angular velocity in world axes for rotations.
    pub rate: Vec<f64>,
    /// Second derivative; angular acceleration in world axes for rotations.
    pub acceleration: Vec<f64>,
}

impl Sample {
    /// At zero, or at the identity, standing still.
    pub fn new(space: Space) -> Self {
        let n = space.dimension();
        Self {
            value: vec![0.0; n],
            rotation: UnitQuaternion::identity(),
            rate: vec![0.0; n],
            acceleration: vec![0.0; n],
        }
    }

    /// This value of a vector space, standing still.
    pub fn at_rest(value: impl IntoIterator<Item = f64>) -> Self {
        let value: Vec<f64> = value.into_iter().collect();
        Self {
            value: value.clone(),
            ..Self::new(Space::Vector(value.len()))
        }
    }

    /// This orientation, standing still.
    pub fn turned(rotation: UnitQuaternion<f64>) -> Self {
        Self {
            rotation,
            ..Self::new(Space::Rotation)
        }
    }

    /// Becomes what [`Sample::new`] makes. Allocates only if there is no room.
    pub fn reset(&mut self, space: Space) {
        for numbers in [&mut self.value, &mut self.rate, &mut self.acceleration] {
            numbers.clear();
            numbers.resize(space.dimension(), 0.0);
        }
        self.rotation = UnitQuaternion::identity();
    }

    /// Rate as a 3-vector; missing components are zero.
    pub fn rate3(&self) -> Vector3<f64> {
        three(&self.rate)
    }

    /// Acceleration as a 3-vector; missing components are zero.
    pub fn acceleration3(&self) -> Vector3<f64> {
        three(&self.acceleration)
    }

    /// Value as a 3-vector; missing components are zero.
    pub fn value3(&self) -> Vector3<f64> {
        three(&self.value)
    }
}

fn three(x: &[f64]) -> Vector3<f64> {
    Vector3::from_fn(|i, _| x.get(i).copied().unwrap_or(0.0))
}

/// Where a reference takes over: given to [`Reference::bind`].
#[derive(Clone, Copy, Debug)]
pub struct Start<'a> {
    /// The space of the task.
    pub space: Space,
    /// Time at which the reference begins, s. Times in its configuration count from here.
    pub time: f64,
    /// What the task followed until now; at the first bind, the home posture's value, and in the first tick, what was
    /// measured.
    pub from: &'a Sample,
}

/// A trajectory: value, rate and acceleration as a function of time, or of what the tick knows (an
/// attitude computed from a desired force, say).
///
/// Registered by `#[wbqp::reference("tag")]` and named by `reference = { type = "tag", … }` in a task.
#[typetag::serde(tag = "type")]
pub trait Reference: Any + Send + Debug {
    /// Checks the parameters against the task's space and remembers where to start.
    ///
    /// Called when the controller is made, with the home posture's value, and, if the robot stands elsewhere, once more
    /// in the first tick, in the same space, with what was measured: that time it must not allocate.
    ///
    /// # Errors
    /// [`BindError`] when lengths or numbers do not fit.
    fn bind(&mut self, start: &Start<'_>) -> Result<(), BindError>;

    /// Writes the sample for this tick. No allocation, no panic.
    fn sample(&mut self, tick: &Tick<'_>, out: &mut Sample);
}

/// Binds the reference of a task, in the task's own `bind`: it begins at time zero from `from`, the value in the home
/// posture. Gives `from` back, as the sample that the task keeps and hands to [`Reference::sample`] in every update.
///
/// `key` is the reference's key in the task's configuration: errors name what is wrong as `key.…`.
///
/// # Errors
/// What the reference refuses.
pub fn begin(
    key: &str,
    reference: &mut dyn Reference,
    space: Space,
    from: Sample,
) -> Result<Sample, BindError> {
    let start = Start {
        space,
        time: 0.0,
        from: &from,
    };
    let inside = |inner: String| format!("{key}.{inner}");
    match reference.bind(&start) {
        Ok(()) => Ok(from),
        Err(BindError::Length { key, got, expected }) => Err(BindError::Length {
            key: inside(key),
            got,
            expected,
        }),
        Err(BindError::Value { key, problem }) => Err(BindError::Value {
            key: inside(key),
            problem,
        }),
        Err(other) => Err(other),
    }
}

/// The largest distance, m or rad, at which a robot that is measured near its home counts as at home: more than a good
/// sensor's noise, less than what can be seen.
pub const AT_HOME: f64 = 5e-3;

/// Lets a reference of vectors begin at what is measured in the first tick: in
/// [`Task::begin`](crate::plugin::Task::begin).
///
/// `sample` is where it begins now. What is measured within [`AT_HOME`] of it (the length of the difference) counts as
/// noise, and nothing changes. Values that the reference's parameters give stay.
pub fn begin_at<I>(reference: &mut dyn Reference, sample: &mut Sample, measured: I)
where
    I: IntoIterator<Item = f64>,
    I::IntoIter: Clone,
{
    let measured = measured.into_iter();
    let squares = measured
        .clone()
        .zip(&sample.value)
        .map(|(m, s)| (m - s) * (m - s));
    if squares.sum::<f64>().sqrt() <= AT_HOME {
        return;
    }
    for (value, measured) in sample.value.iter_mut().zip(measured) {
        *value = measured;
    }
    begin_anew(reference, sample, Space::Vector(sample.value.len()));
}

/// Lets a reference of orientations begin at what is measured in the first tick, as [`begin_at`] does: within
/// [`AT_HOME`] (the angle between) of where it begins now, nothing changes.
pub fn begin_turned(
    reference: &mut dyn Reference,
    sample: &mut Sample,
    measured: &UnitQuaternion<f64>,
) {
    if measured.angle_to(&sample.rotation) > AT_HOME {
        sample.rotation = *measured;
        begin_anew(reference, sample, Space::Rotation);
    }
}

/// Binds a reference once more, at rest.
fn begin_anew(reference: &mut dyn Reference, sample: &mut Sample, space: Space) {
    sample.rate.fill(0.0);
    sample.acceleration.fill(0.0);
    let start = Start {
        space,
        time: 0.0,
        from: sample,
    };
    // It was bound to this space before: what it refused, it refused then.
    let _ = reference.bind(&start);
}

/// A task's reference and where it stands: given by [`Task::follow`](crate::plugin::Task::follow), so that another
/// one can take over.
///
/// The successor is bound to [`ReferenceSlot::start`] first, and takes the place of `reference` if that succeeds.
#[derive(Debug)]
pub struct ReferenceSlot<'a> {
    /// The trajectory followed now.
    pub reference: &'a mut Box<dyn Reference>,
    /// What the task followed in its last update; before the first, where it starts.
    pub sample: &'a Sample,
    /// The space that a successor is bound to.
    pub space: Space,
}

impl ReferenceSlot<'_> {
    /// Where a successor takes over at `time` (s).
    pub fn start(&self, time: f64) -> Start<'_> {
        Start {
            space: self.space,
            time,
            from: self.sample,
        }
    }
}

impl JsonSchema for dyn Reference {
    fn schema_name() -> Cow<'static, str> {
        "Reference".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "object", "x-plugin": "reference", "required": ["type"] })
    }
}
