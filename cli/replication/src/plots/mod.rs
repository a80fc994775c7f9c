//! Figures as SVG, drawn from the logs.

mod common;
mod figure;
mod map;
pub mod push;
pub mod push_away;
pub mod slide;
pub mod switching;
pub mod under_actuated;

pub use common::FigureError;
use common::{contact_force, contact_shade, in_contact, propellers, same_range};
pub use figure::{Colour, Figure, Line, Panel, PlotError, Shade};
pub use map::{Curve, Map};
