//! What plug-ins are, and what they speak: tasks, constraints, references and laws of last resort, the rows that they
//! write, and what they see.
//!
//! A plug-in is *bound* once ([`Setup`]: names to resolve, frames to ask for; it answers with its [`Layout`]) and
//! *updated* in every tick ([`Tick`]: what is known; [`Rows`] or [`ConstraintRows`]: what it writes). An [`Entry`] is
//! what the framework adds to it: name, weight, ramp, hardness.

pub(crate) mod bound;
pub(crate) mod constraint;
pub(crate) mod entry;
pub(crate) mod fallback_law;
pub(crate) mod followed;
pub(crate) mod frame_handle;
pub(crate) mod layout;
pub(crate) mod per_row;
pub(crate) mod reference;
pub(crate) mod remembered;
pub(crate) mod rows;
pub(crate) mod setup;
pub(crate) mod slopes;
pub(crate) mod task;
pub(crate) mod tick;

pub use bound::{AnyPlugin, BoundPlugin};
pub use constraint::{AnyConstraint, Constraint};
pub(crate) use entry::ENTRY_KEYS;
pub use entry::{Entry, Hardness};
pub use fallback_law::{AnyFallbackLaw, BoundFallbackLaw, FallbackLaw};
pub use followed::{AT_HOME, BoundReference, RotationReference, VectorReference};
pub use frame_handle::FrameHandle;
pub use layout::{ConstraintLayout, Layout, RowSpec};
pub use per_row::PerRow;
pub use reference::{AnyReference, Reference, RotationSample, Sample, Space, Start, VectorSample};
pub use remembered::Remembered;
pub use rows::{ConstraintRows, ForceReport, MotionRow, RowMajorMut, Rows};
pub use setup::Setup;
pub use slopes::{Displacement, Slopes};
pub use task::{AnyTask, Task};
pub use tick::{EntryState, PreviousSolution, Tick};
