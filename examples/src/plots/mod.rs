//! Figures as SVG, drawn from the logs.

mod common;
mod figure;
pub mod push;
pub mod push_away;

pub use common::FigureError;
use common::{contact_shade, propellers, same_range};
pub use figure::{Colour, Figure, Line, Panel, PlotError, Shade};
