//! Experiment D as it ships: every row of its table.

use wbqp_examples::push_away;
use wbqp_tests::acceptance::{Missed, assert_every_row};

/// Rows that are missed, each with its reason.
const MISSED: &[Missed] = &[];

#[test]
fn every_row_is_met() {
    assert_every_row(&push_away::EXPERIMENT, MISSED, 19, &["free", "contact"]);
}
