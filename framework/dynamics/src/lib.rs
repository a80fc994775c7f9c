//! Rigid-body dynamics: everything a control tick needs in one pass, and the plant's forward dynamics.
//!
//! ```
//! use nalgebra::{Isometry3, Matrix3, Vector3};
//! use wbqp_dynamics::{
//!     model::{Base, Inertia, ModelBuilder},
//!     state::State,
//!     Data,
//!     FrameKinematics,
//! };
//! let ball = Inertia::from_com(2.0, Vector3::zeros(), Matrix3::identity() * 0.01);
//! let mut builder = ModelBuilder::new("ball", Base::Floating, "ball", ball);
//! let base = builder.base();
//! let tip = builder.frame("tip", base, Isometry3::translation(0.1, 0.0, 0.0));
//! let model = builder.build()?;
//!
//! let mut state = State::neutral(&model);
//! state.v[5] = 3.0; // rad/s about the world's z
//! let mut data = Data::new(&model);
//! let mut kinematics = FrameKinematics::new(&model);
//! data.update(&model, &state);
//! kinematics.update(&model, &data, tip);
//!
//! assert!((data.bias()[2] - 2.0 * 9.81).abs() < 1e-12);
//! assert!((kinematics.v_WF - Vector3::new(0.0, 0.3, 0.0)).norm() < 1e-12);
//! assert!((kinematics.Jdot_v[0] + 0.9).abs() < 1e-12); // w² r, towards the axis
//! # Ok::<(), wbqp_dynamics::model::ModelError>(())
//! ```
//!
//! # Notation
//! The equation of motion is `M v̇ + h = S u + Σ Jᵀ f`: `M` the mass matrix (nv × nv), `h` Coriolis, centrifugal
//! and gravity terms, `f` what the environment does to the robot. `v = [v_WR; w_WR; q̇]` with a floating base and
//! `v = q̇` with a fixed one, so nv = 6 + joints or nv = joints.
//!
//! Everything is in **world axes**: `R` the base frame, `B` a body, `P` its parent, `F` a named frame. The
//! velocity of a body is the pair of the velocity `v_WB` of its origin and its angular velocity `w_WB`. The
//! first three of `v̇` are the *classical* acceleration of R's origin, `J̇v` is the classical acceleration of a
//! frame's origin with `v̇ = 0`: no spatial accelerations appear anywhere, so nothing has to be corrected by a
//! term `w × v`.
//!
//! # Sources
//! The algorithms are those of R. Featherstone, *Rigid Body Dynamics Algorithms* (RBDA), Springer 2008:
//! recursive Newton–Euler (section 5.3), composite rigid bodies (6.2), articulated bodies (7.3), floating base
//! (9.3–9.5), hybrid dynamics (9.2). The transform from a body to its parent is here a pure translation,
//! because all vectors are in world axes.

mod actuation;
pub mod actuator;
mod coupled;
mod data;
pub mod elementary;
mod energy;
mod forward;
mod frame;
mod inverse;
mod kinematics;
mod mass_matrix;
pub mod model;
mod servoed;
pub mod spatial;
mod spatial_inertia;
mod spatial_vector;
pub mod state;
mod wrenches;

pub use actuation::Actuation;
pub use data::Data;
pub use energy::{Energy, energy};
pub use forward::{JointDrive, forward_dynamics};
pub use frame::{FrameKinematics, FrameMotion, PointMotion, frame_motion, point_motion};
pub use inverse::inverse_dynamics;
pub use servoed::forward_dynamics_of_servos;
pub use wrenches::Wrenches;
