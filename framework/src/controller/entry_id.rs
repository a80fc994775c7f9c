//! Where a task or constraint stands among those of a controller, and which controller that is.

use std::sync::atomic::{AtomicU32, Ordering};

/// Index of a task or constraint among all entries of a controller: tasks, then constraints. Made by
/// [`Controller::entry`](super::Controller::entry).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EntryId(pub(super) u32);

impl EntryId {
    /// As a position; of a task also that in [`Report::tasks`](super::Report::tasks).
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// Tells controllers of one process apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Stamp(u32);

impl Stamp {
    pub(crate) fn next() -> Self {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        Self(NEXT.fetch_add(1, Ordering::Relaxed))
    }
}
