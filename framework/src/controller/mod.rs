//! The controller: bind once, then tick.
//!
//! A tick is measurement → kinematics and dynamics → rows of tasks and constraints → quadratic program →
//! solver → command and report. Nothing is allocated after
//! [`Controller::new`] except inside a solver that needs it.

mod bind;
mod bounds;
mod change;
mod entry_id;
mod entry_view;
mod error;
mod explanation;
mod fallback;
mod first;
mod fit;
mod home;
mod hover;
mod measurement;
mod memory;
mod misfits;
mod names;
mod observer;
mod output;
mod parameters;
mod planned_force;
mod probe;
mod record;
mod report;
mod requests;
mod running;
mod sensitivity;
mod snapshot;
mod tick;
mod world;

pub use change::Change;
pub use entry_id::{EntryId, EntryRef};
pub use entry_view::EntryView;
pub use error::RequestError;
pub use explanation::{Explanation, Limit};
pub use measurement::Measurement;
pub use memory::Memory;
pub use names::Names;
pub use output::{Command, CutEffort};
pub use planned_force::PlannedForce;
pub use probe::{Probe, ProbeInputs, WrittenRows};
pub use record::{Dump, Record, Source};
pub use report::{
    ActiveRow, ConflictRow, ContactReport, FallbackLevel, OnLevel, RelaxedRow, Report, Side,
    TaskReport,
};
pub use sensitivity::{
    Effect, Influence, Note, Parameter, ParameterKind, Sensitivity, SensitivityError,
};
pub use snapshot::{ContactSurface, Snapshot};
pub use tick::Controller;

pub(crate) use bind::{Bound, Parts};
pub(crate) use misfits::{Misfit, MisfitKind};
pub(crate) use record::{CommandRecord, FORMAT, MadeFrom, misfit, rerun};
