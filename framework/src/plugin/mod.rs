//! What plug-ins are, and what they speak: tasks, constraints, references and fallback laws, the rows that they write,
//! and what they see.
//!
//! A plug-in is *bound* once ([`Setup`]: names to resolve, frames to ask for; it answers with its [`Layout`]) and
//! *updated* in every tick ([`Tick`]: what is known; [`Rows`] or [`ConstraintRows`]: what it writes). An [`Entry`] is
//! what the framework adds to it: name, weight, ramp, hardness.

pub(crate) mod bound;
pub(crate) mod constraint;
mod declare;
pub(crate) mod entry;
pub(crate) mod fallback_law;
pub(crate) mod followed;
pub(crate) mod layout;
mod motion_row;
mod per_row;
pub(crate) mod reference;
pub(crate) mod remembered;
pub(crate) mod rows;
pub(crate) mod setup;
pub(crate) mod storage;
pub(crate) mod task;
pub(crate) mod tick;

pub use bound::{AnyPlugin, BoundPlugin};
pub use constraint::{AnyConstraint, Constraint};
pub use declare::ConstraintLayout;
pub(crate) use entry::ENTRY_KEYS;
pub(crate) use entry::EntryState;
pub use entry::{Entry, Hardness};
pub use fallback_law::{AnyFallbackLaw, BoundFallbackLaw, FallbackLaw};
pub use followed::BoundReference;
pub use layout::Layout;
pub(crate) use layout::RowSpec;
pub use motion_row::{ForceReport, MotionRow};
pub use per_row::PerRow;
pub use reference::{AnyReference, Reference, RotationSample, Sample, Space, VectorSample};
pub use remembered::Remembered;
pub use rows::{ConstraintRows, RowMajorMut, Rows};
pub use setup::{FrameHandle, RotationReference, Setup, VectorReference};
pub use task::{AnyTask, Task};
pub(crate) use tick::PreviousSolution;
pub use tick::{AT_HOME, Tick};
