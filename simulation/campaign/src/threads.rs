//! How many threads a campaign is worth.

use std::{num::NonZero, thread};

/// Threads for each core, at most: runs compute and wait for nothing, so that more of them only take memory.
const PER_CORE: usize = 4;

/// How many of the threads that are asked for do something for so many runs; for 0, which is one for each core, 0
/// again unless there are fewer runs.
pub fn useful_threads(asked: usize, runs: u64) -> usize {
    let cores = thread::available_parallelism().map_or(1, NonZero::get);
    let runs = usize::try_from(runs).unwrap_or(usize::MAX).max(1);
    match asked {
        0 if runs < cores => runs,
        0 => 0,
        _ => asked.min(PER_CORE * cores).min(runs),
    }
}
