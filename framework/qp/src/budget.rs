//! What one solve may use up.

use std::fmt::Debug;

/// A monotonic clock given by the caller: the library reads none of its own.
pub trait Stopwatch: Send + Debug {
    /// Seconds since any fixed moment.
    fn now(&mut self) -> f64;
}

/// When a solve is to stop before its end.
#[derive(Debug)]
pub enum Budget<'a> {
    /// After the number of iterations that the solver is configured for.
    Configured,
    /// After that, or after the seconds that the solver is configured for, on this clock.
    Clock(&'a mut dyn Stopwatch),
    /// After this many iterations, whatever is configured.
    ///
    /// The number that a solve reported repeats that solve to the last bit, from the same warm start: it ends by itself
    /// if it did then, and stops where a clock stopped it.
    Iterations(u32),
}
