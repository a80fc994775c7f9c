//! Changes of a running controller as JSON: the page keeps a list of them in its address.

use wbqp::{
    controller::{Change, RequestError},
    plugin::AnyReference,
    serde_json::{self, Map, Value},
    toml,
};

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

/// Reads a change:
///
/// * keys of a task or constraint, as in its file: `{"do": "set", "of": "base_position", "keys": {"kp": 20}}`
/// * a weight, one number or one per row: `{"do": "weight", "of": "posture", "value": 0.5}`
/// * a trajectory: `{"do": "follow", "of": "contact_force", "reference": {"type": "hold", "value": [3]}}`
/// * a task or constraint on or off: `{"do": "entry", "of": "posture", "on": false}`
/// * a contact on or off: `{"do": "contact", "of": "tip", "on": true}`
/// * the zero of a contact's force sensor: `{"do": "tare", "of": "tip"}`
///
/// # Errors
/// What is not of such a shape.
pub fn from_json(text: &str) -> Result<Change, ChangeError> {
    let value: Value = serde_json::from_str(text).map_err(|e| shape(&e.to_string()))?;
    let Value::Object(mut keys) = value else {
        return Err(shape("a change must be an object"));
    };
    let Some(Value::String(of)) = keys.remove("of") else {
        return Err(shape("a change needs `of`, a name"));
    };
    let kind = keys.remove("do");
    Ok(match kind.as_ref().and_then(Value::as_str) {
        Some("set") => Change::Set(of, table(take(&mut keys, "keys")?)?),
        Some("weight") => {
            let weight = serde_json::from_value(take(&mut keys, "value")?);
            Change::Weight(of, weight.map_err(|e| shape(&e.to_string()))?)
        }
        Some("follow") => {
            let reference = toml::Value::Table(table(take(&mut keys, "reference")?)?);
            let reference = reference.try_into::<Box<dyn AnyReference>>();
            Change::Follow(of, reference.map_err(|e| shape(e.message().trim_end()))?)
        }
        Some("entry") => Change::Entry(of, on(&keys)?),
        Some("contact") => Change::Contact(of, on(&keys)?),
        Some("tare") => Change::Tare(of),
        _ => {
            let known = "`set`, `weight`, `follow`, `entry`, `contact` or `tare`";
            return Err(shape(&format!("`do` must be {known}")));
        }
    })
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
