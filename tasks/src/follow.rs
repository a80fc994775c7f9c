//! What tasks with a reference share.

use wbqp::{
    nalgebra::UnitQuaternion,
    reference::{Reference, Sample, Space, Start},
    setup::BindError,
};

use crate::references::Hold;

/// The default reference: stay.
pub(crate) fn stay() -> Box<dyn Reference> {
    Box::new(Hold::default())
}

/// Binds a task's reference at time zero and hands `from` back as the task's first sample. Errors name keys of the
/// reference as `reference.key`.
pub(crate) fn begin(
    reference: &mut dyn Reference,
    space: Space,
    from: Sample,
) -> Result<Sample, BindError> {
    begin_as("reference", reference, space, from)
}

/// Like [`begin`], for a reference under another key.
pub(crate) fn begin_as(
    key: &str,
    reference: &mut dyn Reference,
    space: Space,
    from: Sample,
) -> Result<Sample, BindError> {
    let outer = key;
    let start = Start {
        space,
        time: 0.0,
        from: &from,
    };
    let inside = |key: String| format!("{outer}.{key}");
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

/// A sample at rest with this orientation.
pub(crate) fn turned(rotation: UnitQuaternion<f64>) -> Sample {
    Sample {
        rotation,
        ..Sample::new(Space::Rotation)
    }
}

/// A sample at rest with this value, in a vector space.
pub(crate) fn at_rest(value: impl IntoIterator<Item = f64>) -> Sample {
    let value: Vec<f64> = value.into_iter().collect();
    Sample {
        value: value.clone(),
        ..Sample::new(Space::Vector(value.len()))
    }
}

/// Component of a sample's list; zero if a reference made it too short.
pub(crate) fn component(list: &[f64], index: usize) -> f64 {
    list.get(index).copied().unwrap_or(0.0)
}
