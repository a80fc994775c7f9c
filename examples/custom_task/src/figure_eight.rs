//! A figure of eight in the horizontal plane.

use std::f64::consts::TAU;

use wbqp::prelude::*;

/// Flies `(a sin 2φ, b sin φ, 0)` about the point where it takes over; φ runs through one turn per period.
#[wbqp::reference("pointing.figure_eight")]
pub struct FigureEight {
    /// a and b, m.
    pub size: [f64; 2],
    /// Time of one turn, s.
    pub period: f64,
}

/// When it begins, s, and about which point.
#[derive(Debug, Default)]
pub struct Begin {
    time: f64,
    centre: Vector3<f64>,
}

impl Reference for FigureEight {
    type Running = Begin;

    fn bind(&self, space: Space) -> Result<Begin, BindError> {
        if space != Space::Vector(3) {
            return Err(BindError::value(
                "type",
                "`pointing.figure_eight` is for positions in space",
            ));
        }
        if !(self.period.is_finite() && self.period > 0.0) {
            let problem = format!("is {}, must be above 0", self.period);
            return Err(BindError::value("period", problem));
        }
        Ok(Begin::default())
    }

    fn start(&self, begin: &mut Begin, time: f64, from: &Sample) {
        if let Sample::Vector(from) = from {
            begin.time = time;
            begin.centre = from.value3();
        }
    }

    fn sample(&self, begin: &mut Begin, tick: &Tick<'_>, out: &mut Sample) {
        // It is one of vectors: `bind` refuses rotations.
        let Sample::Vector(out) = out else { return };
        let w = TAU / self.period;
        // One second to come up to speed: φ and its derivatives start at zero.
        let (phase, rate, acceleration) = ease_in(tick.time - begin.time);
        let [a, b] = self.size;
        for (axis, (size, turns)) in [(a, 2.0), (b, 1.0), (0.0, 1.0)].into_iter().enumerate() {
            let k = turns * w;
            let (sin, cos) = (k * phase).sin_cos();
            out.value[axis] = begin.centre[axis] + size * sin;
            out.rate[axis] = size * k * cos * rate;
            out.acceleration[axis] = size * k * (cos * acceleration - k * sin * rate * rate);
        }
    }
}

/// Time that starts slowly: `t³ − t⁴/2` in the first second, then `t − 1/2`, with its first two derivatives.
fn ease_in(t: f64) -> (f64, f64, f64) {
    if t >= 1.0 {
        (t - 0.5, 1.0, 0.0)
    } else {
        let t = t.max(0.0);
        (
            t.powi(3) - 0.5 * t.powi(4),
            3.0 * t * t - 2.0 * t.powi(3),
            6.0 * t * (1.0 - t),
        )
    }
}
