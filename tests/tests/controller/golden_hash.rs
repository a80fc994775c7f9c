//! A closed loop is a function of its files and its seed: the bits of all commands are the same in every run and in
//! every build.
//!
//! `.ci/run` compares the build of these tests with one for release; by hand, two for release:
//! ```sh
//! cargo run --release --bin tick_stats -- --robot othex --ticks 5000 --hash
//! RUSTFLAGS="-C target-cpu=native" cargo run --release --target-dir target/native --bin tick_stats -- \
//!     --robot othex --ticks 5000 --hash
//! ```

use wbqp_bench::{
    hash, measure,
    workload::{Contact, Robot, Workload},
};

fn workload(robot: Robot) -> Workload {
    Workload::new(robot, Contact::Point, None, None).expect("ships")
}

#[test]
fn two_runs_are_equal_to_the_bit() {
    for robot in [Robot::Othex, Robot::Quadruped] {
        let hash = || hash(&workload(robot), 2000).expect("does not diverge");
        assert_eq!(hash(), hash(), "{robot:?}");
    }
}

#[test]
fn the_hash_sees_one_tick_more() {
    let hash = |ticks| hash(&workload(Robot::Othex), ticks).expect("does not diverge");
    assert_ne!(hash(100), hash(101));
}

/// The controller in the loop, one that is timed and one with a stopwatch compute the same bits, which `measure`
/// checks.
#[test]
fn a_tick_depends_on_the_measurements_alone() {
    for robot in [Robot::Othex, Robot::Quadruped] {
        let statistics = measure(&workload(robot), 3000, None, |_| ()).expect("twins agree");
        assert_eq!(statistics.ticks, 3000);
        assert_eq!(statistics.not_optimal, 0);
        assert!(statistics.tick.p50 > 0.0 && statistics.solve.p50 > 0.0);
        assert!(statistics.tick.p50 <= statistics.tick.p99);
    }
}
