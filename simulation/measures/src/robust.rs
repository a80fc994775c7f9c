//! The rows that are to hold whatever the controller does not know, in the variant of each scenario that is meant for
//! it: the paper's weights and gains, and an observer of the unknown wrench.

use crate::Row;

/// Rows of the acceptance table that are to hold.
pub const ROWS: [&str; 8] = ["B4", "C1", "C2", "D3", "D4", "D5", "E1", "E3"];

const PREFIX: &str = "robust, ";

/// Whether a row is one of these, of the robust variant.
pub fn is_robust(row: &Row) -> bool {
    row.quantity.starts_with(PREFIX)
}

/// Whether a row is the same of the paper's gains.
pub fn is_papers(row: &Row) -> bool {
    row.pass.is_some() && ROWS.contains(&row.id.as_str()) && !is_robust(row)
}

/// Those of these rows that are to hold, named as the variant's.
pub(crate) fn robust(rows: impl IntoIterator<Item = Row>) -> impl Iterator<Item = Row> {
    rows.into_iter().filter(is_papers).map(|row| Row {
        quantity: format!("{PREFIX}{}", row.quantity),
        paper: None,
        ..row
    })
}
