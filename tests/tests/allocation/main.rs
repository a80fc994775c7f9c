//! What allocates and how much: ticks and dynamics nothing, plug-ins nothing in a tick, a controller what is said
//! before it is made.
//!
//! The counting allocator is the whole process's: this is a program without the test harness, whose threads would be
//! counted too. All checks run, one after another, and those that failed are named at the end.

mod dynamics;
mod memory;
mod plugin_kit;
mod sensitivity;
mod ticks;

use std::{alloc::System, panic::catch_unwind, process::ExitCode};

use stats_alloc::{INSTRUMENTED_SYSTEM, StatsAlloc};

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Allocations and reallocations of the process so far.
fn allocations() -> usize {
    let stats = ALLOCATOR.stats();
    stats.allocations + stats.reallocations
}

/// A name and the check of that name, which panics if it fails.
macro_rules! checks {
    ($($module:ident::$name:ident),* $(,)?) => {
        [$((concat!(stringify!($module), "::", stringify!($name)), $module::$name as fn())),*]
    };
}

fn main() -> ExitCode {
    let checks = checks![
        dynamics::dynamics_do_not_allocate,
        memory::a_controller_takes_about_what_is_said,
        plugin_kit::tasks_pass_the_kit,
        plugin_kit::constraints_pass_the_kit,
        plugin_kit::no_plug_in_is_missing,
        sensitivity::derivatives_allocate_nothing,
        ticks::a_tick_allocates_nothing,
        ticks::a_tick_allocates_nothing_outside_clarabel,
        ticks::the_first_tick_allocates_nothing,
        ticks::no_rung_allocates,
    ];
    let mut failed = Vec::new();
    for (name, check) in checks {
        let passed = catch_unwind(check).is_ok();
        println!("check {name} ... {}", if passed { "ok" } else { "FAILED" });
        if !passed {
            failed.push(name);
        }
    }
    if failed.is_empty() {
        return ExitCode::SUCCESS;
    }
    println!("failed: {}", failed.join(", "));
    ExitCode::FAILURE
}
