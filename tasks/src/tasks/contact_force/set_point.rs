//! The set point of the normal force while the contact is switched on or off.

/// Turns a contact's activation α into a set point.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Ramp {
    /// α in the first update after the switch, and in the last one.
    first: Option<f64>,
    last: f64,
    release: Option<Release>,
}

/// Where the way out began.
#[derive(Clone, Copy, Debug)]
struct Release {
    alpha: f64,
    /// N.
    force: f64,
}

/// What to push with, N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum SetPoint {
    /// On, or on the way in.
    Follow(f64),
    /// On the way out: without feedback.
    Release(f64),
}

impl Ramp {
    /// One tick: `target` is `f^d`, `start` the force measured at the switch, `solution` the last `f_QP`, all N.
    ///
    /// In: `f = start + x (target − start)`, where x goes from 0 to 1 as α goes from where it was to 1. Out:
    /// `f = f_QP α/α₀` from the moment when α began to fall.
    pub(super) fn update(
        &mut self,
        alpha: f64,
        target: f64,
        start: f64,
        solution: f64,
    ) -> SetPoint {
        let first = *self.first.get_or_insert_with(|| {
            self.last = alpha;
            alpha
        });
        if alpha < self.last {
            // `alpha < last` makes the divisor below positive.
            self.release.get_or_insert(Release {
                alpha: self.last,
                force: solution,
            });
        }
        self.last = alpha;
        if let Some(release) = self.release {
            return SetPoint::Release(release.force * alpha / release.alpha);
        }
        let x = if first < 1.0 {
            (alpha - first) / (1.0 - first)
        } else {
            1.0
        };
        SetPoint::Follow(start + x * (target - start))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn goes_from_the_measured_force_to_the_set_point() {
        let mut ramp = Ramp::default();
        let mut at = |alpha| ramp.update(alpha, 5.0, 1.0, 3.0);
        assert_eq!(at(0.0), SetPoint::Follow(1.0));
        assert_eq!(at(0.5), SetPoint::Follow(3.0));
        assert_eq!(at(1.0), SetPoint::Follow(5.0));
        assert_eq!(at(1.0), SetPoint::Follow(5.0));
    }

    #[test]
    fn leaves_from_the_solution_and_ends_at_zero() {
        let mut ramp = Ramp::default();
        ramp.update(1.0, 5.0, 1.0, 5.8);
        ramp.update(1.0, 5.0, 1.0, 6.0);
        assert_eq!(ramp.update(0.75, 5.0, 1.0, 6.0), SetPoint::Release(4.5));
        // The solution at the moment of the switch counts, not later ones.
        assert_eq!(ramp.update(0.5, 5.0, 1.0, 9.0), SetPoint::Release(3.0));
        assert_eq!(ramp.update(0.0, 5.0, 1.0, 0.0), SetPoint::Release(0.0));
    }

    #[test]
    fn turning_round_on_the_way_out_starts_at_the_measured_force() {
        // The task is told of the new switch, so the ramp is a new one, with α in between.
        let mut ramp = Ramp::default();
        assert_eq!(ramp.update(0.5, 5.0, 2.0, 2.5), SetPoint::Follow(2.0));
        assert_eq!(ramp.update(0.75, 5.0, 2.0, 2.5), SetPoint::Follow(3.5));
        assert_eq!(ramp.update(1.0, 5.0, 2.0, 2.5), SetPoint::Follow(5.0));
    }

    #[test]
    fn without_a_transition_the_set_point_holds_at_once() {
        let mut ramp = Ramp::default();
        assert_eq!(ramp.update(1.0, 5.0, 1.0, 0.0), SetPoint::Follow(5.0));
    }
}
