//! What ends a solve.

use crate::{Status, Stopwatch};

/// Accuracy asked for, and what may be used up for it.
#[derive(Debug)]
pub(super) struct Limits<'a> {
    /// Accepted violation, relative to the numbers that are added up.
    pub(super) tolerance: f64,
    max_iterations: u32,
    /// The cap on iterations that is configured.
    configured: u32,
    clock: Option<Clock<'a>>,
    /// Iterations after which another method is tried.
    attempt: u32,
    /// Whether these alone are used up.
    has_attempt_ended: bool,
    were_used_up: bool,
}

#[derive(Debug)]
struct Clock<'a> {
    stopwatch: &'a mut dyn Stopwatch,
    end: f64,
}

impl<'a> Limits<'a> {
    pub(super) fn new(tolerance: f64, max_iterations: u32) -> Self {
        Self {
            tolerance,
            max_iterations,
            configured: max_iterations,
            clock: None,
            attempt: u32::MAX,
            has_attempt_ended: false,
            were_used_up: false,
        }
    }

    /// Ends after a number of iterations that is not the one configured.
    pub(super) fn with_cap(mut self, cap: u32) -> Self {
        self.max_iterations = cap;
        self
    }

    /// Ends after some seconds from now, if any are given.
    pub(super) fn with_clock(
        mut self,
        stopwatch: &'a mut dyn Stopwatch,
        budget: Option<f64>,
    ) -> Self {
        self.clock = budget.map(|budget| Clock {
            end: stopwatch.now() + budget,
            stopwatch,
        });
        self
    }

    /// Whether no further iteration may begin.
    ///
    /// The count that is passed grows from call to call, so that a cap on it ends a solve exactly where the clock did.
    pub(super) fn are_used_up(&mut self, iterations: u32) -> bool {
        let is_late = |clock: &mut Clock<'_>| clock.stopwatch.now() > clock.end;
        let are_used_up =
            iterations >= self.max_iterations || self.clock.as_mut().is_some_and(is_late);
        self.has_attempt_ended = !are_used_up && iterations >= self.attempt;
        self.were_used_up = are_used_up || self.has_attempt_ended;
        self.were_used_up
    }

    /// What the last answer was.
    pub(super) fn were_used_up(&self) -> bool {
        self.were_used_up
    }

    /// From here on one method may take so many iterations, counted from the first of the solve.
    pub(super) fn attempt_until(&mut self, iterations: u32) {
        self.attempt = iterations;
    }

    /// From here on one method may take all but so many of the iterations that are configured.
    pub(super) fn attempt_all_but(&mut self, iterations: u32) {
        self.attempt = self.configured.saturating_sub(iterations);
    }

    /// It may take no more than until then, either.
    pub(super) fn attempt_at_most(&mut self, iterations: u32) {
        self.attempt = self.attempt.min(iterations);
    }

    /// What the status is when they are. A cap below the configured one stands for a clock that ended a solve there.
    pub(super) fn status(&self, iterations: u32) -> Status {
        if self.has_attempt_ended {
            Status::Stalled
        } else if iterations >= self.configured {
            Status::IterationLimit
        } else {
            Status::TimeLimit
        }
    }
}
