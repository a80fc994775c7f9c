//! Tasks: what the robot should do, as rows of a weighted least-squares cost.

use std::{any::Any, fmt::Debug};

use nalgebra::Vector3;

use crate::{
    contact::ContactId,
    error::BindError,
    plugin::{Layout, Rows, Setup, Tick, reference::ReferenceSlot},
};

/// A task adds `Σ_k w_k (A x − b)_k²` to the cost, with `A x = A_v v̇ + A_u u + Σ A_c f_c`.
///
/// The weight enters **linearly**: its unit is 1/unit(row)². Name, weight, activation, transition and hardness
/// belong to the framework's entry around the task, not to the task.
///
/// Life cycle:
/// * deserialised from the configuration, or made in code;
/// * [`bind`](Task::bind) once: resolve names, ask for frames, declare rows. Fields of the configuration
///   stay as they are; what is resolved goes to `#[serde(skip)]` fields;
/// * [`begin`](Task::begin) in the first tick, when it is known where the robot is: trajectories that have no value of
///   their own begin there;
/// * [`activate`](Task::activate) whenever the entry or its contact is switched on: reset integrators;
/// * [`update`](Task::update) every tick while on: write `A` (only blocks that were declared dense), `b` and
///   the error. No allocation, no panic.
///
/// A task is registered by `#[wbqp::task("tag")]` on its implementation and named by `type = "tag"` in TOML.
#[typetag::serde(tag = "type")]
pub trait Task: Any + Send + Debug {
    /// Resolves names and declares the rows.
    ///
    /// # Errors
    /// [`BindError`] when a name does not exist or a parameter does not fit the robot.
    fn bind(&mut self, setup: &mut Setup<'_>) -> Result<Layout, BindError>;

    /// Writes this tick's rows.
    fn update(&mut self, tick: &Tick<'_>, rows: &mut Rows<'_>);

    /// Called in the first tick with a usable measurement, before the first update, whether the entry is on or not:
    /// lets references begin at what is measured, with [`begin_at`](crate::plugin::reference::begin_at) and
    /// [`begin_turned`](crate::plugin::reference::begin_turned). A task that does not say what it measures begins at
    /// the home posture. No allocation, no panic.
    ///
    /// Called again in the next tick if the first one was refused because an error was too large.
    fn begin(&mut self, tick: &Tick<'_>) {
        let _ = tick;
    }

    /// Called before the update of the tick in which the entry, or the contact it belongs to, is switched on. No
    /// allocation, no panic.
    fn activate(&mut self) {}

    /// The trajectory that the task follows, if it has one, with what is needed to replace it while running.
    fn follow(&mut self) -> Option<ReferenceSlot<'_>> {
        None
    }

    /// The contact whose normal force, N, is what the task's trajectory says, if it is a task that pushes: what it
    /// will ask for can be checked before a run.
    fn pushes(&self) -> Option<ContactId> {
        None
    }

    /// What a force task asked of the solver in the last update; for logs and reports.
    fn force_report(&self) -> Option<ForceReport> {
        None
    }
}

/// The two forces that only a force task knows, C axes, N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceReport {
    /// The contact that is controlled.
    pub contact: ContactId,
    /// Set point `f^d`.
    pub reference: Vector3<f64>,
    /// What the outer loop asks of the solver, `f*` of the paper's (11).
    pub virtual_input: Vector3<f64>,
    /// Whether the integrator stands at its clamp.
    pub clamped: bool,
}

impl dyn Task {
    /// The task as its own type, if it is a `T`.
    pub fn downcast_mut<T: Task>(&mut self) -> Option<&mut T> {
        (self as &mut dyn Any).downcast_mut()
    }

    /// The task as its own type, if it is a `T`.
    pub fn downcast_ref<T: Task>(&self) -> Option<&T> {
        (self as &dyn Any).downcast_ref()
    }
}
