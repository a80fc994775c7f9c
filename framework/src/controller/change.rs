//! What somebody changes of a running controller, as plain data.

use super::{Controller, error::RequestError};
use crate::plugin::{AnyReference, PerRow};

/// A change of a running controller as plain data: for programs that receive changes from elsewhere, a slider or
/// another thread, and apply them between two ticks. Names are those of entries and contacts.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum Change {
    /// Keys of a task or constraint, as in its file: [`Controller::set`].
    Set(String, toml::Table),
    /// A weight: [`Controller::reweight`].
    Weight(String, PerRow),
    /// A task's trajectory: [`Controller::follow`].
    Follow(String, Box<dyn AnyReference>),
    /// A task or constraint on or off: [`Controller::activate`], [`Controller::deactivate`].
    Entry(String, bool),
    /// A contact on or off: [`Controller::activate_contact`], [`Controller::deactivate_contact`].
    Contact(String, bool),
    /// The zero of a contact's force sensor: [`Controller::tare`].
    Tare(String),
}

impl Change {
    /// Asks a controller for it; it holds from the next tick on.
    ///
    /// # Errors
    /// What the controller refuses; nothing has changed then.
    pub fn apply(&self, controller: &mut Controller) -> Result<(), RequestError> {
        match self {
            Self::Set(entry, keys) => controller.set(entry, keys.clone()),
            Self::Weight(entry, weight) => controller.reweight(entry, weight.clone()),
            Self::Follow(task, reference) => controller.follow(task, reference.clone()),
            Self::Entry(entry, true) => controller.activate(entry),
            Self::Entry(entry, false) => controller.deactivate(entry),
            Self::Contact(contact, true) => controller.activate_contact(contact),
            Self::Contact(contact, false) => controller.deactivate_contact(contact),
            Self::Tare(contact) => controller.tare(contact),
        }
    }
}
