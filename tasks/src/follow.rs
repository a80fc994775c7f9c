//! What tasks with a reference share.

use wbqp::plugin::AnyReference;

use crate::references::Hold;

/// The default reference: stay.
pub(crate) fn stay() -> Box<dyn AnyReference> {
    Box::new(Hold::default())
}
