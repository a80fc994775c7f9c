//! How large a robot may be: its matrices take memory with the square of its velocities.

use wbqp::model::Model;

/// Most velocities of a robot, the base's among them. A matrix of their square is 128 MB.
const MOST: usize = 4000;

/// Refuses, in words, what is larger, before a matrix is made for it.
pub(crate) fn check(model: &Model) -> Result<(), String> {
    let nv = model.nv();
    if nv <= MOST {
        return Ok(());
    }
    Err(format!(
        "has {nv} degrees of freedom, more than {MOST}; lock joints, or make them fixed"
    ))
}
