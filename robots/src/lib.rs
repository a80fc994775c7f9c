//! URDF and rotor descriptions for wbqp, and the robots that ship with it.
//!
//! A robot is a URDF file, which any vendor's tool can write, and, if it flies, a rotor parameter file that says
//! which of its frames carry rotors. [`from_files`] reads both into a
//! [`RobotModel`](wbqp::robot::RobotModel); [`othex`], [`othex_vertical`], [`quadruped`] and [`humanoid`]
//! need no files.
//!
//! ```
//! let robot = wbqp_robots::othex()?;
//! assert_eq!(robot.nu(), 9); // six rotors, then three joints
//! assert!((robot.model.mass() - 2.91933).abs() < 1e-5);
//! # Ok::<(), wbqp::robot::RobotError>(())
//! ```
//!
//! What other tools of the field read is read. Nothing is repaired in silence: every irregularity is a
//! [`Diagnostic`](wbqp::robot::Diagnostic) with file, line, element, what was done about it and how to say otherwise.
//! What has no meaning is refused, all of a file's errors at once; [`Options::strict`] refuses the rest too.
//!
//! * [`urdf`]: what is read from a URDF and what is refused
//! * [`rotors`]: the keys of a rotor parameter file
//! * [`tree`]: a robot as plain data, for programs that read other formats
//! * [`visuals`]: what a robot looks like, for programs that draw it
//! * [`Options`]: what neither file says: floating or fixed, servoed joints, home posture

mod direction;
mod library;
mod options;
mod plugins;
mod rotor_doubts;
mod rotor_keys;
mod rotor_limits;
pub mod rotors;
mod size;
mod source;
mod srdf;
pub mod tree;
pub mod urdf;
pub mod visuals;
mod xml;

pub use library::{
    RobotFiles, from_files, from_sources, humanoid, othex, othex_vertical, quadruped,
};
pub use options::{BaseKind, LinkInertia, MimicKind, Options};
pub use plugins::{Home, Humanoid, Othex, OthexVertical, Quadruped, Urdf};
pub use tree::Tree;
