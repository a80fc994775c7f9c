//! The plug-ins of a controller whose file names none.

use crate::{
    damped_hover::DampedHover,
    plugin::AnyFallbackLaw,
    qp::{ActiveSet, Solver},
};

/// The solver.
pub(super) fn solver() -> Box<dyn Solver> {
    Box::new(ActiveSet::default())
}

/// The fallback law.
pub(super) fn fallback() -> Box<dyn AnyFallbackLaw> {
    Box::new(DampedHover::default())
}
