//! The JSON Schema of a contact as a file may say it.

use serde_json::{Value, json};

use crate::config::json_schema::schema_of;
use crate::contact::{ContactSpec, Motion};

/// Keys of a contact that are written out: no contact has them afterwards.
pub(crate) const SHORT_KEYS: [&str; 3] = ["frames", "motion", "size"];

/// The long form's keys and the short ones. With `motion` there are defaults for what else must be there.
pub(crate) fn contact() -> Value {
    let mut schema = schema_of::<ContactSpec>();
    let mut motion = schema_of::<Motion>();
    motion["description"] = json!(
        "How the contact's motion is kept. With this key the contact brings its own constraints, is on at the start, \
         and touches the ground unless it says otherwise."
    );
    if let Some(properties) = schema["properties"].as_object_mut() {
        properties.insert("motion".to_owned(), motion);
        properties.insert(
            "frames".to_owned(),
            json!({
                "type": "array", "minItems": 1, "items": { "type": "string" },
                "description": "A contact at each of these frames, called by its frame; in place of `frame` and \
                                `name`.",
            }),
        );
        properties.insert(
            "size".to_owned(),
            json!({
                "type": "array", "minItems": 2, "maxItems": 2, "x-unit": "m",
                "items": { "type": "number", "exclusiveMinimum": 0 },
                "description": "Lengths of the sole along the surface's x and y, m; with `motion`. The contact is then \
                                of kind `full`.",
            }),
        );
        // A surface that says only where it is faces upwards.
        let short = json!({ "required": ["motion"] });
        let surface = properties.get_mut("surface").map(Value::take);
        let long = surface.unwrap_or_default();
        let mut any = long.clone();
        any["required"] = json!([]);
        properties.insert("surface".to_owned(), any);
        schema["if"] = short;
        schema["then"] = json!({});
        schema["else"] = json!({
            "required": ["kind", "surface"],
            "properties": { "surface": { "required": long["required"] }, "size": false },
        });
    }
    schema["required"] = json!([]);
    schema["anyOf"] = json!([{ "required": ["frame"] }, { "required": ["frames"] }]);
    schema
}
