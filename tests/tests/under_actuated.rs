//! Experiment E as it ships: every row of its table.

use wbqp_examples::under_actuated;
use wbqp_tests::acceptance::{Missed, assert_every_row};

/// Rows that are missed, each with its reason.
const MISSED: &[Missed] = &[];

#[test]
fn every_row_is_met() {
    // The weights, and three rows of each case.
    let cases = ["literal", "attitude_reference"];
    assert_every_row(&under_actuated::EXPERIMENT, MISSED, 12, &cases);
}
