//! What somebody changes of a running controller, as plain data: the page keeps a list of them in its address.

use wbqp::{
    controller::{Controller, RequestError},
    plugin::{AnyReference, PerRow},
    serde_json::{self, Map, Value},
    toml,
};

/// A change.
#[derive(Clone, Debug)]
pub enum Change {
    /// Keys of a task or constraint, as in its file: `{"do": "set", "of": "base_position", "keys": {"kp": 20}}`.
    Set(String, toml::Table),
    /// A weight, one number or one per row: `{"do": "weight", "of": "posture", "value": 0.5}`.
    Weight(String, PerRow),
    /// A trajectory: `{"do": "follow", "of": "contact_force", "reference": {"type": "hold", "value": [3]}}`.
    Follow(String, Box<dyn AnyReference>),
    /// A task or constraint on or off: `{"do": "entry", "of": "posture", "on": false}`.
    Entry(String, bool),
    /// A contact on or off: `{"do": "contact", "of": "tip", "on": true}`.
    Contact(String, bool),
    /// The zero of a contact's force sensor: `{"do": "tare", "of": "tip"}`.
    Tare(String),
}

/// Why a change was refused.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ChangeError {
    /// It is not of this shape.
    #[error("{0}")]
    Shape(String),
    /// The controller refuses it.
    #[error(transparent)]
    Request(#[from] RequestError),
}

impl Change {
    /// Reads one.
    ///
    /// # Errors
    /// What is not of the shape that the variants show.
    pub fn from_json(text: &str) -> Result<Self, ChangeError> {
        let value: Value = serde_json::from_str(text).map_err(|e| shape(&e.to_string()))?;
        let Value::Object(mut keys) = value else {
            return Err(shape("a change must be an object"));
        };
        let Some(Value::String(of)) = keys.remove("of") else {
            return Err(shape("a change needs `of`, a name"));
        };
        let kind = keys.remove("do");
        Ok(match kind.as_ref().and_then(Value::as_str) {
            Some("set") => Self::Set(of, table(take(&mut keys, "keys")?)?),
            Some("weight") => {
                let weight = serde_json::from_value(take(&mut keys, "value")?);
                Self::Weight(of, weight.map_err(|e| shape(&e.to_string()))?)
            }
            Some("follow") => {
                let reference = toml::Value::Table(table(take(&mut keys, "reference")?)?);
                let reference = reference.try_into::<Box<dyn AnyReference>>();
                Self::Follow(of, reference.map_err(|e| shape(e.message().trim_end()))?)
            }
            Some("entry") => Self::Entry(of, on(&keys)?),
            Some("contact") => Self::Contact(of, on(&keys)?),
            Some("tare") => Self::Tare(of),
            _ => {
                let known = "`set`, `weight`, `follow`, `entry`, `contact` or `tare`";
                return Err(shape(&format!("`do` must be {known}")));
            }
        })
    }

    /// Asks a controller for it; it holds from the next tick on.
    ///
    /// # Errors
    /// What the controller refuses; nothing has changed then.
    pub fn apply(&self, controller: &mut Controller) -> Result<(), ChangeError> {
        match self {
            Self::Set(entry, keys) => controller.set(entry, keys.clone())?,
            Self::Weight(entry, weight) => controller.reweight(entry, weight.clone())?,
            Self::Follow(task, reference) => controller.follow(task, reference.clone())?,
            Self::Entry(entry, true) => controller.activate(entry)?,
            Self::Entry(entry, false) => controller.deactivate(entry)?,
            Self::Contact(contact, true) => controller.activate_contact(contact)?,
            Self::Contact(contact, false) => controller.deactivate_contact(contact)?,
            Self::Tare(contact) => controller.tare(contact)?,
        }
        Ok(())
    }
}

fn shape(what: &str) -> ChangeError {
    ChangeError::Shape(what.to_owned())
}

fn take(keys: &mut Map<String, Value>, key: &str) -> Result<Value, ChangeError> {
    keys.remove(key)
        .ok_or_else(|| shape(&format!("`{key}` is missing")))
}

fn on(keys: &Map<String, Value>) -> Result<bool, ChangeError> {
    let on = keys.get("on").and_then(Value::as_bool);
    on.ok_or_else(|| shape("`on` must be true or false"))
}

fn table(value: Value) -> Result<toml::Table, ChangeError> {
    toml::Table::try_from(value).map_err(|e| shape(&e.to_string()))
}
