//! The table of results: what the paper says, what was measured, whether it is within tolerance.

use std::{fs, io, path::Path};

use comfy_table::{Cell, CellAlignment, ContentArrangement, Table, presets};
use serde::{Deserialize, Serialize};
use wbqp::serde_json;

/// One figure of an experiment. `results.json` is a list of these, with exactly these keys.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// Row of the acceptance table, for example `B3`.
    pub id: String,
    /// What is measured, and over which window.
    pub quantity: String,
    /// Its unit.
    pub unit: String,
    /// The paper's value, where it has one.
    pub paper: Option<f64>,
    /// The value from the log; `null` if the log does not have it.
    pub measured: Option<f64>,
    /// What is accepted, in words.
    pub tolerance: String,
    /// Whether it is met; `null` for rows that only inform.
    pub pass: Option<bool>,
}

impl Row {
    /// A row that passes if the measured value exists and `accept` agrees.
    pub fn judged(
        id: &str,
        (quantity, unit): (&str, &str),
        paper: impl Into<Option<f64>>,
        measured: Option<f64>,
        tolerance: &str,
        accept: impl FnOnce(f64) -> bool,
    ) -> Self {
        Self {
            pass: Some(measured.is_some_and(accept)),
            ..Self::informative(id, (quantity, unit), paper, measured, tolerance)
        }
    }

    /// A row that neither passes nor fails.
    pub fn informative(
        id: &str,
        (quantity, unit): (&str, &str),
        paper: impl Into<Option<f64>>,
        measured: Option<f64>,
        tolerance: &str,
    ) -> Self {
        Self {
            id: id.to_owned(),
            quantity: quantity.to_owned(),
            unit: unit.to_owned(),
            paper: paper.into(),
            measured: measured.filter(|m| m.is_finite()),
            tolerance: tolerance.to_owned(),
            pass: None,
        }
    }
}

/// Writes `results.json`.
///
/// # Errors
/// If the file cannot be written.
pub fn write_json(rows: &[Row], path: &Path) -> io::Result<()> {
    let mut text = serde_json::to_string_pretty(rows)?;
    text.push('\n');
    fs::write(path, text)
}

/// The rows for a terminal: ✓ met, ✗ missed, · informative.
pub fn table(rows: &[Row]) -> Table {
    let mut table = Table::new();
    table
        .load_preset(presets::UTF8_HORIZONTAL_ONLY)
        .set_content_arrangement(ContentArrangement::Dynamic)
        .set_header([
            "", "row", "quantity", "paper", "measured", "unit", "accepted",
        ]);
    for row in rows {
        let mark = match row.pass {
            Some(true) => "✓",
            Some(false) => "✗",
            None => "·",
        };
        let right = |value: Option<f64>| {
            Cell::new(value.map_or_else(|| "–".to_owned(), number))
                .set_alignment(CellAlignment::Right)
        };
        table.add_row([
            Cell::new(mark),
            Cell::new(&row.id),
            Cell::new(&row.quantity),
            right(row.paper),
            right(row.measured),
            Cell::new(&row.unit),
            Cell::new(&row.tolerance),
        ]);
    }
    table
}

/// Four significant digits, without trailing zeros.
fn number(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let magnitude = value.abs().log10().floor();
    if !(-4.0..6.0).contains(&magnitude) {
        return format!("{value:.3e}");
    }
    let decimals = (3.0 - magnitude).max(0.0) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn serialises_with_exactly_the_promised_keys() {
        let row = Row::judged("B1", ("set point", "N"), 5.0, Some(5.0), "5 N", |m| {
            m == 5.0
        });
        assert_eq!(
            serde_json::to_string(&row).unwrap(),
            r#"{"id":"B1","quantity":"set point","unit":"N","paper":5.0,"measured":5.0,"tolerance":"5 N","pass":true}"#
        );
        let missing = Row::judged("B1", ("x", "N"), None, None, "", |_| true);
        assert_eq!((missing.pass, missing.paper), (Some(false), None));
        let not_finite = Row::judged("B1", ("x", "N"), None, Some(f64::NAN), "", |m| m < 1.0);
        assert_eq!((not_finite.pass, not_finite.measured), (Some(false), None));
    }

    #[test]
    fn numbers_are_short() {
        for (value, text) in [
            (5.0, "5"),
            (0.123456, "0.1235"),
            (1e-5, "1.000e-5"),
            (-12.3456, "-12.35"),
            (1500.0, "1500"),
            (0.0, "0"),
        ] {
            assert_eq!(number(value), text);
        }
    }

    #[test]
    fn the_table_shows_marks() {
        let rows = [
            Row::judged("a", ("x", ""), None, Some(1.0), "", |_| true),
            Row::judged("b", ("x", ""), None, Some(1.0), "", |_| false),
            Row::informative("c", ("x", ""), None, None, ""),
        ];
        let text = table(&rows).to_string();
        assert!(
            text.contains('✓') && text.contains('✗') && text.contains('·'),
            "{text}"
        );
    }
}
