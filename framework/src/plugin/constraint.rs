//! Constraints: what must hold, as rows with limits and bounds on single variables.

use std::{any::Any, fmt::Debug};

use crate::{
    error::BindError,
    plugin::{ConstraintRows, Layout, Setup, Tick},
};

/// A constraint demands `lower ≤ A_v v̇ + A_u u + Σ A_c f_c ≤ upper`, or `A x = b` if its layout says
/// [`equality`](Layout::equality), and bounds on single efforts and contact forces.
///
/// Hard by default. An entry with `hardness = "soft"` turns equality rows into a weighted cost and
/// inequality rows into a penalised slack; bounds stay hard.
///
/// The life cycle is that of a [`Task`](crate::plugin::Task). A constraint is registered by
/// `#[wbqp::constraint("tag")]`.
#[typetag::serde(tag = "type")]
pub trait Constraint: Any + Send + Debug {
    /// Resolves names and declares rows and bounds.
    ///
    /// # Errors
    /// [`BindError`] when a name does not exist or a parameter does not fit the robot.
    fn bind(&mut self, setup: &mut Setup<'_>) -> Result<Layout, BindError>;

    /// Writes this tick's rows and bounds.
    fn update(&mut self, tick: &Tick<'_>, rows: &mut ConstraintRows<'_>);

    /// Called before the update of the tick in which the entry, or the contact it belongs to, is switched on. No
    /// allocation, no panic.
    fn activate(&mut self) {}
}

impl dyn Constraint {
    /// The constraint as its own type, if it is a `T`.
    pub fn downcast_mut<T: Constraint>(&mut self) -> Option<&mut T> {
        (self as &mut dyn Any).downcast_mut()
    }
}
