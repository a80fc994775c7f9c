//! JSON schemas with units, in the part of the language that viewers understand: one `type` per field.

use serde_json::{Map, Value, json};

/// A number; the unit is in the description and, for programs, under `unit`.
pub fn number(unit: &str, description: &str) -> Value {
    json!({ "type": "number", "description": format!("{description}, {unit}"), "unit": unit })
}

/// A number without unit.
pub fn ratio(description: &str) -> Value {
    json!({ "type": "number", "description": description, "unit": "1" })
}

/// A count.
pub fn integer(description: &str) -> Value {
    json!({ "type": "integer", "description": description })
}

/// True or false.
pub fn boolean(description: &str) -> Value {
    json!({ "type": "boolean", "description": description })
}

/// A text.
pub fn text(description: &str) -> Value {
    json!({ "type": "string", "description": description })
}

/// An object with these fields and no other. Each may be absent.
pub fn object<N: Into<String>>(
    description: &str,
    fields: impl IntoIterator<Item = (N, Value)>,
) -> Value {
    let fields: Map<String, Value> = fields.into_iter().map(|(n, v)| (n.into(), v)).collect();
    json!({
        "type": "object",
        "description": description,
        "properties": fields,
        "additionalProperties": false,
    })
}

/// `x`, `y`, `z` of the same unit.
pub fn xyz(unit: &str, description: &str) -> Value {
    object(
        description,
        ["x", "y", "z"].map(|axis| (axis, number(unit, axis))),
    )
}

/// A list of the same kind of objects.
pub fn list(description: &str, item: &Value) -> Value {
    json!({ "type": "array", "description": description, "items": item })
}
