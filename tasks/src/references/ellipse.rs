//! Around an ellipse, from rest to rest.
//!
//! # Mathematics
//! With the eccentric angle `φ = φ₀ + 2π N s(t/T)`, `s` the minimum-jerk profile of [`leg`](super::leg), and
//! semi-axes `a`, `b` along two of the task's components,
//! ```text
//! x = x₀ + a (cos φ − cos φ₀)     ẋ = −a φ̇ sin φ     ẍ = −a (φ̈ sin φ + φ̇² cos φ)
//! y = y₀ + b (sin φ − sin φ₀)     ẏ =  b φ̇ cos φ     ÿ =  b (φ̈ cos φ − φ̇² sin φ)
//! ```
//! `φ̇ = φ̈ = 0` at both ends, hence so are rates and accelerations. The speed peaks at half time, with
//! `φ̇ = 1.875 · 2π N/T`.

use std::f64::consts::TAU;

use wbqp::{dynamics::elementary, plugin::VectorSample, prelude::*};

use super::leg;
use crate::check;

/// Goes around an ellipse once or several times, from rest to rest, beginning where it takes over (or at `from`).
/// After a whole number of turns it ends where it began. It holds before and after.
///
/// Two components of the task move: `axes[0]` by `semi_axes[0] cos φ`, `axes[1]` by `semi_axes[1] sin φ` about the
/// centre, where the angle φ goes from `phase` to `phase + 2π turns` with the profile of
/// [`MinJerk`](crate::MinJerk); the others hold. Rates and accelerations are the exact derivatives. Equal
/// semi-axes make a circle, a semi-axis of zero a line there and back.
///
/// For tasks on vectors; rotations are refused.
#[wbqp::reference("ellipse")]
pub struct Ellipse {
    /// Half the width along each of the two axes, in the task's unit; not negative, at least one above zero.
    #[wbqp(unit = "the task's")]
    pub semi_axes: [f64; 2],
    /// How long it takes, s.
    #[wbqp(unit = "s")]
    pub duration: f64,
    /// How often it goes around; a fraction ends elsewhere, a negative number turns from `axes[1]` to `axes[0]`.
    #[wbqp(default = 1.0, unit = "1")]
    pub turns: f64,
    /// The angle φ at which it begins, rad: 0 at the positive end of the first axis, π/2 at that of the second.
    #[wbqp(default, unit = "rad")]
    pub phase: f64,
    /// The two components of the task that move, counted from 0.
    #[wbqp(default = [0, 1])]
    pub axes: [usize; 2],
    /// Where it begins, one number per component of the task. Without it, what the task followed before; at the
    /// start, what is measured.
    #[wbqp(unit = "the task's")]
    pub from: Option<Vec<f64>>,
    /// Delay before it begins, s.
    #[wbqp(default, unit = "s")]
    pub start: f64,
}

/// Where and when it begins.
#[derive(Debug)]
pub struct Begin {
    /// s.
    time: f64,
    from: VectorSample,
}

impl Ellipse {
    /// Once around within a duration in s, along the first two components, from where it takes over, which is the
    /// positive end of the first axis.
    pub fn new(semi_axes: [f64; 2], duration: f64) -> Self {
        Self {
            semi_axes,
            duration,
            turns: Self::default_turns(),
            phase: 0.0,
            axes: Self::default_axes(),
            from: None,
            start: 0.0,
        }
    }

    /// Several times, or with a negative number the other way round.
    pub fn turns(mut self, turns: f64) -> Self {
        self.turns = turns;
        self
    }

    /// Begins at an angle in rad.
    pub fn starting_at_angle(mut self, phase: f64) -> Self {
        self.phase = phase;
        self
    }

