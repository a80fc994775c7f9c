//! What will be asked of a controller, before it runs.

use crate::contact::ContactId;

/// The set point of a normal force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlannedForce<'a> {
    /// The task.
    pub task: &'a str,
    /// The contact.
    pub contact: ContactId,
    /// What its reference says, N.
    pub normal: f64,
}
