//! One smooth move.

use wbqp::prelude::*;

use super::leg::{self, Leg};
use crate::check;

/// Moves once, from rest to rest, with the least jerk. It holds before and after.
///
/// `value = from + s(t/T) (to − from)` with `s(τ) = 10τ³ − 15τ⁴ + 6τ⁵`, and for rotations about one fixed axis, the
/// short way, `R = exp(s log(R_to R_fromᵀ)) R_from`.
///
/// Rates and accelerations are the exact derivatives.
///
/// It begins at rest also where it replaces a reference that moves.
#[wbqp::reference("min_jerk")]
pub struct MinJerk {
    /// Where it ends, in the task's unit (m, rad or N); `[roll, pitch, yaw]` in rad for a rotation.
    #[wbqp(unit = "the task's")]
    pub to: Vec<f64>,
    /// How long the move takes, s.
    #[wbqp(unit = "s")]
    pub duration: f64,
    /// Where it begins, in the unit of `to`. Without it, what the task followed before; at the start, what is
    /// measured.
    #[wbqp(unit = "the task's")]
    pub from: Option<Vec<f64>>,
    /// Delay before the move begins, s.
    #[wbqp(default, unit = "s")]
    pub start: f64,
}

impl MinJerk {
    /// Moves to a value within a duration in s, from where it takes over, at once.
    pub fn new(to: impl Into<Vec<f64>>, duration: f64) -> Self {
        Self {
            to: to.into(),
            duration,
            from: None,
            start: 0.0,
        }
    }

    /// Begins elsewhere than where it takes over.
    pub fn starting_at(mut self, value: impl Into<Vec<f64>>) -> Self {
        self.from = Some(value.into());
        self
    }

    /// Begins after a delay in s.
    pub fn after(mut self, delay: f64) -> Self {
        self.start = delay;
        self
    }
}

impl Reference for MinJerk {
    type Running = Leg;

    fn bind(&self, space: Space) -> Result<Leg, BindError> {
        check::positive("duration", self.duration)?;
        check::not_negative("start", self.start)?;
        Ok(Leg {
            begin: 0.0,
            duration: self.duration,
            from: leg::knot_or_room(space, "from", self.from.as_deref())?,
            to: leg::read_knot(space, &|| "to".to_owned(), &self.to)?,
        })
    }

    fn start(&self, leg: &mut Leg, time: f64, from: &Sample) {
        leg.begin = time + self.start;
        if self.from.is_none() {
            leg.from.stand_at(from);
        }
    }

    fn sample(&self, leg: &mut Leg, tick: &Tick<'_>, out: &mut Sample) {
        leg.at(tick.time, out);
    }

    fn values(&self) -> Vec<(String, &[f64])> {
        let from = self.from.as_deref();
        let from = from.map(|from| ("from".to_owned(), from));
        from.into_iter()
            .chain([("to".to_owned(), self.to.as_slice())])
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::references::leg::testing::{started, vector};

    #[test]
    fn waits_moves_and_holds() {
        let reference = MinJerk::new([3.0], 2.0).after(0.5);
        let leg = started(&reference, 10.0, &Sample::at_rest([1.0])).unwrap();
        let value = |time| {
            let mut out = Sample::new(Space::Vector(1));
            leg.at(time, &mut out);
            vector(out).value[0]
        };
        assert_eq!(value(10.0), 1.0);
        assert_eq!(value(10.5), 1.0);
        assert!((value(11.5) - 2.0).abs() < 1e-12);
        assert_eq!(value(12.5), 3.0);
    }

    #[test]
    fn begins_at_rest_where_the_last_one_moved() {
        let mut from = vector(Sample::at_rest([1.0, 2.0]));
        from.rate = vec![5.0, 5.0];
        let reference = MinJerk::new([3.0, 4.0], 1.0);
        let leg = started(&reference, 0.0, &Sample::Vector(from)).unwrap();
        let mut out = Sample::new(Space::Vector(2));
        leg.at(0.0, &mut out);
        assert_eq!(out, Sample::at_rest([1.0, 2.0]));
    }

    #[test]
    fn bad_numbers_are_refused_by_key() {
        for (key, reference) in [
            ("duration", MinJerk::new([3.0], 0.0)),
            ("duration", MinJerk::new([3.0], f64::NAN)),
            ("start", MinJerk::new([3.0], 1.0).after(-1.0)),
            ("to", MinJerk::new([3.0, 1.0], 1.0)),
            ("from", MinJerk::new([3.0], 1.0).starting_at([])),
        ] {
            let error = reference.bind(Space::Vector(1)).unwrap_err().to_string();
            assert!(error.starts_with(&format!("`{key}`")), "{error}");
        }
    }
}
