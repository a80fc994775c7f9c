//! Reference generators.
//!
//! Values of rotations are `[roll, pitch, yaw]` in rad, `R_z(yaw) R_y(pitch) R_x(roll)`; their rates and
//! accelerations are in world axes. Times count from where the reference takes over. [`ThrustAttitude`] alone does not
//! depend on time but on what the tick knows.

mod ellipse;
mod hold;
mod leg;
mod min_jerk;
mod thrust_attitude;
mod waypoints;

pub use ellipse::Ellipse;
pub use hold::Hold;
pub use min_jerk::MinJerk;
pub use thrust_attitude::ThrustAttitude;
pub use waypoints::{Waypoint, Waypoints};
