//! The JSON Schema of a whole configuration, composed from the linked plug-ins: what an editor completes and checks
//! with.
//!
//! * Every kind of plug-in is a choice by `type`: an `if`/`then` per plug-in, which gives messages about the key that
//!   is wrong, and an `anyOf` that is always satisfied, which is where editors look for what can be completed.
//! * References inside a plug-in's own schema are written out, because some editors drop what stands beside a `$ref`.
//! * JSON has no `inf` and `nan`; editors turn them into `null`. So where a number is expected, `null` is accepted.

use std::collections::BTreeSet;

use schemars::{JsonSchema, SchemaGenerator};
use serde_json::{Map, Value, json};

use super::expand;
use crate::{
    plugin::{AnyConstraint, AnyFallbackLaw, AnyReference, AnyTask, Hardness, PerRow},
    qp::Solver,
    registry::{
        PluginKind,
        schema::{CRITICAL, WEIGHT},
    },
    settings::{MeasurementLimits, Settings},
};
use wbqp_robot_model::Robot;

/// Schemas of plain data nest less deeply.
const MAX_DEPTH: usize = 32;

/// Schema of a controller's file.
///
/// ```
/// let schema = wbqp::config::json_schema::controller();
/// assert_eq!(schema["required"], wbqp::serde_json::json!(["controller", "robot"]));
/// ```
pub fn controller() -> Value {
    let list =
        |items: Value, what: &str| json!({ "type": "array", "items": items, "description": what });
    let plugin = |kind: &str| json!({ "x-plugin": kind });
    let mut schema = compose(&json!({
        "title": "wbqp controller",
        "type": "object",
        "required": ["controller", "robot"],
        "additionalProperties": false,
        "properties": {
            "controller": schema_of::<Settings>(),
            "robot": plugin("robot"),
            "solver": plugin("solver"),
            "fallback": plugin("fallback"),
            "measurement": schema_of::<MeasurementLimits>(),
            "contact": list(expand::schema::contact(), "Contacts, in the order of their ids."),
            "task": list(plugin("task"), "Tasks: what the robot should do."),
            "constraint": list(plugin("constraint"), "Constraints: what must hold."),
        }
    }));
    let urdf = schema["$defs"].get("robot.urdf").cloned();
    if let Some(urdf) = urdf {
        let_files_be_urdfs(&mut schema["properties"]["robot"], urdf);
    }
    schema
}

/// A robot without a `type` is checked as a URDF.
fn let_files_be_urdfs(robot: &mut Value, mut urdf: Value) {
    for schema in [&mut *robot, &mut urdf] {
        if let Some(required) = schema["required"].as_array_mut() {
            required.retain(|key| key != "type");
        }
    }
    if let Some(cases) = robot["allOf"].as_array_mut() {
        let typed = json!({ "required": ["type"] });
        cases.push(json!({ "if": { "not": typed }, "then": urdf }));
    }
}

/// Schema of a type as schemars derives it, to be composed.
pub fn schema_of<T: JsonSchema>() -> Value {
    let mut schema = SchemaGenerator::default()
        .into_root_schema_for::<T>()
        .to_value();
    let root = schema.clone();
    inline(&mut schema, &root, 0);
    if let Some(table) = schema.as_object_mut() {
        table.remove("$defs");
        table.remove("$schema");
    }
    schema
}

/// Puts the linked plug-ins into a schema: wherever it says `"x-plugin": kind`, one of that kind.
pub fn compose(schema: &Value) -> Value {
    let mut definitions = Map::new();
    define::<dyn AnyTask>(&mut definitions, &entry_keys(Hardness::Soft));
    define::<dyn AnyConstraint>(&mut definitions, &entry_keys(Hardness::Hard));
    define::<dyn AnyReference>(&mut definitions, &json!({}));
    define::<dyn Robot>(&mut definitions, &json!({}));
    define::<dyn Solver>(&mut definitions, &json!({}));
    define::<dyn AnyFallbackLaw>(&mut definitions, &json!({}));
    let mut schema = schema.clone();
    choose(&mut schema);
    for definition in definitions.values_mut() {
        choose(definition);
    }
    let used = used(&schema, &definitions);
    definitions.retain(|name, _| used.contains(name));
    if let Some(table) = schema.as_object_mut() {
        table.insert(
            "$schema".to_owned(),
            json!("http://json-schema.org/draft-07/schema#"),
        );
        table.insert("$defs".to_owned(), Value::Object(definitions));
    }
    schema
}

