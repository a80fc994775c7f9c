//! One smooth move from rest to rest, the piece that trajectories are made of.
//!
//! # Mathematics
//! With `τ = t/T` the position goes as `s = 10τ³ − 15τ⁴ + 6τ⁵`, which of all moves from rest to rest (speed and
//! acceleration zero at both ends) has the least `∫ jerk² dt` (T. Flash and N. Hogan, *The coordination of arm
//! movements*, 1985). In a vector space the value is `a + s (b − a)`. A rotation turns about the one axis
//! `φ = log(R_b R_aᵀ)`, which is constant in world axes: `R = exp(s φ) R_a`, `w = ṡ φ`, `ẇ = s̈ φ`.

use wbqp::{nalgebra::UnitQuaternion, plugin::RotationSample, prelude::*, spatial};

use crate::check;

/// A move.
#[derive(Clone, Debug)]
pub struct Leg {
    /// Time at which it begins, s.
    pub(crate) begin: f64,
    /// How long it takes, s; zero is a jump.
    pub(crate) duration: f64,
    pub(crate) from: Sample,
    pub(crate) to: Sample,
}

impl Leg {
    /// Writes the sample at a time, s; before and after the move it stands at its ends.
    pub(crate) fn at(&self, time: f64, out: &mut Sample) {
        let elapsed = time - self.begin;
        if elapsed >= self.duration {
            return out.stand_at(&self.to);
        }
        if elapsed <= 0.0 || elapsed.is_nan() {
            return out.stand_at(&self.from);
        }
        let [s, ds, dds] = min_jerk(elapsed / self.duration);
        let (ds, dds) = (ds / self.duration, dds / (self.duration * self.duration));
        match (&self.from, &self.to, out) {
            (Sample::Vector(from), Sample::Vector(to), Sample::Vector(out)) => {
                let ends = from.value.iter().zip(&to.value);
                for (((a, b), value), (rate, acceleration)) in ends
                    .zip(&mut out.value)
                    .zip(out.rate.iter_mut().zip(&mut out.acceleration))
                {
                    *value = a + s * (b - a);
                    *rate = ds * (b - a);
                    *acceleration = dds * (b - a);
                }
            }
            (Sample::Rotation(from), Sample::Rotation(to), Sample::Rotation(out)) => {
                let turn = spatial::log(&(to.rotation * from.rotation.inverse()));
                *out = RotationSample {
                    rotation: spatial::exp(&(turn * s)) * from.rotation,
                    rate: turn * ds,
                    acceleration: turn * dds,
                };
            }
            _ => {}
        }
    }
}

/// `s(τ)` with its first and second derivative.
pub(crate) fn min_jerk(tau: f64) -> [f64; 3] {
    let t2 = tau * tau;
    [
        t2 * tau * (10.0 + tau * (-15.0 + 6.0 * tau)),
        30.0 * t2 * (1.0 + tau * (-2.0 + tau)),
        60.0 * tau * (1.0 + tau * (-3.0 + 2.0 * tau)),
    ]
}

/// Reads a configured value: as many numbers as the space has dimensions, all finite.
pub(crate) fn read_knot(
    space: Space,
    key: &dyn Fn() -> String,
    numbers: &[f64],
) -> Result<Sample, BindError> {
    let (n, expected) = match space {
        Space::Vector(n) => (n, n.to_string()),
        Space::Rotation => (3, "3: roll, pitch and yaw in rad".to_owned()),
    };
    if numbers.len() != n {
        return Err(BindError::length(&key(), numbers.len(), expected));
    }
    if !numbers.iter().all(|x| x.is_finite()) {
        check::finite(&key(), numbers)?;
    }
    Ok(match space {
        Space::Vector(_) => Sample::at_rest(numbers.iter().copied()),
        Space::Rotation => {
            let [roll, pitch, yaw]: [f64; 3] = Vector3::from_column_slice(numbers).into();
            Sample::turned(UnitQuaternion::from_euler_angles(roll, pitch, yaw))
        }
    })
}

/// The value that the parameters give under a key; without one, room for where the reference takes over.
pub(crate) fn knot_or_room(
    space: Space,
    key: &str,
    numbers: Option<&[f64]>,
) -> Result<Sample, BindError> {
    match numbers {
        Some(numbers) => read_knot(space, &|| key.to_owned(), numbers),
        None => Ok(Sample::new(space)),
    }
}

/// For tests of references.
#[cfg(test)]
pub(crate) mod testing {
    use super::*;
    use wbqp::plugin::VectorSample;

    /// A reference that took over at a time, s.
    pub(crate) fn started<R: Reference>(
        reference: &R,
        time: f64,
        from: &Sample,
    ) -> Result<R::Running, BindError> {
        let mut running = reference.bind(from.space())?;
        reference.start(&mut running, time, from);
        Ok(running)
    }

    pub(crate) fn vector(sample: Sample) -> VectorSample {
        match sample {
            Sample::Vector(sample) => sample,
            Sample::Rotation(_) => panic!("a rotation"),
        }
    }

