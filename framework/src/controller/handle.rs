//! Typed access to a task or constraint of a running controller, by name or by an id that was resolved once.

use std::{
    any::type_name,
    fmt,
    marker::PhantomData,
    ops::{Deref, DerefMut},
    sync::atomic::{AtomicU32, Ordering},
};

use super::{Controller, error::RequestError, requests::reweight, running};
use crate::{
    plugin::{AnyReference, Task, Weight, followed::Followed},
    problem::BoundEntry,
};

/// A task or constraint of one controller, of known type. Made by [`Controller::task_id`] and
/// [`Controller::constraint_id`].
pub struct EntryId<T> {
    /// Among all entries: tasks, then constraints.
    index: u32,
    controller: Stamp,
    plugin: PhantomData<fn() -> T>,
}

impl<T> EntryId<T> {
    pub(super) fn new(index: usize, controller: Stamp) -> Self {
        Self {
            index: index as u32,
            controller,
            plugin: PhantomData,
        }
    }
}

impl<T> Clone for EntryId<T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for EntryId<T> {}

impl<T> fmt::Debug for EntryId<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "EntryId<{}>({})", short_name::<T>(), self.index)
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

/// What names a task or constraint of type `T`: its name, or its [`EntryId`].
pub trait EntryKey<T>: key::Find<T> {}

impl<T, K: key::Find<T>> EntryKey<T> for K {}

/// Keeps [`EntryKey`] to the types here.
pub(super) mod key {
    use super::{Controller, EntryId, RequestError, short_name};

    /// Where a name is looked for.
    #[derive(Clone, Copy, Debug)]
    pub enum Among {
        Tasks,
        Constraints,
    }

    pub trait Find<T> {
        /// Its position among all entries.
        fn find(self, controller: &Controller, among: Among) -> Result<usize, RequestError>;
    }

    impl<T> Find<T> for &str {
        fn find(self, controller: &Controller, among: Among) -> Result<usize, RequestError> {
            match among {
                Among::Tasks => controller.task_index(self),
                Among::Constraints => controller.constraint_index(self),
            }
        }
    }

    impl<T> Find<T> for &String {
        fn find(self, controller: &Controller, among: Among) -> Result<usize, RequestError> {
            Find::<T>::find(self.as_str(), controller, among)
        }
    }

    impl<T> Find<T> for EntryId<T> {
        fn find(self, controller: &Controller, _: Among) -> Result<usize, RequestError> {
            if self.controller == controller.stamp {
                Ok(self.index as usize)
            } else {
                Err(RequestError::OtherController {
                    asked: short_name::<T>(),
                })
            }
        }
    }
}

/// A task or constraint of a running controller, between two ticks: its parameters (it dereferences to the plug-in)
/// and what belongs to its entry.
///
/// Parameters written through it are not validated as in a file: a list of the wrong length, a negative gain. The next
/// tick survives them, since rows that are not finite make it fall back and say so, but the robot does what they say.
#[derive(Debug)]
pub struct EntryMut<'c, T> {
    pub(super) parameters: &'c mut T,
    pub(super) references: &'c mut [Followed],
    pub(super) entry: &'c mut BoundEntry,
    pub(super) next_time: f64,
}

impl<T: Task> EntryMut<'_, T> {
    /// Gives the task another trajectory, as [`Controller::follow`].
    ///
    /// # Errors
    /// [`RequestError`] if the task follows nothing or the trajectory does not fit; the old one is kept then.
    pub fn follow(&mut self, reference: impl AnyReference) -> Result<(), RequestError> {
        running::follow(
            self.references,
            &self.entry.name,
            &reference,
            self.next_time,
        )
    }
}

impl<T> EntryMut<'_, T> {
    /// Its name.
    pub fn name(&self) -> &str {
        &self.entry.name
    }

    /// Gives its rows another weight, to which it goes from the next tick on with the entry's ramp.
    ///
    /// # Errors
    /// [`RequestError::Value`] if the weight does not fit the rows.
    pub fn reweight(&mut self, weight: impl Into<Weight>) -> Result<(), RequestError> {
        reweight(self.entry, &weight.into())
    }

    /// Switches the entry on, with its ramp. Nothing happens if it is on.
    pub fn activate(&mut self) {
        self.entry.switch.turn(true);
    }

    /// Switches the entry off, with its ramp. Nothing happens if it is off.
    pub fn deactivate(&mut self) {
        self.entry.switch.turn(false);
    }
}

impl<T> Deref for EntryMut<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        self.parameters
    }
}

impl<T> DerefMut for EntryMut<'_, T> {
    fn deref_mut(&mut self) -> &mut T {
        self.parameters
    }
}

pub(super) fn other_type<T>(kind: &'static str, is: &'static str, name: &str) -> RequestError {
    RequestError::OtherType {
        kind,
        name: name.to_owned(),
        is,
        asked: short_name::<T>(),
    }
}

/// A type's name without the path of its modules.
fn short_name<T>() -> &'static str {
    let full = type_name::<T>();
    let path = full.split('<').next().unwrap_or(full);
    let start = path.rfind("::").map_or(0, |colons| colons + 2);
    full.get(start..).unwrap_or(full)
}
