//! Contacts: data that bring force variables, motion rows, cones and free directions into the problem.
//!
//! # Notation
//! C is a frame fixed to the surface: z is the outward normal (towards the robot), so that pushing gives
//! `f_n > 0`; its axes never turn with the end effector (erratum of the paper's (3)–(4)). The contact point
//! is the origin of the robot's frame E plus an offset in E. A wrench `[force; moment]` is what the
//! environment does to the robot, in C axes, about the contact point. `S_c` selects the constrained rows of
//! those six, `S_f` the rest.
#![allow(non_snake_case)]

mod bind;
mod components;
mod detector;
mod kind;
mod short;
mod spec;
mod state;
mod update;

pub use components::COMPONENTS;
pub use detector::Detector;
pub use kind::{ContactId, ContactKind};
pub(crate) use short::Motion;
pub use short::ShortContact;
pub use spec::{ContactSpec, FreeForce, Surface};
pub(crate) use state::{ContactBinding, SensorZero};
pub use state::{ContactState, SurfaceMotion};
