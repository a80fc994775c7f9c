//! Tasks.

mod base_orientation;
mod base_position;
mod contact_force;
mod free_motion;
mod posture;
mod propeller_regularisation;

pub use base_orientation::{BaseOrientation, GainAxes, RotationError};
pub use base_position::BasePosition;
pub use contact_force::{ContactForce, Feedback, Tangential};
pub use free_motion::{FreeMotion, Origin, SurfaceAxis};
pub use posture::Posture;
pub use propeller_regularisation::PropellerRegularisation;
