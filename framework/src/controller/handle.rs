//! Typed access to a task of a running controller, by name or by an id that was resolved once.

use std::{
    any::type_name,
    fmt,
    marker::PhantomData,
    ops::{Deref, DerefMut},
    sync::atomic::{AtomicU32, Ordering},
};

use super::{
    Controller,
    error::RequestError,
    requests::{redirect, reweight},
};
use crate::{assembly::Group, entry::Weight, reference::Reference, task::Task};

/// A task of one controller, of known type. Made by [`Controller::task_id`].
pub struct TaskId<T> {
    index: u32,
    controller: Stamp,
    plugin: PhantomData<fn() -> T>,
}

impl<T> Clone for TaskId<T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for TaskId<T> {}

impl<T> fmt::Debug for TaskId<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "TaskId<{}>({})", type_name::<T>(), self.index)
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

/// What names a task: its name, or its [`TaskId`].
pub trait TaskKey<T: Task>: sealed::Sealed {
    /// Its position among the tasks.
    #[doc(hidden)]
    fn find(self, controller: &Controller) -> Result<usize, RequestError>;
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for &str {}
    impl Sealed for &String {}
    impl<T> Sealed for super::TaskId<T> {}
}

impl<T: Task> TaskKey<T> for &str {
    fn find(self, controller: &Controller) -> Result<usize, RequestError> {
        controller.task_index(self)
    }
}

impl<T: Task> TaskKey<T> for &String {
    fn find(self, controller: &Controller) -> Result<usize, RequestError> {
        controller.task_index(self)
    }
}

impl<T: Task> TaskKey<T> for TaskId<T> {
    fn find(self, controller: &Controller) -> Result<usize, RequestError> {
        if self.controller == controller.stamp {
            Ok(self.index as usize)
        } else {
            Err(RequestError::OtherController {
                asked: type_name::<T>(),
            })
        }
    }
}

/// A task of a running controller, between two ticks: its parameters (it dereferences to the task) and what belongs
/// to its entry.
///
/// Parameters written through it are not validated as in a file: a list of the wrong length, a negative gain. The next
/// tick survives them, since rows that are not finite make it fall back and say so, but the robot does what they say.
#[derive(Debug)]
pub struct TaskMut<'c, T> {
    task: &'c mut T,
    group: &'c mut Group,
    next_time: f64,
}

impl<T: Task> TaskMut<'_, T> {
    /// Its name.
    pub fn name(&self) -> &str {
        &self.group.name
    }

    /// Gives the task another trajectory, as [`Controller::follow`].
    ///
    /// # Errors
    /// [`RequestError`] if the task follows nothing or the trajectory does not fit; the old one is kept then.
    pub fn follow(&mut self, reference: impl Reference) -> Result<(), RequestError> {
        let name = &self.group.name;
        redirect(self.task, name, Box::new(reference), self.next_time)
    }

    /// Gives its rows another weight, to which it goes from the next tick on with the entry's ramp.
    ///
    /// # Errors
    /// [`RequestError::Value`] if the weight does not fit the rows.
    pub fn reweight(&mut self, weight: impl Into<Weight>) -> Result<(), RequestError> {
        reweight(self.group, &weight.into())
    }

    /// Switches the task on, with its ramp. Nothing happens if it is on.
    pub fn activate(&mut self) {
        self.group.switch.turn(true);
    }

    /// Switches the task off, with its ramp. Nothing happens if it is off.
    pub fn deactivate(&mut self) {
        self.group.switch.turn(false);
    }
}

impl<T> Deref for TaskMut<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        self.task
    }
}

impl<T> DerefMut for TaskMut<'_, T> {
    fn deref_mut(&mut self) -> &mut T {
        self.task
    }
}

impl Controller {
    /// A task by name, resolved once: for access in every period without looking for the name.
    ///
    /// # Errors
    /// [`RequestError`] if there is no such task or it is of another type.
    pub fn task_id<T: Task>(&self, name: &str) -> Result<TaskId<T>, RequestError> {
        let index = self.task_index(name)?;
        match self.tasks[index].downcast_ref::<T>() {
            Some(_) => Ok(TaskId {
                index: index as u32,
                controller: self.stamp,
                plugin: PhantomData,
            }),
            None => Err(other_type::<T>(self.tasks[index].typetag_name(), name)),
        }
    }

    /// A task as its own type, to read or change its parameters, trajectory, weight and activation:
    ///
    /// ```text
    /// let mut arm = controller.task_mut::<Posture>("arm")?;
    /// arm.kp = 40.0.into();
    /// arm.reweight(0.5)?;
    /// arm.follow(MinJerk::new([0.0, 0.3, 0.9], 2.0))?;
    /// ```
    ///
    /// # Errors
    /// [`RequestError`] if there is no such task, it is of another type, or the id is another controller's.
    pub fn task_mut<T: Task>(
        &mut self,
        task: impl TaskKey<T>,
    ) -> Result<TaskMut<'_, T>, RequestError> {
        let index = task.find(self)?;
        let next_time = self.world.next_time();
        let group = &mut self.groups[index];
        let task = &mut self.tasks[index];
        let is = task.typetag_name();
        match task.downcast_mut::<T>() {
            Some(task) => Ok(TaskMut {
                task,
                group,
                next_time,
            }),
            None => Err(other_type::<T>(is, &group.name)),
        }
    }
}

fn other_type<T>(is: &'static str, name: &str) -> RequestError {
    RequestError::OtherType {
        name: name.to_owned(),
        is,
        asked: type_name::<T>(),
    }
}
