//! The table of results for a terminal, and `results.json`.

use std::{fs, io, path::Path};

use comfy_table::{Cell, CellAlignment, ContentArrangement, Table, presets};
use wbqp::serde_json;
use wbqp_measures::{Row, number};

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
        .load_preset(presets::UTF8_FULL_CONDENSED)
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

#[cfg(test)]
mod tests {
    use super::*;

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
