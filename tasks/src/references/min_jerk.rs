//! One smooth move.

use wbqp::{
    error::BindError,
    plugin::{Reference, Sample, Start, Tick},
    schemars::JsonSchema,
    serde::{Deserialize, Serialize},
};

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
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(crate = "wbqp::serde", deny_unknown_fields)]
#[schemars(crate = "wbqp::schemars")]
pub struct MinJerk {
    /// Where it ends, in the task's unit (m, rad or N); `[roll, pitch, yaw]` in rad for a rotation.
    #[schemars(extend("x-unit" = "the task's"))]
    pub to: Vec<f64>,
    /// How long the move takes, s.
    #[schemars(extend("x-unit" = "s"))]
    pub duration: f64,
    /// Where it begins, in the unit of `to`. Without it, what the task followed before; at the start, what is
    /// measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "the task's"))]
    pub from: Option<Vec<f64>>,
    /// Delay before the move begins, s.
    #[serde(default)]
    #[schemars(extend("x-unit" = "s"))]
    pub start: f64,
    #[serde(skip)]
    leg: Option<Leg>,
}

impl MinJerk {
    /// Moves to a value within a duration in s, from where it takes over, at once.
    pub fn new(to: impl Into<Vec<f64>>, duration: f64) -> Self {
        Self {
            to: to.into(),
            duration,
            from: None,
            start: 0.0,
            leg: None,
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

    /// Writes the sample at a time (s, on the clock it was bound with). Nothing before it is bound.
    pub fn at(&self, time: f64, out: &mut Sample) {
        if let Some(leg) = &self.leg {
            leg.at(time, out);
        }
    }
}

#[wbqp::reference("min_jerk")]
impl Reference for MinJerk {
    fn bind(&mut self, start: &Start<'_>) -> Result<(), BindError> {
        check::positive("duration", self.duration)?;
        check::not_negative("start", self.start)?;
        let mut leg = self.leg.take().unwrap_or_else(Leg::unbound);
        leg.space = start.space;
        leg.begin = start.time + self.start;
        leg.duration = self.duration;
        leg::knot_or_take_over(start, "from", self.from.as_deref(), &mut leg.from)?;
        leg::knot_or_take_over(start, "to", Some(&self.to), &mut leg.to)?;
        self.leg = Some(leg);
        Ok(())
    }

    fn sample(&mut self, tick: &Tick<'_>, out: &mut Sample) {
        self.at(tick.time, out);
    }
}

#[cfg(test)]
mod tests {
    use wbqp::plugin::Space;

    use super::*;

    #[test]
    fn waits_moves_and_holds() {
        let mut reference = MinJerk::new([3.0], 2.0).after(0.5);
        let from = Sample::at_rest([1.0]);
        let start = Start {
            space: Space::Vector(1),
            time: 10.0,
            from: &from,
        };
        reference.bind(&start).unwrap();
        let value = |time| {
            let mut out = Sample::new(Space::Vector(1));
            reference.at(time, &mut out);
            out.value[0]
        };
        assert_eq!(value(10.0), 1.0);
        assert_eq!(value(10.5), 1.0);
        assert!((value(11.5) - 2.0).abs() < 1e-12);
        assert_eq!(value(12.5), 3.0);
    }

    #[test]
    fn begins_at_rest_where_the_last_one_moved() {
        let mut from = Sample::at_rest([1.0, 2.0]);
        from.rate = vec![5.0, 5.0];
        let mut reference = MinJerk::new([3.0, 4.0], 1.0);
        let start = Start {
            space: Space::Vector(2),
            time: 0.0,
            from: &from,
        };
        reference.bind(&start).unwrap();
        let mut out = Sample::new(Space::Vector(2));
        reference.at(0.0, &mut out);
        assert_eq!(out, Sample::at_rest([1.0, 2.0]));
    }

    #[test]
    fn bad_numbers_are_refused_by_key() {
        let from = Sample::at_rest([1.0]);
        for (key, mut reference) in [
            ("duration", MinJerk::new([3.0], 0.0)),
            ("duration", MinJerk::new([3.0], f64::NAN)),
            ("start", MinJerk::new([3.0], 1.0).after(-1.0)),
            ("to", MinJerk::new([3.0, 1.0], 1.0)),
            ("from", MinJerk::new([3.0], 1.0).starting_at([])),
        ] {
            let start = Start {
                space: Space::Vector(1),
                time: 0.0,
                from: &from,
            };
            let error = reference.bind(&start).unwrap_err().to_string();
            assert!(error.starts_with(&format!("`{key}`")), "{error}");
        }
    }
}
