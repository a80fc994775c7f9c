//! Signals of a log, several of a topic at once: a message is parsed once.

use wbqp::serde_json::Value;
use wbqp_examples::{
    log_reader::{Log, ReadError},
    series::Series,
};

/// Part of a JSON pointer to a field.
pub(super) fn escaped(name: &str) -> String {
    name.replace('~', "~0").replace('/', "~1")
}

/// Numbers over time, by JSON pointers; true is 1 and false is 0, what a message does not have is NaN.
///
/// # Errors
/// A message that is not JSON. A topic without messages has no samples.
pub(super) fn columns(
    log: &Log,
    topic: &str,
    pointers: &[String],
) -> Result<Vec<Series>, ReadError> {
    let mut columns = vec![Series::default(); pointers.len()];
    if !log.has(topic) {
        return Ok(columns);
    }
    for message in log.messages(topic)? {
        let (time, message) = message?;
        for (column, pointer) in columns.iter_mut().zip(pointers) {
            let value = message.pointer(pointer);
            column.t.push(time);
            column.y.push(value.map_or(f64::NAN, number));
        }
    }
    Ok(columns)
}

fn number(value: &Value) -> f64 {
    match value {
        Value::Bool(b) => f64::from(u8::from(*b)),
        other => other.as_f64().unwrap_or(f64::NAN),
    }
}

/// Euclidean norm of several signals with the same times, sample by sample.
pub(super) fn norm(columns: &[Series]) -> Series {
    let Some(first) = columns.first() else {
        return Series::default();
    };
    let y = (0..first.len()).map(|k| {
        let squares = columns.iter().filter_map(|c| c.y.get(k)).map(|y| y * y);
        squares.sum::<f64>().sqrt()
    });
    Series {
        t: first.t.clone(),
        y: y.collect(),
    }
}
