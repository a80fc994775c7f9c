//! wbqp
pub mod dynamics;
pub mod model;
pub mod spatial;
pub mod state;

pub use nalgebra;
