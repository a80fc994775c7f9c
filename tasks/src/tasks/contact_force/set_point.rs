//! The set point of the normal force while the task or its contact is switched on or off.

use wbqp::plugin::Remembered;

/// Turns activations into a set point.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Ramp {
    entry: Option<Entry>,
    /// α of the contact in the last update.
    last: f64,
    release: Option<Release>,
}

/// Where the way in began.
#[derive(Clone, Copy, Debug)]
struct Entry {
    alpha: f64,
    /// Measured, N.
    force: f64,
    /// How far the way in is done; never goes back.
    done: f64,
}

/// Where the way out began.
#[derive(Clone, Copy, Debug)]
struct Release {
    alpha: f64,
    /// N.
    force: f64,
}

/// What is known in a tick.
#[derive(Clone, Copy, Debug)]
pub(super) struct Now {
    /// Activation of the contact.
    pub(super) contact: f64,
    /// Activation of the task times that of the contact.
    pub(super) task: f64,
    /// `f^d`, N.
    pub(super) target: f64,
    /// `f^m`, N.
    pub(super) measured: f64,
    /// The last `f_QP`, N.
    pub(super) solution: f64,
}

/// What to push with, N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum SetPoint {
    /// On, or on the way in.
    Follow(f64),
    /// The contact is on its way out: without feedback.
    Release(f64),
}

impl Ramp {
    /// Shows what is remembered from tick to tick.
    pub(super) fn remembered(&mut self, numbers: &mut Remembered<'_>) {
        let Self {
            entry,
            last,
            release,
        } = self;
        let none = Entry {
            alpha: 0.0,
            force: 0.0,
            done: 0.0,
        };
        numbers.option(entry, none, |numbers, entry| {
            numbers.numbers([&mut entry.alpha, &mut entry.force, &mut entry.done]);
        });
        numbers.number(last);
        let none = Release {
            alpha: 0.0,
            force: 0.0,
        };
        numbers.option(release, none, |numbers, release| {
            numbers.numbers([&mut release.alpha, &mut release.force]);
        });
    }

    /// One tick.
    ///
    /// In: `f = f₀ + x (f^d − f₀)`, where `f₀` is the force measured in the first tick and x goes from 0 to 1 as
    /// the task's activation goes from where it was to 1. Out, when the contact's falls: `f = f_QP α/α₀` from the
    /// moment when it began to. When the task's own falls alone, its weight does all: the set point stays.
    pub(super) fn update(&mut self, now: &Now) -> SetPoint {
        let entry = self.entry.get_or_insert_with(|| {
            self.last = now.contact;
            Entry {
                alpha: now.task,
                force: now.measured,
                done: 0.0,
            }
        });
        let x = if entry.alpha < 1.0 {
            (now.task - entry.alpha) / (1.0 - entry.alpha)
        } else {
            1.0
        };
        entry.done = entry.done.max(x);
        if now.contact < self.last {
            // `contact < last` makes the divisor below positive.
            self.release.get_or_insert(Release {
                alpha: self.last,
                force: now.solution,
            });
        }
        self.last = now.contact;
        if let Some(release) = self.release {
            return SetPoint::Release(release.force * now.contact / release.alpha);
        }
        SetPoint::Follow(entry.force + entry.done * (now.target - entry.force))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A contact and its task that go together; the target is 5 N.
    fn at(ramp: &mut Ramp, alpha: f64, measured: f64, solution: f64) -> SetPoint {
        both(ramp, [alpha, alpha], measured, solution)
    }

    fn both(ramp: &mut Ramp, [contact, task]: [f64; 2], measured: f64, solution: f64) -> SetPoint {
        ramp.update(&Now {
            contact,
            task,
            target: 5.0,
            measured,
            solution,
        })
    }

    #[test]
    fn goes_from_the_measured_force_to_the_set_point() {
        let mut ramp = Ramp::default();
        assert_eq!(at(&mut ramp, 0.0, 1.0, 3.0), SetPoint::Follow(1.0));
        // What was measured at the switch counts, not later.
        assert_eq!(at(&mut ramp, 0.5, 2.0, 3.0), SetPoint::Follow(3.0));
        assert_eq!(at(&mut ramp, 1.0, 3.0, 3.0), SetPoint::Follow(5.0));
        assert_eq!(at(&mut ramp, 1.0, 4.0, 3.0), SetPoint::Follow(5.0));
    }

    #[test]
    fn the_task_alone_ramps_as_well() {
        let mut ramp = Ramp::default();
        assert_eq!(both(&mut ramp, [1.0, 0.0], 1.0, 3.0), SetPoint::Follow(1.0));
        assert_eq!(both(&mut ramp, [1.0, 0.5], 2.0, 3.0), SetPoint::Follow(3.0));
        assert_eq!(both(&mut ramp, [1.0, 1.0], 3.0, 3.0), SetPoint::Follow(5.0));
        // Off again: it fades out by its weight.
        assert_eq!(both(&mut ramp, [1.0, 0.5], 5.0, 5.0), SetPoint::Follow(5.0));
    }

    #[test]
    fn leaves_from_the_solution_and_ends_at_zero() {
        let mut ramp = Ramp::default();
        at(&mut ramp, 1.0, 1.0, 5.8);
        at(&mut ramp, 1.0, 1.0, 6.0);
        assert_eq!(at(&mut ramp, 0.75, 1.0, 6.0), SetPoint::Release(4.5));
        // The solution at the moment of the switch counts, not later ones.
        assert_eq!(at(&mut ramp, 0.5, 1.0, 9.0), SetPoint::Release(3.0));
        assert_eq!(at(&mut ramp, 0.0, 1.0, 0.0), SetPoint::Release(0.0));
    }

    #[test]
    fn turning_round_on_the_way_out_starts_at_the_measured_force() {
        // The task is told of the new switch, so the ramp is a new one, with α in between.
        let mut ramp = Ramp::default();
        assert_eq!(at(&mut ramp, 0.5, 2.0, 2.5), SetPoint::Follow(2.0));
        assert_eq!(at(&mut ramp, 0.75, 2.0, 2.5), SetPoint::Follow(3.5));
        assert_eq!(at(&mut ramp, 1.0, 2.0, 2.5), SetPoint::Follow(5.0));
    }

    #[test]
    fn without_a_transition_the_set_point_holds_at_once() {
        let mut ramp = Ramp::default();
        assert_eq!(at(&mut ramp, 1.0, 1.0, 0.0), SetPoint::Follow(5.0));
    }
}
