//! Several smooth moves, one after another.

use wbqp::prelude::*;

use super::leg::{self, Leg};
use crate::check;

/// Visits points at given times. Between two points it moves as [`MinJerk`](crate::MinJerk) does, from rest to
/// rest; it leaves a point after its `dwell` and reaches the next at that one's `at`. The first move begins where
/// the reference takes over; after the last point it holds.
#[wbqp::reference("waypoints")]
pub struct Waypoints {
    /// The points, in the order of their times.
    pub points: Vec<Waypoint>,
}

/// A point of [`Waypoints`].
#[wbqp::parameters]
#[derive(PartialEq)]
pub struct Waypoint {
    /// When it is reached, s, counted from where the reference takes over. The first may be 0: a jump.
    #[wbqp(unit = "s")]
    pub at: f64,
    /// The value, in the task's unit (m, rad or N); `[roll, pitch, yaw]` in rad for a rotation.
    #[wbqp(unit = "the task's")]
    pub value: Vec<f64>,
    /// How long it stays, s.
    #[wbqp(default, unit = "s")]
    pub dwell: f64,
}

impl Waypoint {
    /// Reached at a time in s, left at once.
    pub fn new(at: f64, value: impl Into<Vec<f64>>) -> Self {
        Self {
            at,
            value: value.into(),
            dwell: 0.0,
        }
    }

    /// Stays for a duration in s.
    pub fn dwell(mut self, duration: f64) -> Self {
        self.dwell = duration;
        self
    }
}

impl Waypoints {
    /// Visits the points in this order.
    pub fn new(points: impl Into<Vec<Waypoint>>) -> Self {
        Self {
            points: points.into(),
        }
    }
}

/// The moves from point to point.
#[derive(Debug)]
pub struct Legs(Vec<Leg>);

impl Legs {
    fn at(&self, time: f64, out: &mut Sample) {
        let begun = self.0.partition_point(|leg| leg.begin <= time);
        if let Some(leg) = self.0.get(begun.saturating_sub(1)) {
            leg.at(time, out);
        }
    }
}

impl Reference for Waypoints {
    type Running = Legs;

    fn bind(&self, space: Space) -> Result<Legs, BindError> {
        if self.points.is_empty() {
            return Err(BindError::length("points", 0, "at least one"));
        }
        let mut legs: Vec<Leg> = Vec::with_capacity(self.points.len());
        // When the point before is left.
        let mut free = 0.0;
        for (i, point) in self.points.iter().enumerate() {
            let key = |name: &str| format!("points[{i}].{name}");
            for (name, seconds) in [("at", point.at), ("dwell", point.dwell)] {
                check::not_negative(&key(name), seconds)?;
            }
            if i > 0 && point.at <= free {
                let problem = format!(
                    "is {}, must be later than {free}, when the point before is left",
                    point.at
                );
                return Err(BindError::value(&key("at"), problem));
            }
            legs.push(Leg {
                begin: free,
                duration: point.at - free,
                from: legs
                    .last()
                    .map_or_else(|| Sample::new(space), |before| before.to.clone()),
                to: leg::read_knot(space, &|| key("value"), &point.value)?,
            });
            free = point.at + point.dwell;
        }
        Ok(Legs(legs))
    }

    fn start(&self, legs: &mut Legs, time: f64, from: &Sample) {
        let mut free = 0.0;
        for (leg, point) in legs.0.iter_mut().zip(&self.points) {
            leg.begin = time + free;
            free = point.at + point.dwell;
        }
        if let Some(first) = legs.0.first_mut() {
            first.from.stand_at(from);
        }
    }

    fn sample(&self, legs: &mut Legs, tick: &Tick<'_>, out: &mut Sample) {
        legs.at(tick.time, out);
    }

    fn values(&self) -> Vec<(String, &[f64])> {
        let points = self.points.iter().enumerate();
        let named = points.map(|(i, point)| (format!("points[{i}].value"), &point.value[..]));
        named.collect()
    }
}

#[cfg(test)]
mod tests {
    use wbqp::plugin::VectorSample;

    use super::*;
    use crate::references::leg::testing::{rotation, started, vector};

    fn bound(from: &Sample, points: Vec<Waypoint>) -> Result<Legs, BindError> {
        started(&Waypoints::new(points), 100.0, from)
    }

