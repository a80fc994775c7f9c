//! A task or constraint of a running controller, as a program that shows or changes it needs it.

use crate::plugin::Layout;

/// A task or constraint of a running controller. [`Controller::parameters`](super::Controller::parameters) gives what
/// it is parametrised with.
#[derive(Clone, Copy, Debug)]
pub struct EntryView<'a> {
    /// Its name.
    pub name: &'a str,
    /// Whether it is a task; a constraint if not.
    pub is_task: bool,
    /// Its rows.
    pub layout: &'a Layout,
    /// The weight of each row that it has or, during a ramp, goes to.
    pub weight: &'a [f64],
    /// Whether it is on or, during a ramp, goes on.
    pub is_on: bool,
}
