//! Switches and weights before the first tick, and what is asked of them between ticks.

use super::{Phase, Switch, WeightRamp};

impl Default for Switch {
    /// Off, without a ramp.
    fn default() -> Self {
        Self::new(false, 0.0)
    }
}

impl Switch {
    /// Fully on or fully off from the start.
    pub(crate) fn new(on: bool, transition: f64) -> Self {
        Self {
            on,
            wanted: on,
            transition,
            since: f64::NEG_INFINITY,
            from: if on { 1.0 } else { 0.0 },
        }
    }

    /// Asks for a switch in the next tick.
    pub(crate) fn turn(&mut self, on: bool) {
        self.wanted = on;
    }

    /// Whether it is on from the next tick on.
    pub(crate) fn is_wanted(&self) -> bool {
        self.wanted
    }

    pub(crate) fn transition(&self) -> f64 {
        self.transition
    }
}

impl WeightRamp {
    pub(crate) fn new(weights: Vec<f64>, transition: f64) -> Self {
        Self {
            from: weights.clone(),
            to: weights.clone(),
            now: weights,
            transition,
            phase: Phase::Constant,
        }
    }

    /// The weights when everything that was asked for is done.
    pub(crate) fn wanted(&self) -> &[f64] {
        &self.to
    }

    /// Asks for other weights from the next tick on, by row.
    pub(crate) fn turn(&mut self, weight: impl Fn(usize) -> f64) {
        for (row, w) in self.to.iter_mut().enumerate() {
            *w = weight(row);
        }
        self.phase = Phase::Pending;
    }

    /// Makes the weights what they were in a recorded tick.
    pub(crate) fn hold(&mut self, recorded: &[f64]) {
        for (now, recorded) in self.now.iter_mut().zip(recorded) {
            *now = *recorded;
        }
        self.phase = Phase::Constant;
    }
}
