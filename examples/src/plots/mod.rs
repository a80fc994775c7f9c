//! Figures as SVG, drawn from the logs.

mod figure;
pub mod push;

pub use figure::{Colour, Figure, Line, Panel, PlotError, Shade};
