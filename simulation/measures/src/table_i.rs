//! The paper's Table I: weights of the tasks.

use toml::{Table, Value};

use crate::Row;

/// Symbols of the paper and the types of the tasks that stand for them, in the order of its columns.
const COLUMNS: [(&str, &str); 6] = [
    ("p_R", "base_position"),
    ("R_R", "base_orientation"),
    ("q_A", "posture"),
    ("p_f", "free_motion"),
    ("f_c", "contact_force"),
    ("r_a", "propeller_regularisation"),
];

/// Rows A1 of one experiment: the weights in its controller file against a row of the table.
pub(crate) fn rows(experiment: char, paper: [f64; 6], controller: &Table) -> Vec<Row> {
    let id = format!("A1-{experiment}");
    COLUMNS
        .into_iter()
        .zip(paper)
        .map(|((symbol, tag), paper)| {
            let part = if symbol == "f_c" { ", normal" } else { "" };
            let quantity = format!("weight of {symbol}{part} (Table I, row {experiment})");
            let measured = weight(controller, tag);
            Row::judged(&id, (&quantity, "1"), paper, measured, "exact", |w| {
                w == paper
            })
        })
        .collect()
}

/// Weight of the task of that type, 0 if there is none. Of a weight per row, the last: the normal force is the
/// last of the point contact's rows; for the other tasks all must be equal.
fn weight(controller: &Table, tag: &str) -> Option<f64> {
    let tasks = controller.get("task")?.as_array()?;
    let of_type = |task: &&Value| task.get("type").and_then(Value::as_str) == Some(tag);
    let Some(task) = tasks.iter().find(of_type) else {
        return Some(0.0);
    };
    match task.get("weight")? {
        Value::Array(rows) => {
            let last = number(rows.last()?)?;
            let uniform = rows.iter().all(|w| number(w) == Some(last));
            (uniform || tag == "contact_force").then_some(last)
        }
        one => number(one),
    }
}

/// A TOML number, integer or not.
pub(crate) fn number(value: &Value) -> Option<f64> {
    let integer = || value.as_integer().map(|i| i as f64);
    value.as_float().or_else(integer)
}
