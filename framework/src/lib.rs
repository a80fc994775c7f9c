//! wbqp
pub mod actuator;
pub mod config;
pub mod constraint;
pub mod contact;
pub mod dynamics;
pub mod entry;
pub mod layout;
pub mod model;
pub mod qp;
pub mod reference;
pub mod robot;
pub mod rows;
pub mod setup;
pub mod spatial;
pub mod state;
pub mod task;
pub mod tick;

pub use layout::Layout;
pub use nalgebra;
