//! The numbers among the keys of a task or constraint, and where in its table each of them is.

use toml::{Table, Value};

/// A step into a table or a list.
#[derive(Clone, Debug)]
pub(super) enum Step {
    Key(String),
    Index(usize),
}

/// The way to each number of a table, nested ones included, references left out.
pub(super) fn find(table: &Table) -> Vec<Vec<Step>> {
    let mut found = Vec::new();
    in_table(table, &mut Vec::new(), &mut found);
    found
}

fn in_table(table: &Table, path: &mut Vec<Step>, found: &mut Vec<Vec<Step>>) {
    for (key, value) in table {
        path.push(Step::Key(key.clone()));
        in_value(value, path, found);
        path.pop();
    }
}

fn in_value(value: &Value, path: &mut Vec<Step>, found: &mut Vec<Vec<Step>>) {
    match value {
        Value::Float(x) if x.is_finite() => found.push(path.clone()),
        // Within an entry what has a type is a reference.
        Value::Table(table) if !table.contains_key("type") => in_table(table, path, found),
        Value::Array(list) => {
            for (index, value) in list.iter().enumerate() {
                path.push(Step::Index(index));
                in_value(value, path, found);
                path.pop();
            }
        }
        _ => {}
    }
}

/// The number at the end of a way.
pub(super) fn at(table: &Table, path: &[Step]) -> Option<f64> {
    let (Step::Key(key), rest) = path.split_first()? else {
        return None;
    };
    let into = |value, step: &Step| match step {
        Step::Key(key) => Value::get(value, key),
        Step::Index(index) => Value::get(value, *index),
    };
    let value = rest.iter().try_fold(table.get(key)?, into);
    value?.as_float()
}

/// Replaces the number at the end of a way.
pub(super) fn put(table: &mut Table, path: &[Step], number: f64) {
    let Some((Step::Key(key), rest)) = path.split_first() else {
        return;
    };
    let into = |value, step: &Step| match step {
        Step::Key(key) => Value::get_mut(value, key),
        Step::Index(index) => Value::get_mut(value, *index),
    };
    let first = table.get_mut(key);
    if let Some(place) = first.and_then(|value| rest.iter().try_fold(value, into)) {
        *place = Value::Float(number);
    }
}

/// A way as it is shown, and as the listing of plug-ins has it.
pub(super) fn written(path: &[Step]) -> (String, String) {
    let (mut shown, mut key) = (String::new(), String::new());
    for (i, step) in path.iter().enumerate() {
        match step {
            Step::Key(name) => {
                let dot = if i > 0 { "." } else { "" };
                shown.push_str(dot);
                shown.push_str(name);
                // Lists of tables are `points[].at` there, lists of numbers `kp`.
                let before = i.checked_sub(1).and_then(|i| path.get(i));
                if let Some(Step::Index(_)) = before {
                    key.push_str("[]");
                }
                key.push_str(dot);
                key.push_str(name);
            }
            Step::Index(index) => shown.push_str(&format!("[{index}]")),
        }
    }
    (shown, key)
}
