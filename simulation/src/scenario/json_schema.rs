//! The JSON Schema of a scenario's file, with the linked references in it.

use wbqp::{
    config::json_schema::{compose, schema_of},
    serde_json::{Value, json},
};

use super::{change::LISTS, file::Keys};

/// Schema of a scenario's file. What `set` and `change` contain is checked when the file is loaded, not by the schema.
pub fn json_schema() -> Value {
    let mut schema = schema_of::<Keys>();
    schema["title"] = "wbqp scenario".into();
    // Beside its own keys, an entry of any list may say in which cases it is.
    for list in &LISTS {
        let table = list.path.iter().try_fold(&mut schema, |table, key| {
            let table = if table.get("items").is_some() {
                table.get_mut("items")?
            } else {
                table
            };
            table.get_mut("properties")?.get_mut(*key)
        });
        let keys = table.and_then(|list| list.get_mut("items")?.get_mut("properties"));
        if let Some(keys) = keys {
            keys["cases"] = json!({
                "type": "array",
                "minItems": 1,
                "items": { "type": "string" },
                "description": "The cases that have this entry; all, if left out.",
            });
        }
    }
    compose(&schema)
}
