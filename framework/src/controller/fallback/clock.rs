//! Time as ticks count it: how much one stands for, and how long ago something was.
//!
//! # How much time a tick stands for
//! A tick stands for the time between its stamp and that of the last usable state, but for [`LONGEST`] periods at
//! the most: what happened in a longer gap nobody saw, and no integral counts it. Where there is no such measurement,
//! or the stamp is no later one, it stands for one period. A difference that is a period but for the rounding of the
//! stamps is exactly the period, so that a loop that keeps its rate computes the same bits whatever its stamps begin
//! with.
//!
//! Integrals of tasks, filters, and velocity references grow by this time
//! ([`Tick::elapsed`](crate::plugin::Tick::elapsed)). What an actuator's `slew` allows counts from the tick before, and
//! for a period at the most. What looks ahead, as limits on positions do, looks one period ahead. Ramps and references
//! are functions of the stamps.

use super::Fallback;
use crate::controller::report::FallbackLevel;

/// For how many ticks after a contradiction the next one is looked for before the optimum.
const ALERT: u32 = 50;

/// Tells a stamp that is out of order from a clock that was set.
///
/// A stamp that is not later than the last usable one is a fault, and so is one that is later by more than a bound
/// (`max_gap`). A clock that goes on regularly from there, for [`Clock::STEADY`] ticks, was set: it is used again from
/// there, and the controller's own time goes on without a jump.
#[derive(Clone, Copy, Debug, Default)]
pub(in super::super) struct Clock {
    pub(in super::super) previous: Option<f64>,
    pub(in super::super) steady: u32,
}

/// Times between usable stamps, s: what is meant, and the longest that is taken.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Pace {
    pub(in super::super) period: f64,
    pub(in super::super) max_gap: f64,
}

/// When a tick is, s.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Moment {
    pub(in super::super) stamp: f64,
    pub(in super::super) since_last_tick: f64,
}

impl Clock {
    const STEADY: u32 = 10;

    /// Takes a stamp; true if the clock was set. `last` is the last usable stamp.
    pub(crate) fn was_set(&mut self, stamp: f64, last: Option<f64>, pace: Pace) -> bool {
        let Pace { period, max_gap } = pace;
        let goes_on = self.previous.is_some_and(|previous| {
            let step = stamp - previous;
            step > 0.0 && step < 10.0 * period
        });
        self.previous = Some(stamp);
        let is_off = last.is_some_and(|last| stamp <= last || stamp - last > max_gap);
        let was_perhaps_set = goes_on && is_off;
        self.steady = if was_perhaps_set { self.steady + 1 } else { 0 };
        if self.steady < Self::STEADY {
            return false;
        }
        self.steady = 0;
        true
    }
}

/// How long ago something was.
#[derive(Clone, Copy, Debug, Default)]
pub(in super::super) struct Age {
    /// Time stamp and ticks since; nothing if it never was.
    pub(in super::super) last: Option<(f64, u64)>,
    /// Whether it is in this tick, and never was before.
    pub(in super::super) is_first: bool,
}

impl Age {
    /// It is in this tick.
    pub(in super::super) fn renew(&mut self, time: f64) {
        self.is_first |= self.last.is_none();
        self.last = Some((time, 0));
    }

    /// A tick has begun.
    pub(in super::super) fn pass(&mut self) {
        self.is_first = false;
        if let Some((_, ticks)) = &mut self.last {
            *ticks = ticks.saturating_add(1);
        }
    }

    pub(in super::super) fn time(&self) -> Option<f64> {
        self.last.map(|(time, _)| time)
    }
}

impl Fallback {
    /// Whether limits contradicted one another a short time ago.
    pub(in super::super) fn is_alert(&self) -> bool {
        self.since_proof < ALERT && self.proof.iter().next().is_some()
    }

    /// A tick without a contradiction.
    pub(in super::super) fn calm(&mut self) {
        self.since_proof = self.since_proof.saturating_add(1);
    }
}

/// Since when the controller stands on a level.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in super::super) struct OnLevel {
    /// As [`Report::level_since`](crate::controller::Report::level_since).
    pub(in super::super) since: f64,
    /// Ticks on it.
    pub(in super::super) ticks: u64,
}

impl OnLevel {
    /// One more tick on a level; `last` is the last usable stamp.
    pub(in super::super) fn step(&mut self, changed: bool, now: f64, last: Option<f64>) {
        if changed || self.ticks == 0 {
            let now = Some(now).filter(|now| now.is_finite());
            self.since = now.or(last).unwrap_or(0.0);
            self.ticks = 0;
        }
        self.ticks = self.ticks.saturating_add(1);
    }
}

impl FallbackLevel {
    /// Whether the command is the solution of a problem of this tick.
    pub fn is_solved(self) -> bool {
        matches!(self, Self::Optimal | Self::Relaxed)
    }
}

/// The most periods that a tick stands for.
const LONGEST: f64 = 4.0;
/// Share of a period that is rounding of stamps.
const ROUNDING: f64 = 1e-6;

/// The time that a tick with the stamp `now` stands for, s.
pub(in super::super) fn elapsed(now: f64, last: Option<f64>, period: f64) -> f64 {
    let Some(last) = last else {
        return period;
    };
    let step = now - last;
    let rounding = (ROUNDING * period).max(4.0 * f64::EPSILON * last.abs());
    // Not a number, too.
    let is_later = step > 0.0;
    if !is_later || (step - period).abs() <= rounding {
        period
    } else {
        step.min(LONGEST * period)
    }
}

/// Whether what happened since the last usable state was seen: no more time has passed than a tick stands for,
/// and the clock was not set.
pub(in super::super) fn is_continuous(now: f64, last: Option<f64>, period: f64) -> bool {
    last.is_some_and(|last| now - last <= (LONGEST + ROUNDING) * period)
}

#[cfg(test)]
mod tests {
    use super::{LONGEST, elapsed};

    #[test]
    fn a_regular_clock_gives_the_period_to_the_bit() {
        for rate in [161.0, 250.0, 1000.0, 5000.0] {
            let period = 1.0 / rate;
            for start in [0.0, 1e3, 1.7e9] {
                for k in [1.0, 2.0, 77.0, 1e6] {
                    let (last, now) = (start + (k - 1.0) * period, start + k * period);
                    assert_eq!(elapsed(now, Some(last), period), period);
                }
            }
        }
    }

    #[test]
    fn other_stamps_count_up_to_a_limit() {
        let period = 0.004;
        let after = |step: f64| elapsed(1.0 + step, Some(1.0), period);
        for step in [1e-4, 0.0062, 0.0159] {
            assert!((after(step) - step).abs() < 1e-15);
        }
        assert_eq!(after(1e3), LONGEST * period);
        assert_eq!(after(f64::INFINITY), LONGEST * period);
        for nonsense in [0.0, -1.0, f64::NAN] {
            assert_eq!(after(nonsense), period);
        }
        assert_eq!(elapsed(5.0, None, period), period);
    }
}
