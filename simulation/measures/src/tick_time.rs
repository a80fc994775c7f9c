//! How long a tick takes.

use crate::{MeasureError, Recording, Row};

/// What its row has for an id.
pub(crate) const ID: &str = "time";

/// Median wall-clock time of a tick on the machine that ran the log; only informs.
///
/// # Errors
/// [`MeasureError`].
pub(crate) fn row(log: &dyn Recording) -> Result<Row, MeasureError> {
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