    fn at(legs: &Legs, time: f64) -> Sample {
        let mut out = legs.0[0].from.clone();
        legs.at(time, &mut out);
        out
    }

    fn rest<const N: usize>(value: [f64; N]) -> VectorSample {
        VectorSample::at_rest(value)
    }

    #[test]
    fn reaches_every_point_in_time_dwells_and_holds() {
        let points = vec![
            Waypoint::new(1.0, [1.0, 0.0]).dwell(0.5),
            Waypoint::new(3.0, [1.0, 2.0]),
            Waypoint::new(4.0, [0.0, 0.0]),
        ];
        let legs = bound(&Sample::at_rest([0.0, 0.0]), points).unwrap();
        for (time, value) in [
            (99.0, [0.0, 0.0]),
            (100.0, [0.0, 0.0]),
            (100.5, [0.5, 0.0]),
            (101.0, [1.0, 0.0]),
            (101.5, [1.0, 0.0]),
            (102.25, [1.0, 1.0]),
            (103.0, [1.0, 2.0]),
            (103.5, [0.5, 1.0]),
            (104.0, [0.0, 0.0]),
            (200.0, [0.0, 0.0]),
        ] {
            let got = vector(at(&legs, time));
            assert!(
                (got.value3() - rest(value).value3()).norm() < 1e-12,
                "{time}"
            );
        }
        assert_eq!(vector(at(&legs, 101.2)), rest([1.0, 0.0]));
    }

    #[test]
    fn is_twice_differentiable_along_the_whole_way() {
        let points = || {
            vec![
                Waypoint::new(1.0, [0.3, 0.2, 0.5]),
                Waypoint::new(2.5, [-0.2, 0.9, 1.5]).dwell(0.2),
                Waypoint::new(4.0, [0.0, 0.0, -1.0]),
            ]
        };
        let h = 1e-4;
        let turning = bound(&Sample::new(Space::Rotation), points()).unwrap();
        let moving = bound(&Sample::at_rest([0.0; 3]), points()).unwrap();
        for k in 0..450 {
            let time = 99.9 + 0.01 * f64::from(k);
            let turning = |time| rotation(&at(&turning, time));
            let (here, a, b) = (turning(time), turning(time - h), turning(time + h));
            let w = wbqp::spatial::log(&(b.rotation * a.rotation.inverse())) / (2.0 * h);
            assert!((here.rate - w).norm() < 1e-5, "{time}");
            let dw = (b.rate - a.rate) / (2.0 * h);
            // One-sided jerk at the ends of a leg.
            assert!((here.acceleration - dw).norm() < 2e-2, "{time}");
            let moving = |time| vector(at(&moving, time));
            let (here, a, b) = (moving(time), moving(time - h), moving(time + h));
            assert!((here.rate3() - (b.value3() - a.value3()) / (2.0 * h)).norm() < 1e-5);
        }
    }

    #[test]
    fn a_first_point_at_zero_is_a_jump() {
        let points = vec![Waypoint::new(0.0, [1.0])];
        let legs = bound(&Sample::at_rest([9.0]), points).unwrap();
        assert_eq!(vector(at(&legs, 100.0)), rest([1.0]));
    }

    #[test]
    fn bad_points_are_refused_by_key() {
        let from = Sample::at_rest([0.0]);
        for (key, points) in [
            ("points", vec![]),
            ("points[0].at", vec![Waypoint::new(-1.0, [0.0])]),
            ("points[0].at", vec![Waypoint::new(f64::NAN, [0.0])]),
            (
                "points[1].at",
                vec![Waypoint::new(1.0, [0.0]), Waypoint::new(1.0, [1.0])],
            ),
            (
                "points[1].at",
                vec![
                    Waypoint::new(1.0, [0.0]).dwell(2.0),
                    Waypoint::new(2.0, [1.0]),
                ],
            ),
            (
                "points[0].dwell",
                vec![Waypoint::new(1.0, [0.0]).dwell(-1.0)],
            ),
            ("points[0].value", vec![Waypoint::new(1.0, [0.0, 0.0])]),
        ] {
            let error = bound(&from, points).unwrap_err().to_string();
            assert!(error.starts_with(&format!("`{key}`")), "{error}");
        }
    }
}
