//! What names a task or constraint of a running controller: its name, or an id that was resolved once.

use std::sync::atomic::{AtomicU32, Ordering};

/// A task or constraint of one controller. Made by [`Controller::entry`](super::Controller::entry).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EntryId {
    /// Among all entries: tasks, then constraints.
    pub(super) index: u32,
    pub(super) controller: Stamp,
}

impl EntryId {
    /// Position among all entries: tasks, then constraints.
    pub fn index(self) -> usize {
        self.index as usize
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

/// What names an entry: a name, which is looked for, or an id, which is not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EntryRef<'a> {
    /// Its name.
    Name(&'a str),
    /// Its id.
    Id(EntryId),
}

impl<'a> From<&'a str> for EntryRef<'a> {
    fn from(name: &'a str) -> Self {
        Self::Name(name)
    }
}

impl<'a> From<&'a String> for EntryRef<'a> {
    fn from(name: &'a String) -> Self {
        Self::Name(name)
    }
}

impl From<EntryId> for EntryRef<'_> {
    fn from(id: EntryId) -> Self {
        Self::Id(id)
    }
}
