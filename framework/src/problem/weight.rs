//! Weights of an entry's rows, and their way to new ones.
//!
//! # Mathematics
//! After a change at `t₀` each weight goes by `w = w₀ + (w₁ − w₀) s((t − t₀)/τ)` with the smoothstep
//! `s(x) = 3x² − 2x³`, where τ is the entry's transition.

use crate::{plugin::PerRow, switch::smoothstep};

/// Weights that change over time, one per row.
#[derive(Clone, Debug)]
pub(crate) struct WeightRamp {
    now: Vec<f64>,
    from: Vec<f64>,
    to: Vec<f64>,
    transition: f64,
    phase: Phase,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    Constant,
    /// Asked for since the last tick.
    Pending,
    /// Since that time, s.
    Under(f64),
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

    /// This tick's weights.
    pub(crate) fn now(&self) -> &[f64] {
        &self.now
    }

    /// The weights when everything that was asked for is done.
    pub(crate) fn wanted(&self) -> &[f64] {
        &self.to
    }

    /// Asks for other weights from the next tick on.
    pub(crate) fn turn(&mut self, weight: &PerRow) {
        for (row, w) in self.to.iter_mut().enumerate() {
            *w = weight.row(row);
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

    /// Makes the weights those of a time, s.
    pub(crate) fn update(&mut self, time: f64) {
        let since = match self.phase {
            Phase::Constant => return,
            Phase::Pending => {
                self.from.copy_from_slice(&self.now);
                self.phase = Phase::Under(time);
                time
            }
            Phase::Under(since) => since,
        };
        let elapsed = time - since;
        if elapsed >= self.transition {
            self.now.copy_from_slice(&self.to);
            self.phase = Phase::Constant;
            return;
        }
        let s = smoothstep(elapsed / self.transition);
        for ((now, from), to) in self.now.iter_mut().zip(&self.from).zip(&self.to) {
            *now = from + (to - from) * s;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{PerRow, WeightRamp};

    #[test]
    fn goes_from_where_it_is_to_where_it_is_sent() {
        let mut weight = WeightRamp::new(vec![1.0, 2.0], 2.0);
        let at = |weight: &mut WeightRamp, time| {
            weight.update(time);
            weight.now().to_vec()
        };
        assert_eq!(at(&mut weight, 5.0), [1.0, 2.0]);
        weight.turn(&PerRow::Each(vec![3.0, 0.0]));
        assert_eq!(weight.now(), [1.0, 2.0]);
        assert_eq!(at(&mut weight, 6.0), [1.0, 2.0]);
        assert_eq!(at(&mut weight, 7.0), [2.0, 1.0]);
        // On the way it turns without a jump.
        weight.turn(&PerRow::Uniform(2.0));
        assert_eq!(at(&mut weight, 7.0), [2.0, 1.0]);
        assert_eq!(at(&mut weight, 8.0), [2.0, 1.5]);
        assert_eq!(at(&mut weight, 9.0), [2.0, 2.0]);
    }

    #[test]
    fn without_transition_it_jumps() {
        let mut weight = WeightRamp::new(vec![1.0], 0.0);
        weight.turn(&PerRow::Uniform(4.0));
        weight.update(1.0);
        assert_eq!(weight.now(), [4.0]);
    }
}
