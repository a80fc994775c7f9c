//! Tasks: what the robot should do, as rows of a weighted least-squares cost.

use std::{any::Any, fmt::Debug};

use crate::{
    error::BindError,
    plugin::{BoundPlugin, Layout, Remembered, Rows, Setup, Tick},
};

/// A task adds `Σ_k w_k (A x − b)_k²` to the cost, with `A x = A_v v̇ + A_u u + Σ A_c f_c`.
///
/// The type that implements it is the task's *parameters*: plain data with the attribute [`task`](macro@crate::task),
/// read from a file or made in code, and changed while running through
/// [`Controller::parameters_mut`](crate::Controller::parameters_mut). What is resolved once and what is remembered
/// from tick to tick is another type, [`Task::Running`], which [`bind`](Task::bind) makes.
///
/// The weight enters **linearly**: its unit is 1/unit(row)². Name, weight, activation, transition and hardness
/// belong to the framework's entry around the task, not to the task.
pub trait Task: AnyTask + Clone {
    /// Handles of frames, contacts and references, integrators, buffers: whatever is not a parameter.
    type Running: Send + 'static;

    /// Called once: resolves names, asks for frames, declares references and rows.
    ///
    /// # Errors
    /// [`BindError`] when a name does not exist or a parameter does not fit the robot.
    fn bind(&self, setup: &mut Setup<'_>) -> Result<(Layout, Self::Running), BindError>;

    /// Called in every tick while the entry, and the contact it belongs to, is on: writes `A` (only blocks that were
    /// declared dense), `b` and the error. No allocation, no panic.
    fn update(&self, running: &mut Self::Running, tick: &Tick<'_>, rows: &mut Rows<'_>);

    /// Called before the update of the tick in which the entry, or the contact it belongs to, is switched on: resets
    /// integrators. No allocation, no panic.
    fn activate(&self, running: &mut Self::Running) {
        let _ = running;
    }

    /// Shows what `running` remembers from one update to the next, number by number: integrals, filters, where
    /// something began. Not what was resolved in `bind`. [`Controller::sensitivity`](crate::Controller::sensitivity)
    /// lets a tick's update run again from there. Unless a task says so it is not known what it remembers, but for one
    /// without a running object, and its rows count as constant there; one that remembers nothing shows nothing. No
    /// allocation, no panic.
    fn remembered(&self, running: &mut Self::Running, numbers: &mut Remembered<'_>) {
        let _ = running;
        if size_of::<Self::Running>() > 0 {
            numbers.unknown();
        }
    }
}

/// Any task: what an entry of a configuration holds. Implemented by the attribute [`task`](macro@crate::task), which
/// also gives it the tag by which files name it.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no task that files can name",
    label = "without the attribute `#[wbqp::task(\"…\")]`",
    note = "write `#[wbqp::task(\"PREFIX.NAME\")]` above its definition; that derives `Clone` and `Debug`, too"
)]
#[typetag::serialize(tag = "type")]
pub trait AnyTask: Any + Send + Debug {
    /// Binds the task, as [`Task::bind`].
    ///
    /// # Errors
    /// What the task refuses.
    fn bind_any(&self, setup: &mut Setup<'_>) -> Result<BoundPlugin, BindError>;
}
