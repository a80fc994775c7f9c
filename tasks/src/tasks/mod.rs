//! Tasks.

mod base_orientation;
mod base_position;
mod centroidal_angular_momentum;
mod com;
mod constant_force;
mod contact_force;
mod frame_orientation;
mod frame_pose;
mod frame_position;
mod free_motion;
mod joint_torque_regularisation;
mod posture;
mod propeller_regularisation;
mod relative_pose;
mod thrust_regularisation;

pub use base_orientation::{BaseOrientation, GainAxes, RotationError};
pub use base_position::BasePosition;
pub use centroidal_angular_momentum::CentroidalAngularMomentum;
pub use com::Com;
pub use constant_force::ConstantForce;
pub use contact_force::{ContactForce, Feedback, Tangential};
pub use frame_orientation::FrameOrientation;
pub use frame_pose::FramePose;
pub use frame_position::FramePosition;
pub use free_motion::{FreeMotion, Origin, SurfaceAxis};
pub use joint_torque_regularisation::JointTorqueRegularisation;
pub use posture::Posture;
pub use propeller_regularisation::PropellerRegularisation;
pub use relative_pose::RelativePose;
pub use thrust_regularisation::ThrustRegularisation;

pub(crate) use thrust_regularisation::chosen_rotors;
