//! Several smooth moves, one after another.

use wbqp::{
    error::BindError,
    plugin::{Reference, Sample, Start, Tick},
    schemars::JsonSchema,
    serde::{Deserialize, Serialize},
};

use super::leg::{self, Leg};
use crate::check;

/// Visits points at given times. Between two points it moves as [`MinJerk`](crate::MinJerk) does, from rest to
/// rest; it leaves a point after its `dwell` and reaches the next at that one's `at`. The first move begins where
/// the reference takes over; after the last point it holds.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(crate = "wbqp::serde", deny_unknown_fields)]
#[schemars(crate = "wbqp::schemars")]
pub struct Waypoints {
    /// The points, in the order of their times.
    pub points: Vec<Waypoint>,
    #[serde(skip)]
    legs: Vec<Leg>,
}

/// A point of [`Waypoints`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(crate = "wbqp::serde", deny_unknown_fields)]
#[schemars(crate = "wbqp::schemars")]
pub struct Waypoint {
    /// When it is reached, s, counted from where the reference takes over. The first may be 0: a jump.
    #[schemars(extend("x-unit" = "s"))]
    pub at: f64,
    /// The value, in the task's unit (m, rad or N); `[roll, pitch, yaw]` in rad for a rotation.
    #[schemars(extend("x-unit" = "the task's"))]
    pub value: Vec<f64>,
    /// How long it stays, s.
    #[serde(default)]
    #[schemars(extend("x-unit" = "s"))]
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
            legs: Vec::new(),
        }
    }

    /// Writes the sample at a time (s, on the clock it was bound with). Nothing before it is bound.
    pub fn at(&self, time: f64, out: &mut Sample) {
        let begun = self.legs.partition_point(|leg| leg.begin <= time);
        if let Some(leg) = self.legs.get(begun.saturating_sub(1)) {
            leg.at(time, out);
        }
    }
}

#[wbqp::reference("waypoints")]
impl Reference for Waypoints {
    fn bind(&mut self, start: &Start<'_>) -> Result<(), BindError> {
        if self.points.is_empty() {
            return Err(BindError::length("points", 0, "at least one"));
        }
        // A second bind, in the first tick, finds its room here.
        self.legs.resize_with(self.points.len(), Leg::unbound);
        // When the point before is left.
        let mut free = 0.0;
        for (i, point) in self.points.iter().enumerate() {
            let key = |name: &str| format!("points[{i}].{name}");
            for (name, seconds) in [("at", point.at), ("dwell", point.dwell)] {
                // Keys are text, and text is made only for an error.
                if !(seconds.is_finite() && seconds >= 0.0) {
                    check::not_negative(&key(name), seconds)?;
                }
            }
            if i > 0 && point.at <= free {
                let problem = format!(
                    "is {}, must be later than {free}, when the point before is left",
                    point.at
                );
                return Err(BindError::value(&key("at"), problem));
            }
            let (before, rest) = self.legs.split_at_mut(i);
            let Some(leg) = rest.first_mut() else {
                break;
            };
            leg.space = start.space;
            leg.begin = start.time + free;
            leg.duration = point.at - free;
            match before.last() {
                Some(before) => {
                    leg.from.reset(start.space);
                    leg::stand(&before.to, &mut leg.from);
                }
                None => leg::take_over(start, &mut leg.from)?,
            }
            leg::read_knot(start.space, &|| key("value"), &point.value, &mut leg.to)?;
            free = point.at + point.dwell;
        }
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

    fn bound(space: Space, from: &Sample, points: Vec<Waypoint>) -> Result<Waypoints, BindError> {
        let mut reference = Waypoints::new(points);
        reference.bind(&Start {
            space,
            time: 100.0,
            from,
        })?;
        Ok(reference)
    }

    fn at(reference: &Waypoints, space: Space, time: f64) -> Sample {
        let mut out = Sample::new(space);
        reference.at(time, &mut out);
        out
    }

    #[test]
    fn reaches_every_point_in_time_dwells_and_holds() {
        let space = Space::Vector(2);
        let points = vec![
            Waypoint::new(1.0, [1.0, 0.0]).dwell(0.5),
            Waypoint::new(3.0, [1.0, 2.0]),
            Waypoint::new(4.0, [0.0, 0.0]),
        ];
        let reference = bound(space, &Sample::at_rest([0.0, 0.0]), points).unwrap();
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
            let got = at(&reference, space, time);
            assert!(
                (got.value3() - Sample::at_rest(value).value3()).norm() < 1e-12,
                "{time}"
            );
        }
        assert_eq!(at(&reference, space, 101.2), Sample::at_rest([1.0, 0.0]));
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
        let space = Space::Rotation;
        let turning = bound(space, &Sample::new(space), points()).unwrap();
        let flat = Space::Vector(3);
        let moving = bound(flat, &Sample::at_rest([0.0; 3]), points()).unwrap();
        for k in 0..450 {
            let time = 99.9 + 0.01 * f64::from(k);
            let here = at(&turning, space, time);
            let (a, b) = (at(&turning, space, time - h), at(&turning, space, time + h));
            let w = wbqp::spatial::log(&(b.rotation * a.rotation.inverse())) / (2.0 * h);
            assert!((here.rate3() - w).norm() < 1e-5, "{time}");
            let dw = (b.rate3() - a.rate3()) / (2.0 * h);
            // One-sided jerk at the ends of a leg.
            assert!((here.acceleration3() - dw).norm() < 2e-2, "{time}");
            let here = at(&moving, flat, time);
            let (a, b) = (at(&moving, flat, time - h), at(&moving, flat, time + h));
            assert!((here.rate3() - (b.value3() - a.value3()) / (2.0 * h)).norm() < 1e-5);
        }
    }

    #[test]
    fn a_first_point_at_zero_is_a_jump() {
        let space = Space::Vector(1);
        let reference = bound(
            space,
            &Sample::at_rest([9.0]),
            vec![Waypoint::new(0.0, [1.0])],
        )
        .unwrap();
        assert_eq!(at(&reference, space, 100.0), Sample::at_rest([1.0]));
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
            let error = bound(Space::Vector(1), &from, points)
                .unwrap_err()
                .to_string();
            assert!(error.starts_with(&format!("`{key}`")), "{error}");
        }
    }
}