/// The definitions that a schema refers to, also through other definitions.
fn used(schema: &Value, definitions: &Map<String, Value>) -> BTreeSet<String> {
    let mut used = BTreeSet::new();
    let mut to_do = vec![schema];
    while let Some(value) = to_do.pop() {
        match value {
            Value::Object(table) => {
                let reference = table.get("$ref").and_then(Value::as_str);
                if let Some(name) = reference.and_then(|text| text.strip_prefix("#/$defs/"))
                    && used.insert(name.to_owned())
                {
                    to_do.extend(definitions.get(name));
                }
                to_do.extend(table.values());
            }
            Value::Array(list) => to_do.extend(list),
            _ => {}
        }
    }
    used
}

/// The framework's keys of an entry, and when a weight is needed.
fn entry_keys(default: Hardness) -> Value {
    let needs_weight = match default {
        Hardness::Hard => json!([
            { "required": ["weight"] },
            { "not": { "required": ["hardness"] } },
            { "properties": { "hardness": { "const": "hard" } } },
        ]),
        _ => json!([
            { "required": ["weight"] },
            { "properties": { "hardness": { "const": "hard" } }, "required": ["hardness"] },
        ]),
    };
    let about = |mut schema: Value, what: &str| {
        schema["description"] = what.into();
        schema
    };
    json!({
        "anyOf": needs_weight,
        "properties": {
            "name": {
                "type": "string",
                "minLength": 1,
                "description": "Unique name: how logs, reports, errors and events call it. \
                                Default: `<frame>_<type>`, `<contact>_<type>` or `<type>`.",
            },
            "weight": about(
                schema_of::<PerRow>(),
                "Weight, a number or one per row, 0 or more: a row costs weight × residual². A hard entry needs none.",
            ),
            "active": { "type": "boolean", "default": true, "description": "Whether it is on at the start." },
            "transition": {
                "type": "number",
                "minimum": 0,
                "default": 0.0,
                "x-unit": "s",
                "description": "Duration of the ramp when it is switched or gets another weight, s.",
            },
            "hardness": about(schema_of::<Hardness>(), "\"hard\", \"soft\" or { exact = λ }."),
        }
    })
}

/// A definition per plug-in of a kind, with the keys that every one of them has.
fn define<P: PluginKind + ?Sized>(definitions: &mut Map<String, Value>, common: &Value) {
    for plugin in P::plugins() {
        let root = plugin.described().clone().to_value();
        let mut schema = root.clone();
        inline(&mut schema, &root, 0);
        let Some(table) = schema.as_object_mut() else {
            continue;
        };
        table.remove("$defs");
        table.remove("$schema");
        let weight = table.remove(WEIGHT);
        let mut properties = Map::new();
        properties.insert("type".to_owned(), json!({ "const": plugin.tag }));
        for keys in [common.get("properties"), table.get("properties")] {
            let keys = keys.and_then(Value::as_object).into_iter().flatten();
            properties.extend(keys.map(|(key, about)| (key.clone(), about.clone())));
        }
        let mut required = vec![json!("type")];
        for keys in [common.get("required"), table.get("required")] {
            required.extend(
                keys.and_then(Value::as_array)
                    .into_iter()
                    .flatten()
                    .cloned(),
            );
        }
        // A damping that has none is critical.
        let is_critical = |key: &Value| {
            let about = key.as_str().and_then(|key| properties.get(key));
            about.is_some_and(|about| about.get(CRITICAL).is_some())
        };
        required.retain(|key| !is_critical(key));
        if let (Some(default), Some(weight)) = (&weight, properties.get_mut("weight")) {
            weight["default"] = default.clone();
        }
        table.insert("type".to_owned(), json!("object"));
        table.insert("properties".to_owned(), Value::Object(properties));
        table.insert("required".to_owned(), Value::Array(required));
        // Serde looks for the plug-in's keys after the framework has taken its own and `type`.
        table.insert("additionalProperties".to_owned(), json!(false));
        if let (Some(any_of), None) = (common.get("anyOf"), &weight) {
            table.insert("anyOf".to_owned(), any_of.clone());
        }
        definitions.insert(name(P::NAME, plugin.tag), schema);
    }
}

