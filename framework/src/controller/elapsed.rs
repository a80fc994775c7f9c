//! How much time a tick stands for.
//!
//! # The rule
//! A tick stands for the time between its stamp and that of the last usable measurement, but for [`LONGEST`] periods at
//! the most: what happened in a longer gap nobody saw, and no integral counts it. Where there is no such measurement,
//! or the stamp is no later one, it stands for one period. A difference that is a period but for the rounding of the
//! stamps is exactly the period, so that a loop that keeps its rate computes the same bits whatever its stamps begin
//! with.
//!
//! Integrals of tasks, filters, and velocity references grow by this time
//! ([`Tick::elapsed`](crate::plugin::Tick::elapsed)). What an actuator's `slew` allows counts from the tick before, and
//! for a period at the most. What looks ahead, as limits on positions do, looks one period ahead. Ramps and references
//! are functions of the stamps.

/// The most periods that a tick stands for.
pub(super) const LONGEST: f64 = 4.0;
/// Share of a period that is rounding of stamps.
const ROUNDING: f64 = 1e-6;

/// The time that a tick with the stamp `now` stands for, s.
pub(super) fn elapsed(now: f64, last: Option<f64>, period: f64) -> f64 {
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
