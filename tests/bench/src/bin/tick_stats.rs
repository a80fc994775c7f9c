//! How long a tick takes, stage by stage, in a closed loop:
//! `cargo run --release --bin tick_stats -- --robot quadruped`.

use std::alloc::System;

use anyhow::Result;
use clap::Parser;
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};
use wbqp_bench::command::Arguments;

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

#[derive(Parser)]
struct CommandLine {
    #[command(flatten)]
    arguments: Arguments,
}

fn main() -> Result<()> {
    CommandLine::parse().arguments.run(Some(|| {
        let stats = Region::new(ALLOCATOR).initial();
        stats.allocations + stats.reallocations
    }))
}
