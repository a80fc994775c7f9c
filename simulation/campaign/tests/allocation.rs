//! A run into columns allocates as much as one that is twice as long: nothing per tick.

use std::{alloc::System, path::Path};

use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};
use wbqp_measures::Columns;
use wbqp_sim::{RunOptions, Scenario, Variation, run_case};

// Plug-ins are found once their crate is linked.
use {wbqp_robots as _, wbqp_tasks as _};

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Allocations of a run of so many seconds, s.
fn allocations(scenario: &Scenario, duration: f64) -> usize {
    let variation = Variation::new()
        .change("duration", duration)
        .change("plant.tolerance", 1e-6);
    let case = scenario.varied_case("with_ft", &variation).unwrap();
    let mut columns = Columns::with_capacity(10_000);
    let region = Region::new(ALLOCATOR);
    let options = RunOptions::default();
    let summary = run_case(scenario, &case, 1, &mut columns, options).unwrap();
    let counted = region.change();
    assert!(summary.ticks > 2000 && summary.diverged.is_none());
    counted.allocations + counted.reallocations
}

fn main() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let file = root.join("examples/scenarios/push_with_disturbance.toml");
    let scenario = Scenario::from_file(&file).unwrap();
    // In contact from 7 s on; the disturbance begins at 12 s.
    let (short, long) = (allocations(&scenario, 10.0), allocations(&scenario, 20.0));
    assert_eq!(short, long, "allocations in 10 s and in 20 s");
    println!("{short} allocations in 2500 and in 5000 ticks");
}
