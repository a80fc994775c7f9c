//! Error-controlled steps between events.
//!
//! # Mathematics
//! The method of Dormand and Prince; the derivative at a step's end is that of the next one's start. The largest
//! estimated error `e` of a component, by the tolerance, is at most 1, and the next step is
//! ```text
//! h⁺ = h · clamp(0.9 e^−0.14 e_last^0.08, 0.2, 5)
//! ```
//! # Events
//! A contact is open or closed for a whole step. A step in which a point goes through a surface is taken again, up to
//! where it does: depths at both ends and their rates give the time, of which nothing is left but [`SURFACE`].
//! Disturbances begin and end between two steps. Sliding is continuous, but an anchor that has to be put back on the
//! friction cone after a step makes that step's error.
//!
//! # Bounds
//! A step's error goes with its fifth power. So the shortest step that the pace plans is
//! ```text
//! h_min = step / (8 max(1, 1e-6/tolerance)^⅕)
//! ```
//! and a step so short is taken whatever its error: of a smooth motion so fast that this is too long, the error still
//! falls with the tolerance. A duration in which more steps are tried than two for each `h_min`, because contacts open
//! and close all the time, goes on with equal ones of `h_min`: so there is always an end, and nothing is worse than it
//! is with equal steps. The time in such steps is counted ([`Plant::beyond_tolerance`]).

use wbqp::{
    dynamics::{Data, elementary::pow},
    state::State,
};

use super::{
    CLOCK, ContactTruth, Plant, SMALLEST_STEP,
    contact::Contact,
    layout::Layout,
    tableau::{A, ERROR, MIDDLE, STAGES, combine},
};

/// How far behind or before a surface a point may be when its contact closes or opens, m.
const SURFACE: f64 = 1e-9;
/// The shortest steps that are planned for one of the configured length, at the tolerance [`USUAL`] or a larger one.
const FINEST: f64 = 8.0;
/// Below this tolerance steps get shorter than the finest that do for it.
const USUAL: f64 = 1e-6;
/// Steps that are tried for one of the shortest, before equal ones take over.
const PATIENCE: f64 = 2.0;
/// What an error of thrust counts, m/s per N: a newton for a period of 10 ms moves a robot of a kilogram so fast.
const THRUST: f64 = 0.01;
/// How far an anchor may be outside the friction cone after a step, by the tolerance.
const SLIDE: f64 = 10.0;
/// Longest step that is kept in mind, s.
const LONGEST: f64 = 0.05;

/// What the next step goes by.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pace {
    /// s.
    step: f64,
    /// Of the last step, by the tolerance.
    error: f64,
}

impl Pace {
    pub(super) fn new(step: f64) -> Self {
        Self { step, error: 1.0 }
    }

    /// After a step of `h` s that was taken; the next one is no shorter than `least`.
    fn take(&mut self, h: f64, error: f64, least: f64) {
        let error = error.clamp(1e-10, 1e10);
        let factor = (0.9 * pow(error, -0.14) * pow(self.error, 0.08)).clamp(0.2, 5.0);
        // A step that was good may have been cut short by a touch or by the period's end.
        let least = if factor > 1.0 {
            self.step.max(least)
        } else {
            least
        };
        self.step = (h * factor).max(least).min(LONGEST);
        self.error = error;
    }
}

/// How much shorter steps get for a tolerance than for [`USUAL`].
fn refinement(tolerance: f64) -> f64 {
    pow((USUAL / tolerance).max(1.0), 0.2)
}

/// What is to be done with a step that was tried.
enum Verdict {
    Take {
        error: f64,
        switches: bool,
    },
    /// Again, with so many seconds.
    Again(f64),
}

