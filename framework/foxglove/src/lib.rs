//! 3-D logs and live views of whole-body QP controllers, for [Foxglove](https://foxglove.dev).
//!
//! [`SceneLog`] writes what a 3-D view needs beside the topics of [`ControllerLog`](wbqp_log::ControllerLog): poses of
//! all frames, the robot's shapes, rotors with their thrusts, walls, contact forces with their friction cones,
//! references. `LiveView` (feature `live`) serves the same topics to programs that speak Foxglove's WebSocket
//! protocol, and takes changes of weights, gains, references and switches from them.
//!
//! | topic | type | contents |
//! |---|---|---|
//! | `/tf` | `foxglove.FrameTransforms` | poses of the bodies, each in its parent's frame; the base in `world` |
//! | `/tf_static` | `foxglove.FrameTransforms` | poses of frames that are fixed to bodies |
//! | `/scene` | `foxglove.SceneUpdate` | thrusts, contact forces, cones, walls, unknown wrench |
//! | `/scene/robot` | `foxglove.SceneUpdate` | shapes of the links, limits of the rotors |
//! | `/reference` | `foxglove.PosesInFrame` | where tasks want points to be |
//! | `/contact/<name>/forces` | `wbqp.ContactForces` | planned, measured and true force, world axes |
//! | `/robot_description` | JSON, `std_msgs/String` | the URDF |
//!
//! Lengths of arrows: a thrust is as long as its share of the largest thrust of all rotors, times 0.3 m; a contact
//! force as its share of the robot's weight, times 1 m.
//!
//! ```
//! use wbqp_foxglove::SceneLog;
//! use wbqp_log::MemoryLog;
//! # use wbqp::{Controller, ControllerConfig};
//! # fn run(mut controller: Controller) -> Result<(), wbqp_log::LogError> {
//! let mut log = MemoryLog::default(); // or a `McapLog`
//! let mut scene = SceneLog::new(&controller, &mut log)?;
//! let (measurement, mut snapshot) = (controller.measurement(), controller.snapshot());
//! controller.tick(&measurement);
//! snapshot.take(&controller, &measurement);
//! scene.record(&snapshot, &[], &mut log)?;
//! # Ok(())
//! # }
//! ```

mod convert;
mod forces;
mod frames;
#[cfg(feature = "live")]
mod live;
mod scene;
mod scene_log;
mod shapes;
mod skeleton;

pub use forces::ContactForces;
#[cfg(feature = "live")]
pub use live::{LiveError, LiveView};
pub use scene_log::SceneLog;
