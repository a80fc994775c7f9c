//! What one solve may use up.

use crate::controller::Stopwatch;

/// When a solve is to stop before its end.
#[derive(Debug)]
pub enum Budget<'a> {
    /// After the seconds that the solver is configured for, on this clock; the library reads none of its own.
    Clock(&'a mut dyn Stopwatch),
    /// After this many iterations, whatever is configured.
    ///
    /// The number that a solve reported repeats that solve to the last bit, from the same warm start: it ends by itself if
    /// it did then, and stops where a clock stopped it.
    Iterations(u32),
}
