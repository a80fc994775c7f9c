//! How large a robot and its numbers may be: matrices take memory with the square of its velocities.

use wbqp::model::Model;

/// Most velocities of a robot, the base's among them. A matrix of their square is 128 MB.
const MOST: usize = 4000;

/// Largest magnitude of a length, mass, inertia and so on, SI. Beyond it products overflow; no robot is near it.
pub(crate) const LARGEST_NUMBER: f64 = 1e9;

/// Smallest mass that is not zero, kg: a speck of dust. Quotients by less overflow.
pub(crate) const SMALLEST_MASS: f64 = 1e-12;

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
