//! wbqp
pub mod actuator;
mod assembly;
pub mod config;
pub mod constraint;
pub mod contact;
pub mod controller;
pub mod dynamics;
pub mod entry;
pub mod layout;
pub mod log;
pub mod model;
pub mod qp;
pub mod reference;
pub mod registry;
pub mod robot;
pub mod rows;
pub mod setup;
pub mod spatial;
pub mod state;
pub mod task;
pub mod tick;

pub use assembly::{RowInfo, VarInfo};
pub use config::ControllerConfig;
pub use controller::{Command, Controller, Measurement, Report};
pub use layout::Layout;
pub use wbqp_macros::{constraint, reference, robot, solver, task};
pub use {inventory, nalgebra, schemars, serde, serde_json, toml, typetag};

// Plug-ins inside this crate are registered by the same attribute that users write.
extern crate self as wbqp;