    /// Along other components of the task.
    pub fn along(mut self, axes: [usize; 2]) -> Self {
        self.axes = axes;
        self
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

    /// Writes the sample at a time, s.
    fn at(&self, begin: &Begin, time: f64, out: &mut VectorSample) {
        out.stand_at(&begin.from);
        let elapsed = time - begin.time;
        // A time that is not a number counts as before.
        let progress = if elapsed > 0.0 {
            (elapsed / self.duration).min(1.0)
        } else {
            0.0
        };
        let [s, ds, dds] = leg::min_jerk(progress);
        let sweep = TAU * self.turns;
        let (sin, cos) = elementary::sin_cos(self.phase + sweep * s);
        let (sin_0, cos_0) = elementary::sin_cos(self.phase);
        let rate = sweep * ds / self.duration;
        let acceleration = sweep * dds / (self.duration * self.duration);
        // Position from the start, and its derivatives by the angle.
        let shapes = [[cos - cos_0, -sin, -cos], [sin - sin_0, cos, -sin]];
        for ((semi_axis, axis), [offset, first, second]) in
            self.semi_axes.iter().zip(self.axes).zip(shapes)
        {
            if let Some(value) = out.value.get_mut(axis) {
                *value += semi_axis * offset;
            }
            if let Some(out) = out.rate.get_mut(axis) {
                *out = semi_axis * rate * first;
            }
            if let Some(out) = out.acceleration.get_mut(axis) {
                *out = semi_axis * (acceleration * first + rate * rate * second);
            }
        }
    }
}

impl Reference for Ellipse {
    type Running = Begin;

    fn bind(&self, space: Space) -> Result<Begin, BindError> {
        let Space::Vector(n) = space else {
            return Err(BindError::Other(
                "`ellipse` is a curve of vectors, not of rotations".to_owned(),
            ));
        };
        for semi_axis in self.semi_axes {
            check::not_negative("semi_axes", semi_axis)?;
        }
        if self.semi_axes == [0.0, 0.0] {
            return Err(BindError::value("semi_axes", "are both zero"));
        }
        check::positive("duration", self.duration)?;
        check::finite_number("turns", self.turns)?;
        check::finite_number("phase", self.phase)?;
        check::not_negative("start", self.start)?;
        if let Some(axis) = self.axes.iter().find(|&&axis| axis >= n) {
            let problem = format!("contains {axis}, the task has {n} components, counted from 0");
            return Err(BindError::value("axes", problem));
        }
        if self.axes[0] == self.axes[1] {
            let problem = format!("names {} twice", self.axes[0]);
            return Err(BindError::value("axes", problem));
        }
        let from = match leg::knot_or_room(space, "from", self.from.as_deref())? {
            Sample::Vector(from) => from,
            Sample::Rotation(_) => VectorSample::at_rest([]),
        };
        Ok(Begin { time: 0.0, from })
    }

    fn start(&self, begin: &mut Begin, time: f64, from: &Sample) {
        begin.time = time + self.start;
        if let (None, Sample::Vector(from)) = (&self.from, from) {
            begin.from.stand_at(from);
        }
    }

