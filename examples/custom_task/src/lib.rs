//! Plug-ins of one's own: a task that keeps a tool pointing at a place, a constraint that limits the base's tilt, and a
//! reference that flies a figure of eight. The guide "Write your own task" in wbqp's book goes through them.
//!
//! They register themselves when this crate is linked: `use pointing as _;` in a program is enough.

mod figure_eight;
mod max_tilt;
mod point_at;

pub use figure_eight::FigureEight;
pub use max_tilt::MaxTilt;
pub use point_at::PointAt;

/// The guide's code is compiled and run with the tests.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/write-your-own-task.md")]
struct Guide;

/// Likewise.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/how-to/test-plugins.md")]
struct TestPlugins;

/// Likewise.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/tutorials/first-task.md")]
struct FirstTask;
