//! wbqp
pub mod actuator;
pub mod dynamics;
pub mod model;
pub mod robot;
pub mod spatial;
pub mod state;

pub use nalgebra;
