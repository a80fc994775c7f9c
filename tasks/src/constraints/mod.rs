//! Constraints.

mod actuator_limits;
mod contact_motion;
mod friction_pyramid;

pub use actuator_limits::ActuatorLimits;
pub use contact_motion::ContactMotion;
pub use friction_pyramid::{Approximation, FrictionPyramid};
