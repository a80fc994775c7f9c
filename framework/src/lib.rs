//! Whole-body control of robots by quadratic programming.
//!
//! Describe a robot, list tasks and constraints, and call [`Controller::tick`] once per control period: it
//! returns the actuator command that minimises the weighted squares of the tasks' residuals under the robot's
//! dynamics, the constraints and the actuators' limits, and a [`Report`] that says how. It always returns a
//! command, within the actuators' limits: if limits contradict one another, a measurement is not finite or there is no
//! solution, it comes from a lower level ([`controller::FallbackLevel`]), and the report says so. Rotors are actuators
//! like joint motors, so the same code controls a flying robot, a legged one and a fixed arm. This crate contains no
//! robot and no task.
//!
//! # Example
//! A task is a plug-in: a struct of parameters with the attribute [`task`](macro@task). This one holds a joint of an
//! arm of one link, which is built in code; a URDF is read by the crate `wbqp-robots`.
//!
//! ```
//! use std::path::Path;
//!
//! use wbqp::{
//!     actuator::{Actuator, ActuatorKind, Drive, JointMotor},
//!     controller::FallbackLevel,
//!     model::{Base, Inertia, Joint, JointKind, JointLimits, ModelBuilder},
//!     nalgebra::Isometry3,
//!     prelude::*,
//!     robot::{Robot, RobotError, RobotModel},
//!     state::State,
//!     Controller,
//!     ControllerConfig,
//!     Measurement,
//! };
//!
//! /// A link of 1 kg, whose centre of mass is 0.5 m from a motor that turns about the world's y.
//! #[wbqp::parameters]
//! struct OneLink {}
//!
//! #[wbqp::robot("example.one_link")]
//! impl Robot for OneLink {
//!     fn load(&self, _: &Path) -> Result<RobotModel, RobotError> {
//!         let limits = JointLimits { lower: -3.0, upper: 3.0, velocity: 5.0, effort: 10.0 };
//!         let axis = Vector3::y_axis();
//!         let joint = Joint::new("elbow", JointKind::Revolute, axis, Isometry3::identity(), limits);
//!         let link = Inertia::from_com(1.0, Vector3::x() * 0.5, Matrix3::identity() * 0.01);
//!         let base = Inertia::from_com(1.0, Vector3::zeros(), Matrix3::identity() * 0.01);
//!         let mut builder = ModelBuilder::new("one_link", Base::Fixed, "base", base);
//!         let parent = builder.base();
//!         builder.body(parent, joint, "link", link);
//!         let refused = |source| RobotError::Model { file: "example.one_link".into(), source };
//!         let model = builder.build().map_err(refused)?;
//!         let motor = model.joint("elbow").map(|joint| Actuator {
//!             name: "elbow".into(),
//!             kind: ActuatorKind::Joint(JointMotor { joint, drive: Drive::Torque }),
//!             lower: -10.0, // N·m
//!             upper: 10.0,
//!             slew: f64::INFINITY,
//!         });
//!         let home = State::neutral(&model);
//!         Ok(RobotModel::new(model, motor.into_iter().collect(), home))
//!     }
//! }
//!
//! /// Brings one joint to a position: `q̈ = −kd q̇ − kp (q − target)`.
//! #[wbqp::task("example.hold_joint")]
//! struct HoldJoint {
//!     joint: String,
//!     /// rad.
//!     target: f64,
//!     /// 1/s².
//!     kp: f64,
//!     /// 1/s.
//!     kd: f64,
//! }
//!
//! impl Task for HoldJoint {
//!     // What was resolved once.
//!     type Running = (JointId, VelocityId);
//!
//!     fn bind(&self, setup: &mut Setup<'_>) -> Result<(Layout, Self::Running), BindError> {
//!         let joint = setup.joint(&self.joint)?;
//!         let velocity = setup.velocity(joint);
//!         // One row, a coefficient of 1 on that joint's acceleration.
//!         let rows = Layout::rows([(&self.joint, "rad/s²")])
//!             .error_unit("rad")
//!             .vdot_unit([velocity]);
//!         Ok((rows, (joint, velocity)))
//!     }
//!
//!     fn update(&self, running: &mut Self::Running, tick: &Tick<'_>, rows: &mut Rows<'_>) {
//!         let (joint, velocity) = *running;
//!         let motion = MotionRow {
//!             error: tick.state.q[joint.index()] - self.target,
//!             rate: tick.state.v[velocity],
//!             acceleration: 0.0,
//!             kp: self.kp,
//!             kd: self.kd,
//!         };
//!         rows.motion(0, motion);
//!     }
//! }
//!
//! let text = r#"
//!     [controller]
//!     rate = 500.0
//!
//!     [robot]
//!     type = "example.one_link"
//!
//!     [[task]]
//!     name = "elbow"
//!     type = "example.hold_joint"
//!     weight = 1.0
//!     joint = "elbow"
//!     target = 0.0
//!     kp = 100.0
//!     kd = 20.0
//! "#;
//! let config = ControllerConfig::from_str(text, "arm.toml", "")?;
//! let mut controller = Controller::new(config)?;
//!
//! let mut measurement = Measurement::home(controller.robot(), 0);
//! let (command, report) = controller.tick(&measurement);
//! assert_eq!(report.level, FallbackLevel::Optimal);
//! // At home and at rest, the motor carries the link: 1 kg × 9.81 m/s² × 0.5 m, upwards about −y.
//! assert!((command.effort[0] + 9.81 * 0.5).abs() < 1e-6);
//!
//! measurement.time = 0.002;
//! measurement.state.q[0] = f64::NAN;
//! let (command, report) = controller.tick(&measurement);
//! // No state to compute with: for a short time the last efforts are kept.
//! assert_eq!(report.level, FallbackLevel::Extrapolated);
//! assert!((command.effort[0] + 9.81 * 0.5).abs() < 1e-6);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # The problem
//! The decision variables are the generalised acceleration `v̇`, the efforts `u` of the actuators (N or N·m) and
//! the forces `f` of the contacts that are on, in their constrained directions:
//!
//! ```text
//! minimise   Σ w (A_v v̇ + A_u u + A_f f − b)²  +  w_ε ‖(u, f)‖²  +  Σ (w s² + λ s)
//! subject to M v̇ + h = S u + Σ J_cᵀ f_c + Σ J_fᵀ f_f
//!            lower − s ≤ C_v v̇ + C_u u + C_f f ≤ upper + s,  s ≥ 0
//!            bounds on single efforts and force components
//! ```
//!
//! The first sum runs over the rows of tasks and of softened equality constraints. `f_f` is the force in a
//! contact's free directions, zero or measured, and known before the solve. A slack `s` belongs to a soft group
//! of inequality rows; hard rows have none. The solver sees fewer variables: by default the torques of driven joints
//! and the accelerations of everything else are substituted from the dynamics ([`settings::Formulation`]).
//!
//! # Where to begin
//! | to | see |
//! |---|---|
//! | run a controller | [`ControllerConfig`], [`Controller`], [`Measurement`], [`Command`], [`Report`] |
//! | write a task | [`plugin::Task`], [`Layout`], [`plugin::Setup`], [`plugin::Tick`], [`plugin::Rows`] |
//! | write a constraint | [`plugin::Constraint`], [`plugin::ConstraintRows`] |
//! | write a trajectory | [`plugin::Reference`] |
//! | write a fallback law | [`plugin::FallbackLaw`] |
//! | describe a robot | [`robot::Robot`], [`robot::RobotModel`], [`model::ModelBuilder`], [`actuator::Actuator`] |
//! | describe a contact | [`contact::ContactSpec`], [`contact::Detector`] |
//! | use the dynamics alone | the crate `wbqp-dynamics`: [`dynamics::Data`], [`dynamics::FrameKinematics`] |
//! | bring a solver | [`qp::QpSolver`], [`qp::Qp`], [`qp::Solution`] |
//! | test a plug-in | the crate `wbqp-testing` |
//! | keep a log | the crate `wbqp-log` |
//! | list what a file can name | [`registry()`], [`mod@registry`] |
//!
//! # Conventions
//! SI units and radians; world z up. Velocities are world-aligned, `v = [v_WR; w_WR; q̇]`, linear first, of the
//! origin of the base frame R. Forces are what the environment does to the robot; a contact's are in the axes of
//! its surface frame C, whose z is the outward normal, so that pushing gives a positive normal force. Weights
//! are linear: a row costs `w r²`.
//!
//! # Features
//! * `clarabel` (on by default): the interior-point solver Clarabel, `type = "clarabel"`. A crate of plug-ins can do
//!   without: `default-features = false`.
//!
//! # Re-exports
//! A crate of plug-ins depends on `wbqp` alone. [`nalgebra`] is the linear algebra of the interfaces; [`serde`],
//! [`schemars`], [`serde_json`] and [`toml`] are what configurations are read with, and derives find them by
//! `#[serde(crate = "wbqp::serde")]` and `#[schemars(crate = "wbqp::schemars")]`. [`inventory`] and
//! [`typetag`] are there for the code that the attributes [`task`](macro@task), [`constraint`](macro@constraint),
//! [`reference`](macro@reference), [`fallback_law`](macro@fallback_law), [`robot`](macro@robot) and
//! [`solver`](macro@solver) expand to.
//!
//! A crate of plug-ins that no code of a binary names is left out by the linker: write `use my_plugins as _;`.
pub mod config;
pub mod contact;
pub mod controller;
pub mod damped_hover;
pub mod error;
pub mod fault;
#[doc(hidden)] // the crates of this workspace read their files with it
pub mod input;
mod one_line;
pub mod plugin;
pub mod prelude;
mod problem;
pub mod qp;
pub mod registry;
pub mod settings;
pub mod stopwatch;
pub mod suggestion;
mod switch;

pub use config::ControllerConfig;
pub use controller::{Command, Controller, Measurement, Report};
pub use plugin::Layout;
pub use problem::Named;
pub use registry::list as registry;
#[doc(no_inline)]
pub use wbqp_dynamics::{self as dynamics, actuator, model, spatial, state};
pub use wbqp_macros::{constraint, fallback_law, parameters, reference, robot, solver, task};
#[doc(no_inline)]
pub use wbqp_robot_model as robot;
pub use {inventory, nalgebra, schemars, serde, serde_json, toml, typetag};

// Plug-ins inside this crate are registered by the same attribute that users write.
extern crate self as wbqp;