impl Plant {
    /// Advances by `duration` s with errors below `tolerance` in each step.
    pub(super) fn advance_controlled(
        &mut self,
        duration: f64,
        tolerance: f64,
        observe: &mut impl FnMut(&Plant),
    ) {
        let end = self.time + duration;
        // Never near the clock's tolerance.
        let finest = (self.config.step / refinement(tolerance)).max(SMALLEST_STEP) / FINEST;
        let mut patience = PATIENCE * (duration / finest).ceil();
        // A wall may have been moved.
        self.settle_held();
        self.renew_rates();
        while !self.diverged && end - self.time > CLOCK {
            let target = self.next_edge(end);
            let left = target - self.time;
            let mut h = left / (left / self.pace.step - 0.01).ceil().max(1.0);
            for contact in &mut self.contacts {
                contact.start_step();
            }
            loop {
                if patience <= 0.0 {
                    let h = finest.min(left);
                    let is_last = h >= left - CLOCK;
                    self.beyond_tolerance += h;
                    self.step(h, if is_last { target } else { self.time + h });
                    observe(self);
                    break;
                }
                patience -= 1.0;
                self.attempt(h);
                match self.judge(h, tolerance, finest) {
                    Verdict::Again(shorter) => h = shorter,
                    Verdict::Take { error, switches } => {
                        let is_last = h >= left - CLOCK;
                        let at = if is_last { target } else { self.time + h };
                        self.pace.take(h, error, finest);
                        if error > 1.0 {
                            self.beyond_tolerance += h;
                        }
                        self.accept(h, at, switches, observe);
                        break;
                    }
                }
            }
        }
    }

    /// The next time at which a disturbance begins or ends, at most `end`.
    fn next_edge(&self, end: f64) -> f64 {
        let edges = self.disturbances.iter().flat_map(|d| [d.from, d.until]);
        edges
            .filter(|edge| *edge > self.time + CLOCK && *edge < end - CLOCK)
            .fold(end, f64::min)
    }

    /// Tries a step of `h` s from `x`, whose derivative is in `rates`. Leaves the state at its end in `work.x`, with
    /// kinematics and forces there, and all derivatives in `work.stages`.
    fn attempt(&mut self, h: f64) {
        let mut work = std::mem::replace(&mut self.work, super::Work::empty());
        let size = self.x.len();
        work.stages[..size].copy_from_slice(&self.rates);
        for contact in &mut self.contacts {
            contact.grazed = false;
        }
        for (s, weights) in A.iter().enumerate() {
            let (known, next) = work.stages.split_at_mut((s + 1) * size);
            combine(&mut work.x, &self.x, h, &weights[..=s], known);
            self.place(&work.x);
            self.hold_contacts(&work.x);
            self.evaluate_rates_quickly(&work.x, &mut next[..size]);
        }
        self.work = work;
    }

    fn judge(&mut self, h: f64, tolerance: f64, finest: f64) -> Verdict {
        let error = self.error(h) / tolerance;
        if h > finest && error > 1.0 {
            let factor = (0.9 * pow(error, -0.2)).clamp(0.2, 0.9);
            return Verdict::Again((h * factor).max(finest));
        }
        // A touch in passing is looked for less closely than an error: each time it costs one halving after the other.
        let shortest = FINEST * finest;
        let mut first = h;
        let mut switches = false;
        for contact in &self.contacts {
            if let Some(at) = contact.crossing(h, SURFACE) {
                switches = true;
                first = first.min(at);
            } else if contact.grazed && h > shortest {
                first = first.min((0.5 * h).max(shortest));
            }
        }
        // What is before a surface by less is a rounding of the clock.
        if first < h && h > 2.0 * CLOCK {
            return Verdict::Again(first.max(CLOCK));
        }
        Verdict::Take { error, switches }
    }

    /// Error of the step that was tried, as the tolerance counts it; infinite where a number is not finite.
    fn error(&self, h: f64) -> f64 {
        let size = self.x.len();
        let mut most = 0.0_f64;
        for i in 0..size {
            let stages = self.work.stages.chunks_exact(size);
            let sum: f64 = ERROR.iter().zip(stages).map(|(e, k)| e * k[i]).sum();
            if !sum.is_finite() {
                return f64::INFINITY;
            }
            let unit = if self.layout.is_thrust(i) {
                THRUST
            } else {
                1.0
            };
            most = most.max((unit * h * sum).abs());
        }
        for (i, contact) in self.contacts.iter().enumerate() {
            let anchor = self.layout.anchor(&self.work.x, i);
            most = most.max(contact.excess(&anchor) / SLIDE);
        }
        most
    }

