//! Rows of the experiments, measured from runs whose numbers are known.

mod jumps;
mod memory;
mod push_and_slide;
mod push_away;
mod push_with_disturbance;
#[path = "../stories/mod.rs"]
mod stories;
mod under_actuated;

use wbqp_measures::Row;

/// The row with this id whose quantity has this text in it.
fn find<'a>(rows: &'a [Row], id: &str, text: &str) -> &'a Row {
    let found = rows
        .iter()
        .find(|r| r.id == id && r.quantity.contains(text));
    found.unwrap_or_else(|| panic!("no row {id} with `{text}`"))
}