    pub(crate) fn rotation(sample: &Sample) -> RotationSample {
        match sample {
            Sample::Rotation(sample) => *sample,
            Sample::Vector(_) => panic!("a vector"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{
        testing::{rotation, vector},
        *,
    };

    fn knot(space: Space, key: &str, numbers: &[f64]) -> Result<Sample, BindError> {
        read_knot(space, &|| key.to_owned(), numbers)
    }

    fn leg(space: Space, from: &[f64], to: &[f64]) -> Leg {
        Leg {
            begin: 0.7,
            duration: 1.6,
            from: knot(space, "from", from).unwrap(),
            to: knot(space, "to", to).unwrap(),
        }
    }

    fn at(leg: &Leg, time: f64) -> Sample {
        let mut out = leg.from.clone();
        leg.at(time, &mut out);
        out
    }

    #[test]
    fn vector_derivatives_agree_with_finite_differences() {
        let leg = leg(Space::Vector(2), &[1.0, -0.3], &[-0.5, 4.0]);
        let h = 1e-5;
        for time in [0.75, 0.9, 1.2, 1.5, 1.9, 2.29] {
            let [before, here, after] = [time - h, time, time + h].map(|t| vector(at(&leg, t)));
            for k in 0..2 {
                let rate = (after.value[k] - before.value[k]) / (2.0 * h);
                let acceleration = (after.rate[k] - before.rate[k]) / (2.0 * h);
                assert!((here.rate[k] - rate).abs() < 1e-7, "{time}");
                assert!((here.acceleration[k] - acceleration).abs() < 1e-6, "{time}");
            }
        }
    }

    #[test]
    fn rotation_derivatives_agree_with_finite_differences_in_world_axes() {
        let leg = leg(Space::Rotation, &[0.4, -0.7, 2.0], &[-0.9, 0.5, -2.5]);
        let h = 1e-5;
        for time in [0.75, 0.9, 1.2, 1.5, 1.9, 2.29] {
            let [before, here, after] = [time - h, time, time + h].map(|t| rotation(&at(&leg, t)));
            // Ṙ = S(w) R: the increment stands on the left.
            let w = spatial::log(&(after.rotation * before.rotation.inverse())) / (2.0 * h);
            let dw = (after.rate - before.rate) / (2.0 * h);
            assert!((here.rate - w).norm() < 1e-7, "{time}");
            assert!((here.acceleration - dw).norm() < 1e-6, "{time}");
        }
    }

    #[test]
    fn begins_and_ends_at_rest_exactly_at_its_ends() {
        let leg = leg(Space::Vector(2), &[0.1, -0.3], &[0.7, 4.1]);
        for time in [f64::NEG_INFINITY, 0.0, 0.7] {
            assert_eq!(at(&leg, time), leg.from);
        }
        for time in [2.3 + 1e-9, 2.31, 1e9] {
            assert_eq!(at(&leg, time), leg.to);
        }
        assert_eq!(at(&leg, f64::NAN), leg.from);
        let eps = 1e-6;
        for time in [0.7 + eps, 2.3 - eps] {
            let sample = vector(at(&leg, time));
            assert!(sample.rate3().norm() < 1e-9);
            assert!(sample.acceleration3().norm() < 1e-3);
        }
    }

    #[test]
    fn passes_the_middle_at_half_time_with_the_peak_speed() {
        let leg = leg(Space::Vector(1), &[2.0], &[6.0]);
        let middle = vector(at(&leg, 0.7 + 0.8));
        assert!((middle.value[0] - 4.0).abs() < 1e-12);
        assert!((middle.rate[0] - 1.875 * 4.0 / 1.6).abs() < 1e-12);
        assert!(middle.acceleration[0].abs() < 1e-12);
    }

    #[test]
    fn a_rotation_turns_about_one_axis_and_takes_the_short_way() {
        let leg = leg(Space::Rotation, &[0.0, 0.0, 3.0], &[0.0, 0.0, -3.0]);
        let middle = rotation(&at(&leg, 1.5));
        // From 3 to −3 rad the short way is up, through π.
        assert!((middle.rotation.angle() - std::f64::consts::PI).abs() < 1e-9);
        assert!(middle.rate.z > 0.0);
        assert!(middle.rate.xy().norm() < 1e-12);
    }

    #[test]
    fn roll_pitch_yaw_turn_about_world_x_then_y_then_z() {
        let rotation = rotation(&knot(Space::Rotation, "to", &[0.3, -0.5, 1.1]).unwrap()).rotation;
        let turn = |axis: Vector3<f64>, angle: f64| spatial::exp(&(axis * angle));
        let expected = turn(Vector3::z(), 1.1) * turn(Vector3::y(), -0.5) * turn(Vector3::x(), 0.3);
        assert!(rotation.angle_to(&expected) < 1e-12);
    }

    #[test]
    fn bad_values_are_refused_by_key() {
        for (space, numbers, key) in [
            (Space::Vector(2), vec![1.0], "to"),
            (Space::Vector(2), vec![1.0, f64::NAN], "to[1]"),
            (Space::Rotation, vec![0.0; 4], "to"),
        ] {
            let error = knot(space, "to", &numbers).unwrap_err().to_string();
            assert!(error.starts_with(&format!("`{key}`")), "{error}");
        }
    }
}
