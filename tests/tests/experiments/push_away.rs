//! Experiment D as it ships: every row of its table is as promised.

use wbqp_replication::push_away;
use wbqp_tests::acceptance::assert_as_promised;

#[test]
fn every_row_is_as_promised() {
    assert_as_promised(&push_away::EXPERIMENT);
}