    /// Goes on to the end of the step that was tried.
    fn accept(&mut self, h: f64, at: f64, switches: bool, observe: &mut impl FnMut(&Plant)) {
        let size = self.x.len();
        let start = self.time;
        if self.contacts.iter().any(|contact| contact.closed) {
            self.show_middle(start + 0.5 * h, h, observe);
        }
        std::mem::swap(&mut self.x, &mut self.work.x);
        self.time = at;
        let scale = Layout::normalise(&mut self.x);
        let last = (STAGES - 1) * size;
        self.rates
            .copy_from_slice(&self.work.stages[last..last + size]);
        Layout::scale_turn(&mut self.rates, scale);
        if switches {
            // What was until now, for those who take the forces for smooth.
            observe(self);
        }
        let moved = self.settle_held();
        if moved || self.is_edge(at) {
            self.renew_rates();
        }
        self.note_divergence();
        observe(self);
    }

    /// Opens and closes contacts and puts anchors where they belong; says whether that changes a force.
    fn settle_held(&mut self) -> bool {
        let mut changed = false;
        for (i, contact) in self.contacts.iter_mut().enumerate() {
            let mut anchor = self.layout.anchor(&self.x, i);
            if contact.settle_held(&mut anchor) {
                changed = true;
                self.layout.set_anchor(&mut self.x, i, &anchor);
                contact.evaluate_held(&self.data, &anchor);
            }
        }
        changed
    }

    fn is_edge(&self, at: f64) -> bool {
        let is_close = |edge: f64| (edge - at).abs() <= CLOCK;
        self.disturbances
            .iter()
            .any(|d| is_close(d.from) || is_close(d.until))
    }

    /// `ẋ` where the kinematics and the forces of contacts are known already.
    fn renew_rates(&mut self) {
        let x = std::mem::take(&mut self.x);
        let mut rates = std::mem::take(&mut self.rates);
        self.evaluate_rates_quickly(&x, &mut rates);
        self.x = x;
        self.rates = rates;
    }

    fn hold_contacts(&mut self, x: &[f64]) {
        for (i, contact) in self.contacts.iter_mut().enumerate() {
            let anchor = self.layout.anchor(x, i);
            contact.evaluate_held(&self.data, &anchor);
        }
    }

    /// Shows the plant in the middle of the step that was tried.
    fn show_middle(&mut self, time: f64, h: f64, observe: &mut impl FnMut(&Plant)) {
        let Some(mut middle) = self.middle.take() else {
            return;
        };
        combine(&mut middle.x, &self.x, h, &MIDDLE, &self.work.stages);
        let end = std::mem::replace(&mut self.time, time);
        middle.swap(self);
        let x = std::mem::take(&mut self.x);
        self.place(&x);
        self.hold_contacts(&x);
        self.x = x;
        self.within_step = true;
        observe(self);
        self.within_step = false;
        middle.swap(self);
        self.time = end;
        self.middle = Some(middle);
    }
}

/// Room for the state in the middle of a step, and for the one at its end while that is shown.
#[derive(Clone, Debug)]
pub(super) struct Middle {
    x: Vec<f64>,
    state: State,
    data: Data,
    truths: Vec<ContactTruth>,
}

impl Middle {
    pub(super) fn new(x: &[f64], state: &State, data: &Data, contacts: &[Contact]) -> Self {
        Self {
            x: x.to_vec(),
            state: state.clone(),
            data: data.clone(),
            truths: contacts.iter().map(|contact| contact.truth).collect(),
        }
    }

    fn swap(&mut self, plant: &mut Plant) {
        std::mem::swap(&mut self.x, &mut plant.x);
        std::mem::swap(&mut self.state, &mut plant.state);
        std::mem::swap(&mut self.data, &mut plant.data);
        for (own, contact) in self.truths.iter_mut().zip(&mut plant.contacts) {
            std::mem::swap(own, &mut contact.truth);
        }
    }
}