/// Name of a definition; characters that would have to be escaped in a reference are left out.
fn name(kind: &str, tag: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "._-".contains(c);
    let tag: String = tag
        .chars()
        .map(|c| if plain(c) { c } else { '_' })
        .collect();
    format!("{kind}.{tag}")
}

/// Writes out what `$ref`s refer to, keeping what stands beside them, and lets numbers be `null`.
fn inline(schema: &mut Value, root: &Value, depth: usize) {
    if depth > MAX_DEPTH {
        return;
    }
    match schema {
        Value::Object(table) => {
            if let Some(Value::String(pointer)) = table.get("$ref")
                && let Some(target) = pointer
                    .strip_prefix('#')
                    .and_then(|path| root.pointer(path))
            {
                let target = target.as_object().cloned().unwrap_or_default();
                table.remove("$ref");
                for (key, value) in target {
                    table.entry(key).or_insert(value);
                }
            }
            name_choices(table);
            if table.get("type").is_some_and(|kind| kind == "number") {
                table.insert("type".to_owned(), json!(["number", "null"]));
            }
            for (key, value) in table.iter_mut() {
                if !["$defs", "default", "const", "enum"].contains(&key.as_str()) {
                    inline(value, root, depth + 1);
                }
            }
        }
        Value::Array(list) => list
            .iter_mut()
            .for_each(|value| inline(value, root, depth + 1)),
        _ => {}
    }
}

/// A choice of strings, each with its description, as an `enum`: of that, validators say what the choice is.
fn name_choices(table: &mut Map<String, Value>) {
    let Some(branches) = table.get("oneOf").and_then(Value::as_array) else {
        return;
    };
    let of_each = |key: &str| -> Option<Vec<Value>> {
        branches
            .iter()
            .map(|branch| branch.get(key).cloned())
            .collect()
    };
    let Some(values) = of_each("const") else {
        return;
    };
    let docs = of_each("description");
    table.remove("oneOf");
    table.insert("enum".to_owned(), Value::Array(values));
    if let Some(docs) = docs {
        table.insert(
            "x-taplo".to_owned(),
            json!({ "docs": { "enumValues": docs } }),
        );
    }
}

/// Replaces `"x-plugin": kind` by the choice among the plug-ins of that kind.
fn choose(schema: &mut Value) {
    match schema {
        Value::Object(table) => {
            let kind = table.remove("x-plugin");
            if let Some(kind) = kind.as_ref().and_then(Value::as_str) {
                let Value::Object(choice) = choice(kind) else {
                    return;
                };
                table.extend(choice);
                return;
            }
            table.values_mut().for_each(choose);
        }
        Value::Array(list) => list.iter_mut().for_each(choose),
        _ => {}
    }
}

fn choice(kind: &str) -> Value {
    let tags: Vec<&str> = match kind {
        "task" => tags::<dyn AnyTask>(),
        "constraint" => tags::<dyn AnyConstraint>(),
        "reference" => tags::<dyn AnyReference>(),
        "robot" => tags::<dyn Robot>(),
        "solver" => tags::<dyn Solver>(),
        "fallback" => tags::<dyn AnyFallbackLaw>(),
        _ => Vec::new(),
    };
    let definition = |tag: &&str| json!({ "$ref": format!("#/$defs/{}", name(kind, tag)) });
    let cases: Vec<Value> = tags
        .iter()
        .map(|tag| {
            json!({
                "if": { "properties": { "type": { "const": tag } }, "required": ["type"] },
                "then": definition(tag),
            })
        })
        .collect();
    let mut completions: Vec<Value> = tags.iter().map(definition).collect();
    completions.push(json!(true));
    json!({
        "type": "object",
        "required": ["type"],
        "properties": { "type": { "enum": tags, "description": format!("Which {kind}.") } },
        "allOf": cases,
        "anyOf": completions,
    })
}

fn tags<P: PluginKind + ?Sized>() -> Vec<&'static str> {
    let mut tags: Vec<_> = P::plugins().iter().map(|plugin| plugin.tag).collect();
    tags.dedup();
    tags
}
