//! What tasks with a reference share.

use wbqp::plugin::AnyReference;

use crate::references::Hold;

/// The default reference: stay.
pub(crate) fn stay() -> Box<dyn AnyReference> {
    Box::new(Hold::default())
}

/// Component of a sample's list; zero if a reference made it too short.
pub(crate) fn component(list: &[f64], index: usize) -> f64 {
    list.get(index).copied().unwrap_or(0.0)
}
