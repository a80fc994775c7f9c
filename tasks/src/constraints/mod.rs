//! Constraints.

mod actuator_limits;
mod barrier;
mod contact_motion;
mod contact_wrench;
mod friction_pyramid;
mod joint_limits;
mod plane_distance;
mod thrust_rate_limits;
mod tilt_limit;

pub use actuator_limits::ActuatorLimits;
pub use contact_motion::ContactMotion;
pub use contact_wrench::ContactWrench;
pub use friction_pyramid::{Approximation, FrictionPyramid};
pub use joint_limits::JointLimits;
pub use plane_distance::PlaneDistance;
pub use thrust_rate_limits::ThrustRateLimits;
pub use tilt_limit::TiltLimit;
