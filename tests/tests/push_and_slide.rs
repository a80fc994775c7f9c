//! Experiment C as it ships: every row of its table.

use wbqp_examples::push_and_slide;
use wbqp_tests::acceptance::{Missed, assert_every_row};

/// Rows that are missed, each with its reason.
const MISSED: &[Missed] = &[];

#[test]
fn every_row_is_met() {
    let cases = ["with_ff", "without_ff", "heavier", "heavier_integral"];
    assert_every_row(&push_and_slide::EXPERIMENT, MISSED, 13, &cases);
}
