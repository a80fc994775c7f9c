//! The way of a plug-in through a file and back.

use serde_json::Value as Json;
use toml::{Table, Value};

use crate::{
    Check,
    report::Report,
    subject::{Subject, load},
};
use wbqp::registry;

/// Keys of the framework's entry around a plug-in.
const RESERVED: [&str; 6] = [
    "name",
    "weight",
    "active",
    "transition",
    "hardness",
    "level",
];

/// What no plug-in has a key for. The value fits neither a number, nor a text, nor a table.
const UNKNOWN: &str = "no_plugin_has_this_key";

/// Checks the form; gives the table that plug-ins are made from, if any can be made.
pub(crate) fn check<P: Subject + ?Sized>(
    text: &Result<String, String>,
    report: &mut Report,
) -> Option<Table> {
    let fail = |report: &mut Report, message: String| report.fail(Check::Form, "", message);
    let given: Table = match text {
        Ok(text) => match text.parse() {
            Ok(table) => table,
            Err(error) => {
                fail(report, format!("the text is no TOML: {error}"));
                return None;
            }
        },
        Err(reason) => {
            fail(report, format!("cannot be saved: {reason}"));
            return None;
        }
    };
    if let Some(Value::String(tag)) = given.get("type") {
        report.named(tag);
    }
    if let Some(key) = RESERVED.iter().find(|key| given.contains_key(**key)) {
        let message = format!(
            "key `{key}` belongs to the framework's entry; give the plug-in's own keys alone"
        );
        fail(report, message);
        return None;
    }
    let plugin = match load::<P>(&given) {
        Ok(plugin) => plugin,
        Err(reason) => {
            fail(report, format!("does not load: {reason}"));
            return None;
        }
    };
    if let Err(reason) = round_trip::<P>(&given, &plugin) {
        fail(report, reason);
    }
    refuses_unknown_keys::<P>(&given, report);
    schema::<P>(&given, report);
    Some(given)
}

fn round_trip<P: Subject + ?Sized>(given: &Table, plugin: &P) -> Result<(), String> {
    let saved = plugin
        .save()
        .map_err(|reason| format!("cannot be saved: {reason}"))?;
    if let Some(path) = lost(given, &saved) {
        return Err(format!("`{path}` is not what was given after saving"));
    }
    let again =
        load::<P>(&saved).map_err(|reason| format!("does not load what it saves: {reason}"))?;
    if again.save()? != saved {
        return Err("load, save, load, save does not give the same".into());
    }
    let text = plugin
        .to_json()
        .map_err(|reason| format!("cannot be saved as JSON: {reason}"))?;
    let again = P::from_json(&text)
        .map_err(|reason| format!("does not load the JSON it saves: {reason}"))?;
    if again.save()? != saved {
        return Err("saving as JSON and loading changes it".into());
    }
    Ok(())
}

/// The first key that was given and is missing or different in what was saved.
fn lost(given: &Table, saved: &Table) -> Option<String> {
    given.iter().find_map(|(key, value)| match saved.get(key) {
        Some(saved) => differs(value, saved).map(|rest| format!("{key}{rest}")),
        None => Some(key.clone()),
    })
}

/// Where two values differ; integers and numbers with a point are the same.
fn differs(given: &Value, saved: &Value) -> Option<String> {
    let number = |value: &Value| match value {
        Value::Integer(i) => Some(*i as f64),
        Value::Float(x) => Some(*x),
        _ => None,
    };
    let same = match (given, saved) {
        (Value::Table(given), Value::Table(saved)) => {
            return lost(given, saved).map(|path| format!(".{path}"));
        }
        (Value::Array(given), Value::Array(saved)) if given.len() == saved.len() => {
            return given
                .iter()
                .zip(saved)
                .enumerate()
                .find_map(|(i, (given, saved))| {
                    differs(given, saved).map(|rest| format!("[{i}]{rest}"))
                });
        }
        _ => match (number(given), number(saved)) {
            (Some(a), Some(b)) => a == b || (a.is_nan() && b.is_nan()),
            _ => given == saved,
        },
    };
    (!same).then(String::new)
}

fn refuses_unknown_keys<P: Subject + ?Sized>(given: &Table, report: &mut Report) {
    for path in tables(given) {
        let mut changed = given.clone();
        let Some(table) = at(&mut changed, &path) else {
            continue;
        };
        let nonsense = Value::Array(vec![Value::Array(vec![Value::Boolean(true)])]);
        table.insert(UNKNOWN.into(), nonsense);
        let (place, attribute) = if path.is_empty() {
            ("it".to_owned(), of_plugin::<P>())
        } else {
            let place = format!("`{}`", path.join("."));
            (place, "`#[wbqp::parameters]`".to_owned())
        };
        let mut accepts = |format: &str| {
            let message = format!(
                "{place} accepts an unknown key in {format}: {}",
                missing(&attribute)
            );
            report.fail(Check::UnknownKeys, "", message);
        };
        if load::<P>(&changed).is_ok() {
            accepts("TOML");
        }
        let json = serde_json::to_string(&changed).unwrap_or_default();
        if P::from_json(&json).is_ok() {
            accepts("JSON");
        }
    }
}

/// The attribute of a plug-in's parameters.
fn of_plugin<P: Subject + ?Sized>() -> String {
    format!("`#[wbqp::{}(…)]`", P::NAME)
}

/// What a type that accepts unknown keys lacks.
fn missing(attribute: &str) -> String {
    format!("its type has neither {attribute} nor `#[serde(deny_unknown_fields)]`")
}

/// Paths of a table and of all tables inside.
fn tables(table: &Table) -> Vec<Vec<String>> {
    let mut paths = vec![Vec::new()];
    for (key, value) in table {
        if let Value::Table(inner) = value {
            paths.extend(tables(inner).into_iter().map(|mut path| {
                path.insert(0, key.clone());
                path
            }));
        }
    }
    paths
}

fn at<'t>(table: &'t mut Table, path: &[String]) -> Option<&'t mut Table> {
    path.iter()
        .try_fold(table, |table, key| table.get_mut(key)?.as_table_mut())
}

fn schema<P: Subject + ?Sized>(given: &Table, report: &mut Report) {
    let tag = given
        .get("type")
        .and_then(Value::as_str)
        .unwrap_or_default();
    let Some(plugin) = registry::find::<P>(tag) else {
        return;
    };
    let schema = plugin.described();
    let schema = schema.as_value();
    let mut fail = |message: String| report.fail(Check::Schema, "", message);
    if !schema["description"].is_string() {
        fail("the plug-in has no description: its doc comment is empty".into());
    }
    let empty = serde_json::Map::new();
    let keys = schema["properties"].as_object().unwrap_or(&empty);
    for (key, about) in keys {
        if RESERVED.contains(&key.as_str()) || key == "type" {
            fail(format!("key `{key}` belongs to the framework"));
        }
        if !about["description"].is_string() {
            fail(format!(
                "key `{key}` has no description: its doc comment is empty"
            ));
        }
    }
    for key in given
        .keys()
        .filter(|key| *key != "type" && !keys.contains_key(*key))
    {
        fail(format!(
            "key `{key}` is not in the schema; configurations cannot use names that only serde knows, such as an alias"
        ));
    }
    if schema.get("additionalProperties") != Some(&Json::Bool(false)) {
        let message = missing(&of_plugin::<P>());
        fail(format!("the schema allows unknown keys: {message}"));
    }
}
