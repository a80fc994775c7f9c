//! What a crate of plug-ins needs: `use wbqp::prelude::*;`.
//!
//! ```
//! use wbqp::prelude::*;
//!
//! /// Keeps a frame level, the head of a robot, say.
//! #[wbqp::task("example.level")]
//! pub struct Level {
//!     /// The frame.
//!     frame: String,
//!     /// Stiffness, 1/s².
//!     #[wbqp(default = 40.0)]
//!     kp: f64,
//! }
//!
//! impl Task for Level {
//!     type Running = FrameHandle;
//!
//!     fn bind(&self, setup: &mut Setup<'_>) -> Result<(Layout, FrameHandle), BindError> {
//!         let frame = setup.frame(&self.frame)?;
//!         let rows = Layout::rows([("about x", "rad/s²"), ("about y", "rad/s²")]).error_unit("rad");
//!         Ok((rows.vdot_frame(frame, [3, 4]), frame))
//!     }
//!
//!     fn update(&self, frame: &mut FrameHandle, tick: &Tick<'_>, rows: &mut Rows<'_>) {
//!         let frame = tick.frame(*frame);
//!         let tilt = Vector3::z().cross(&(frame.R_WF * Vector3::z()));
//!         for k in 0..2 {
//!             rows.motion(k, MotionRow::to_rest(tilt[k], frame.w_WF[k], self.kp));
//!         }
//!     }
//! }
//! ```

pub use nalgebra::{self, DVector, Matrix3, Rotation3, UnitQuaternion, Vector3, Vector6};
pub use schemars::{self, JsonSchema};
pub use serde::{self, Deserialize, Serialize};

pub use crate::{
    contact::ContactId,
    error::BindError,
    plugin::{
        AnyReference, Constraint, ConstraintLayout, ConstraintRows, FallbackLaw, FrameHandle,
        Layout, MotionRow, PerRow, Reference, Remembered, RotationReference, Rows, Sample, Setup,
        Space, Task, Tick, VectorReference,
    },
};
pub use wbqp_dynamics::{
    actuator::ActuatorId,
    model::{JointId, VelocityId},
};