    fn sample(&self, begin: &mut Begin, tick: &Tick<'_>, out: &mut Sample) {
        if let Sample::Vector(out) = out {
            self.at(begin, tick.time, out);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use super::*;
    use crate::references::leg::testing::started;

    const BEGIN: f64 = 10.0;

    /// An ellipse that has begun.
    struct Begun(Ellipse, Begin);

    fn bound(reference: Ellipse, from: &Sample) -> Result<Begun, BindError> {
        let begin = started(&reference, BEGIN, from)?;
        Ok(Begun(reference, begin))
    }

    fn at(Begun(reference, begin): &Begun, time: f64) -> VectorSample {
        let mut out = begin.from.clone();
        reference.at(begin, time, &mut out);
        out
    }

    #[test]
    fn derivatives_agree_with_finite_differences() {
        let reference = Ellipse::new([0.05, 0.1], 4.0)
            .turns(-1.75)
            .starting_at_angle(0.4)
            .along([2, 0]);
        let reference = bound(reference, &Sample::at_rest([0.3, -0.2, 1.0])).unwrap();
        let h = 1e-5;
        for k in 1..400 {
            let time = BEGIN + 0.01 * f64::from(k);
            let [before, here, after] = [time - h, time, time + h].map(|t| at(&reference, t));
            let rate = (after.value3() - before.value3()) / (2.0 * h);
            let acceleration = (after.rate3() - before.rate3()) / (2.0 * h);
            assert!((here.rate3() - rate).norm() < 1e-9, "{time}");
            assert!(
                (here.acceleration3() - acceleration).norm() < 1e-8,
                "{time}"
            );
            assert_eq!(here.value[1], -0.2);
        }
    }

    #[test]
    fn begins_and_ends_at_rest() {
        let value = VectorSample::at_rest([0.3, -0.2, 1.0]);
        let from = Sample::Vector(value.clone());
        let reference = Ellipse::new([0.05, 0.1], 4.0).turns(2.0).after(0.5);
        let reference = bound(reference, &from).unwrap();
        for time in [f64::NAN, f64::NEG_INFINITY, 0.0, BEGIN, BEGIN + 0.5] {
            assert_eq!(Sample::Vector(at(&reference, time)), from, "{time}");
        }
        for time in [BEGIN + 4.5, BEGIN + 5.0, f64::INFINITY] {
            let end = at(&reference, time);
            assert!((end.value3() - value.value3()).norm() < 1e-15, "{time}");
            assert_eq!((end.rate3().norm(), end.acceleration3().norm()), (0.0, 0.0));
        }
        // Continuous at both ends: rates as t², accelerations as t.
        let eps = 1e-5;
        for time in [BEGIN + 0.5 + eps, BEGIN + 4.5 - eps] {
            let sample = at(&reference, time);
            assert!(sample.rate3().norm() < 1e-9);
            assert!(sample.acceleration3().norm() < 1e-4);
        }
    }

    #[test]
    fn keeps_to_the_ellipse_and_covers_it() {
        let from = Sample::at_rest([0.0, 0.0]);
        let reference = Ellipse::new([0.05, 0.1], 4.0).starting_at_angle(PI);
        let reference = bound(reference, &from).unwrap();
        let mut reached = [0.0_f64; 2];
        for k in 0..=400 {
            let [x, y, _]: [f64; 3] = at(&reference, BEGIN + 0.01 * f64::from(k)).value3().into();
            // From φ = π on the centre is half a width ahead.
            let on = ((x - 0.05) / 0.05).powi(2) + (y / 0.1).powi(2);
            assert!((on - 1.0).abs() < 1e-12);
            reached = [reached[0].max(x), reached[1].max(y.abs())];
        }
        assert!((reached[0] - 0.1).abs() < 1e-5 && (reached[1] - 0.1).abs() < 1e-5);
    }

    #[test]
    fn turns_from_the_first_axis_to_the_second_unless_negative() {
        let from = Sample::at_rest([0.0, 0.0]);
        for turns in [1.0, -1.0] {
            let circle = Ellipse::new([1.0, 1.0], 4.0).turns(turns);
            let circle = bound(circle, &from).unwrap();
            let middle = at(&circle, BEGIN + 2.0);
            assert!((middle.value3().x + 2.0).abs() < 1e-12);
            // Half way round it moves against the second axis, at the peak of the profile.
            let speed = 1.875 * TAU / 4.0;
            assert!((middle.rate[1] + turns * speed).abs() < 1e-12);
        }
        let line = bound(
            Ellipse::new([0.0, 0.2], 1.0).starting_at_angle(FRAC_PI_2),
            &from,
        );
        let middle = at(&line.unwrap(), BEGIN + 0.5);
        assert!((middle.value[1] + 0.4).abs() < 1e-12 && middle.value[0] == 0.0);
    }

    #[test]
    fn bad_numbers_are_refused_by_key() {
        let good = || Ellipse::new([0.1, 0.1], 1.0);
        for (key, reference) in [
            ("semi_axes", Ellipse::new([0.0, 0.0], 1.0)),
            ("semi_axes", Ellipse::new([-0.1, 0.1], 1.0)),
            ("semi_axes", Ellipse::new([0.1, f64::NAN], 1.0)),
            ("duration", Ellipse::new([0.1, 0.1], 0.0)),
            ("turns", good().turns(f64::INFINITY)),
            ("phase", good().starting_at_angle(f64::NAN)),
            ("start", good().after(-1.0)),
            ("axes", good().along([0, 2])),
            ("axes", good().along([1, 1])),
            ("from", good().starting_at([1.0])),
        ] {
            let from = Sample::at_rest([0.0, 0.0]);
            let error = bound(reference, &from).err().unwrap().to_string();
            assert!(error.starts_with(&format!("`{key}`")), "{error}");
        }
        let rotation = good().bind(Space::Rotation);
        assert!(rotation.unwrap_err().to_string().contains("rotations"));
    }
}
