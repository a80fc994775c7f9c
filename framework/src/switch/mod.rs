//! On, off, and the ramp between; and the ramp from weights to others.
//!
//! A request between two ticks takes effect in the next one, and its ramp begins at that tick's time.
//!
//! # Mathematics
//! After a switch at `t₀` the activation goes from where it was, `α₀`, to its target (0 or 1) by
//! `α = α₀ + (target − α₀) s((t − t₀)/τ)` with the smoothstep `s(x) = 3x² − 2x³`. After a change at `t₀` each weight
//! goes by `w = w₀ + (w₁ − w₀) s((t − t₀)/τ)`, where τ is the entry's transition.

mod requests;

use serde::{Deserialize, Serialize};

/// The switch of an entry or a contact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Switch {
    on: bool,
    /// What it is to be from the next tick on.
    wanted: bool,
    transition: f64,
    since: f64,
    from: f64,
}

impl Switch {
    /// Begins the ramp that was asked for, or jumps without transition, at the time of this tick. Whether it is on
    /// now, if it was switched.
    pub(crate) fn settle(&mut self, now: f64) -> Option<bool> {
        if self.wanted == self.on {
            return None;
        }
        self.from = self.alpha(now);
        self.on = self.wanted;
        self.since = now;
        Some(self.on)
    }

    /// Activation at time `now`, 0 to 1.
    pub(crate) fn alpha(&self, now: f64) -> f64 {
        let target = if self.on { 1.0 } else { 0.0 };
        let elapsed = now - self.since;
        if elapsed >= self.transition {
            return target;
        }
        self.from + (target - self.from) * smoothstep(elapsed / self.transition)
    }

    /// Whether it is on, or still ramping off.
    pub(crate) fn is_live(&self, now: f64) -> bool {
        self.on || self.alpha(now) > 0.0
    }

    pub(crate) fn is_on(&self) -> bool {
        self.on
    }

    pub(crate) fn since(&self) -> f64 {
        self.since
    }
}

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
    /// This tick's weights.
    pub(crate) fn now(&self) -> &[f64] {
        &self.now
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

/// `3x² − 2x³` between 0 and 1, constant outside.
pub(crate) fn smoothstep(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

#[cfg(test)]
mod tests {
    use super::{Switch, WeightRamp};

    #[test]
    fn ramps_smoothly_and_turns_around_without_a_jump() {
        let mut s = Switch::new(false, 2.0);
        assert!(!s.is_live(5.0));
        s.turn(true);
        assert!(!s.is_on() && !s.is_live(9.9), "not before the next tick");
        assert_eq!(s.settle(10.0), Some(true));
        assert_eq!(s.since(), 10.0);
        s.turn(true);
        assert_eq!(s.settle(10.5), None, "already on");
        assert_eq!(s.alpha(10.0), 0.0);
        assert_eq!(s.alpha(11.0), 0.5);
        let before = s.alpha(11.5);
        s.turn(false);
        assert_eq!(s.settle(11.5), Some(false));
        assert_eq!(s.alpha(11.5), before);
        assert!(s.is_live(13.0));
        assert!(!s.is_live(13.5));
    }

    #[test]
    fn without_transition_it_jumps() {
        let mut s = Switch::new(true, 0.0);
        s.turn(false);
        s.settle(1.0);
        assert!(!s.is_live(1.0));
    }

    #[test]
    fn a_request_that_is_taken_back_is_none() {
        let mut s = Switch::new(true, 0.0);
        s.turn(false);
        s.turn(true);
        assert_eq!(s.settle(1.0), None);
    }

    #[test]
    fn goes_from_where_it_is_to_where_it_is_sent() {
        let mut weight = WeightRamp::new(vec![1.0, 2.0], 2.0);
        let at = |weight: &mut WeightRamp, time| {
            weight.update(time);
            weight.now().to_vec()
        };
        assert_eq!(at(&mut weight, 5.0), [1.0, 2.0]);
        weight.turn(|row| [3.0, 0.0][row]);
        assert_eq!(weight.now(), [1.0, 2.0]);
        assert_eq!(at(&mut weight, 6.0), [1.0, 2.0]);
        assert_eq!(at(&mut weight, 7.0), [2.0, 1.0]);
        // On the way it turns without a jump.
        weight.turn(|_| 2.0);
        assert_eq!(at(&mut weight, 7.0), [2.0, 1.0]);
        assert_eq!(at(&mut weight, 8.0), [2.0, 1.5]);
        assert_eq!(at(&mut weight, 9.0), [2.0, 2.0]);
    }

    #[test]
    fn weights_jump_without_transition() {
        let mut weight = WeightRamp::new(vec![1.0], 0.0);
        weight.turn(|_| 4.0);
        weight.update(1.0);
        assert_eq!(weight.now(), [4.0]);
    }
}
