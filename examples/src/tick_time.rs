//! How long a tick takes.

use crate::{
    log_reader::{Log, ReadError},
    results::Row,
};

/// What its row has for an id.
pub const ID: &str = "time";

/// Median wall-clock time of a tick on the machine that ran the log; only informs.
///
/// # Errors
/// [`ReadError`].
pub fn row(log: &Log) -> Result<Row, ReadError> {
    let total = log.series("/qp", "/times/total")?;
    // Without a stopwatch all times are zero.
    let median = total.quantile(0.5).filter(|t| *t > 0.0);
    Ok(Row::informative(
        ID,
        ("median wall-clock time of a tick on this machine", "µs"),
        None,
        median,
        "informative",
    ))
}
