//! The plant that wbqp's examples are tried on: rigid bodies, rotors, servos, walls, disturbances, sensors.
//!
//! A [`Plant`] has a model of its own, with its own parameters ([`Mismatch`](plant::Mismatch)): a controller
//! never reads it. What a controller gets are [`Sensors`] readings; what it gives is a [`PlantCommand`],
//! usually one period late ([`CommandDelay`]).
//!
//! ```
//! # use nalgebra::{Matrix3, Vector3};
//! # use wbqp::{model::{Base, Inertia, ModelBuilder}, robot::RobotModel, state::State};
//! use wbqp_sim::{CommandDelay, Plant, PlantCommand, PlantConfig, Sensors, SensorsConfig};
//! # let ball = Inertia::from_com(2.0, Vector3::zeros(), Matrix3::identity() * 0.01);
//! # let model = ModelBuilder::new("ball", Base::Floating, "ball", ball).build()?;
//! # let home = State::neutral(&model);
//! # let robot = RobotModel::new(model, vec![], home);
//! let period = 0.004;
//! let mut plant = Plant::new(&robot, &PlantConfig::default(), robot.home.clone())?;
//! let mut sensors = Sensors::new(&SensorsConfig::default(), &plant, 42)?;
//! let mut delay = CommandDelay::new(1, PlantCommand::rest(&robot));
//!
//! for _ in 0..25 {
//!     let reading = sensors.sample(&plant);
//!     assert!(reading.state.is_finite());
//!     let computed = PlantCommand::rest(&robot); // the controller's work
//!     let applied = delay.exchange(&computed);
//!     plant.advance_with(applied, period, |plant| sensors.observe(plant))?;
//! }
//! // Nothing holds the ball: ½ g t².
//! assert!((plant.state().p_WR.z + 0.5 * 9.81 * 0.1 * 0.1).abs() < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod check;
mod closed_loop;
mod error_gradient;
pub mod exact;
pub mod plant;
mod run;
pub mod scenario;
pub mod sensors;
pub mod statics;
mod watch;
mod world;

pub use closed_loop::{ClosedLoop, Link, Requests};
pub use error_gradient::{ErrorGradient, Gradient, GradientEntry};
pub use plant::{CommandDelay, Plant, PlantCommand, PlantConfig, PlantError};
pub use run::{CaseRun, Held, Summary, run, run_case, run_with};
pub use scenario::{Perturbation, RunError, Scenario, ScenarioError, Variation};
pub use sensors::{SensorReading, Sensors, SensorsConfig};
#[cfg(feature = "live")]
pub use watch::LiveWatcher;
#[cfg(feature = "foxglove")]
pub use watch::SceneWatcher;
pub use watch::{RunOptions, Watcher};
pub use world::{World, center_of_force};
