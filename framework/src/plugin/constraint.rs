//! Constraints: what must hold, as rows with limits and bounds on single variables.

use std::{any::Any, fmt::Debug};

use crate::{
    error::BindError,
    plugin::{BoundPlugin, ConstraintLayout, ConstraintRows, Remembered, Setup, Tick},
};

/// A constraint demands `lower ≤ A_v v̇ + A_u u + Σ A_c f_c ≤ upper`, or `A x = b` if its layout says
/// [`equality`](crate::Layout::equality), and bounds on single efforts and contact forces.
///
/// Hard by default. An entry with `hardness = "soft"` turns equality rows into a weighted cost and
/// inequality rows into a penalised slack; bounds stay hard.
///
/// Parameters and running object are two types, as of a [`Task`](crate::plugin::Task), and the life cycle is the same.
/// The attribute is [`constraint`](macro@crate::constraint).
pub trait Constraint: AnyConstraint + Clone {
    /// Handles of frames and contacts, and whatever else is not a parameter.
    type Running: Send + 'static;

    /// Called once: resolves names and declares rows and bounds.
    ///
    /// # Errors
    /// [`BindError`] when a name does not exist or a parameter does not fit the robot.
    fn bind(&self, setup: &mut Setup<'_>) -> Result<(ConstraintLayout, Self::Running), BindError>;

    /// Writes this tick's rows and bounds. No allocation, no panic.
    fn update(&self, running: &mut Self::Running, tick: &Tick<'_>, rows: &mut ConstraintRows<'_>);

    /// Called before the update of the tick in which the entry, or the contact it belongs to, is switched on. No
    /// allocation, no panic.
    fn activate(&self, running: &mut Self::Running) {
        let _ = running;
    }

    /// Shows what `running` remembers from one update to the next, number by number: integrals, filters, where
    /// something began. Not what was resolved in `bind`. [`Controller::sensitivity`](crate::Controller::sensitivity)
    /// lets a tick's update run again from there. Unless a constraint says so it is not known what it remembers, but
    /// for one without a running object, and its rows count as constant there; one that remembers nothing shows
    /// nothing. No allocation, no panic.
    fn remembered(&self, running: &mut Self::Running, numbers: &mut Remembered<'_>) {
        let _ = running;
        if size_of::<Self::Running>() > 0 {
            numbers.unknown();
        }
    }
}

/// Any constraint: what an entry of a configuration holds. Implemented by the attribute
/// [`constraint`](macro@crate::constraint).
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no constraint that files can name",
    label = "without the attribute `#[wbqp::constraint(\"…\")]`",
    note = "write `#[wbqp::constraint(\"PREFIX.NAME\")]` above its definition; that derives `Clone` and `Debug`, too"
)]
#[typetag::serialize(tag = "type")]
pub trait AnyConstraint: Any + Send + Debug {
    /// Binds the constraint, as [`Constraint::bind`].
    ///
    /// # Errors
    /// What the constraint refuses.
    fn bind_any(&self, setup: &mut Setup<'_>) -> Result<BoundPlugin, BindError>;
}
