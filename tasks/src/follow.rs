//! What tasks with a reference share.

use wbqp::{
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
    let start = Start {
        space,
        time: 0.0,
        from: &from,
    };
    let inside = |key: String| format!("reference.{key}");
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
