//! On, off, and the ramp between.
//!
//! # Mathematics
//! After a switch at `t₀` the activation goes from where it was, `α₀`, to its target (0 or 1) by
//! `α = α₀ + (target − α₀) s((t − t₀)/τ)` with the smoothstep `s(x) = 3x² − 2x³`.

/// The switch of an entry or a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Switch {
    on: bool,
    transition: f64,
    since: f64,
    from: f64,
}

impl Switch {
    /// Fully on or fully off from the start.
    pub(crate) fn new(on: bool, transition: f64) -> Self {
        Self {
            on,
            transition,
            since: f64::NEG_INFINITY,
            from: if on { 1.0 } else { 0.0 },
        }
    }

    /// Begins a ramp at time `now` (or jumps, without transition). False if nothing changes.
    pub(crate) fn turn(&mut self, on: bool, now: f64) -> bool {
        if self.on == on {
            return false;
        }
        self.from = self.alpha(now);
        self.on = on;
        self.since = now;
        true
    }

    /// Activation at time `now`, 0 to 1.
    pub(crate) fn alpha(&self, now: f64) -> f64 {
        let target = if self.on { 1.0 } else { 0.0 };
        let elapsed = now - self.since;
        if elapsed >= self.transition {
            return target;
        }
        let x = (elapsed / self.transition).clamp(0.0, 1.0);
        self.from + (target - self.from) * x * x * (3.0 - 2.0 * x)
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

#[cfg(test)]
mod tests {
    use super::Switch;

    #[test]
    fn ramps_smoothly_and_turns_around_without_a_jump() {
        let mut s = Switch::new(false, 2.0);
        assert!(!s.is_live(5.0));
        assert!(s.turn(true, 10.0));
        assert!(!s.turn(true, 10.5), "already on");
        assert_eq!(s.alpha(10.0), 0.0);
        assert_eq!(s.alpha(11.0), 0.5);
        let before = s.alpha(11.5);
        assert!(s.turn(false, 11.5));
        assert_eq!(s.alpha(11.5), before);
        assert!(s.is_live(13.0));
        assert!(!s.is_live(13.5));
    }

    #[test]
    fn without_transition_it_jumps() {
        let mut s = Switch::new(true, 0.0);
        s.turn(false, 1.0);
        assert!(!s.is_live(1.0));
    }
}
