//! Signals of a log, several of a topic at once.

use wbqp_measures::{MeasureError, Recording, Series, log::Log};

/// Numbers over time, by JSON pointers; true is 1 and false is 0, what a message does not have is NaN.
///
/// # Errors
/// A message that is not JSON. A topic without messages has no samples.
pub(super) fn columns(
    log: &Log,
    topic: &str,
    pointers: &[String],
) -> Result<Vec<Series>, MeasureError> {
    if log.has(topic) {
        log.columns(topic, pointers)
    } else {
        Ok(vec![Series::default(); pointers.len()])
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
