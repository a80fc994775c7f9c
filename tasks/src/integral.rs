//! The optional integral of a motion task.
//!
//! # Mathematics
//! Per axis, with `a*` what the task asked for in the last tick and `a_QP` what the solver gave,
//! ```text
//! a* = … − ξ,   ξ̇ = K_I e + k_aw (a* − a_QP),   |ξ| ≤ limit.
//! ```
//! The second term is back-calculation against wind-up (K. J. Åström and T. Hägglund, *PID Controllers*, 1995): where
//! limits or stronger tasks give less than asked for, ξ stops growing. `a_QP` is what the controller's own model
//! predicts, so that an error of the model, which the integral is there for, leaves `a* − a_QP` alone.
//!
//! At rest against something stronger, `a* = −K_P e − ξ` and `a_QP = 0`, hence `ξ → (K_I/k_aw − K_P) e`. With
//! `k_aw = K_I/K_P`, the default, that is zero: a conflict of tasks is settled by the weights and by `K_P` as if there
//! were no integral.

use wbqp::{
    error::BindError,
    plugin::{PerRow, Remembered},
};

use crate::check;

/// Integrals of several axes. The gain is inside, so that changing it makes no jump.
#[derive(Clone, Debug, Default)]
pub(crate) struct Integral(Vec<Axis>);

#[derive(Clone, Copy, Debug, Default)]
struct Axis {
    /// ξ, in the unit of the task's acceleration.
    term: f64,
    /// `a*` of the last tick.
    asked: Option<f64>,
}

/// The numbers of an axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Law {
    /// 1/s³.
    ki: f64,
    /// 1/s.
    anti_windup: f64,
    /// Largest magnitude of ξ.
    limit: f64,
}

/// What a task's configuration says of its integral.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Settings<'a> {
    pub(crate) kp: &'a PerRow,
    pub(crate) ki: &'a PerRow,
    pub(crate) anti_windup: Option<&'a PerRow>,
    pub(crate) limit: f64,
}

impl Settings<'_> {
    /// Checks everything but `kp`, which is not the integral's.
    pub(crate) fn validate(&self, axes: usize, period: f64) -> Result<(), BindError> {
        self.ki.validate("ki", axes)?;
        if let Some(anti_windup) = self.anti_windup {
            anti_windup.validate("anti_windup", axes)?;
        }
        check::positive("integral_limit", self.limit)?;
        let gains = (0..axes).map(|axis| self.law(axis).anti_windup);
        match gains.reduce(f64::max) {
            // The loop through the solver takes a period: beyond this it would oscillate.
            Some(gain) if gain * period >= 1.0 => {
                let problem = format!(
                    "is {gain} 1/s (the default is ki/kp), must be below the rate, {} Hz",
                    1.0 / period
                );
                Err(BindError::value("anti_windup", problem))
            }
            _ => Ok(()),
        }
    }

    /// The numbers of an axis.
    pub(crate) fn law(&self, axis: usize) -> Law {
        let (kp, ki) = (self.kp.row(axis), self.ki.row(axis));
        let anti_windup = match self.anti_windup {
            Some(gain) => gain.row(axis),
            None if kp > 0.0 => ki / kp,
            None => 0.0,
        };
        Law {
            ki,
            anti_windup,
            limit: self.limit,
        }
    }
}

impl Integral {
    pub(crate) fn new(axes: usize) -> Self {
        Self(vec![Axis::default(); axes])
    }

    pub(crate) fn reset(&mut self) {
        self.0.fill(Axis::default());
    }

    /// Shows what is remembered from tick to tick.
    pub(crate) fn remembered(&mut self, numbers: &mut Remembered<'_>) {
        for Axis { term, asked } in &mut self.0 {
            numbers.number(term);
            numbers.maybe(asked);
        }
    }

    /// One tick of one axis: its error and the acceleration `a_QP` that the last solution gave, in the sense of the
    /// task's row, and the seconds that the tick stands for. Gives ξ, to be subtracted from the acceleration.
    pub(crate) fn step(
        &mut self,
        axis: usize,
        law: Law,
        error: f64,
        given: f64,
        elapsed: f64,
    ) -> f64 {
        let Some(Axis { term, asked }) = self.0.get_mut(axis) else {
            return 0.0;
        };
        // Without gain there is no integral, and nothing to wind up.
        if law.ki == 0.0 {
            *term = 0.0;
            return 0.0;
        }
        let excess = asked.map_or(0.0, |asked| asked - given);
        // After a gap no more is taken back than there is to take back.
        let anti_windup = law.anti_windup.min(1.0 / elapsed);
        let next = *term + elapsed * (law.ki * error + anti_windup * excess);
        if next.is_finite() {
            // `max` and `min` rather than `clamp`, which panics if the limit was set to NaN.
            *term = next.min(law.limit).max(-law.limit);
        }
        *term
    }

    /// Takes down what the axis asks for in this tick, in the sense of the task's row.
    pub(crate) fn ask(&mut self, axis: usize, acceleration: f64) {
        if let Some(axis) = self.0.get_mut(axis) {
            axis.asked = Some(acceleration);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: f64 = 0.004;

    fn law(kp: f64, ki: f64, limit: f64) -> Law {
        let (kp, ki) = (PerRow::from(kp), PerRow::from(ki));
        Settings {
            kp: &kp,
            ki: &ki,
            anti_windup: None,
            limit,
        }
        .law(0)
    }

    #[test]
    fn integrates_stops_at_the_clamp_and_returns_at_once() {
        let mut integral = Integral::new(2);
        let mut step = |axis, error| integral.step(axis, law(1.0, 2.0, 0.5), error, 0.0, 0.1);
        assert_eq!(step(1, 1.0), 0.2);
        for _ in 0..10 {
            step(1, 1.0);
        }
        assert_eq!(step(1, 0.0), 0.5);
        assert_eq!(step(1, -0.5), 0.4);
        assert_eq!(step(0, 0.0), 0.0, "axes are separate");
        assert_eq!(step(7, 1.0), 0.0);
        assert_eq!(step(1, f64::NAN), 0.4);
        integral.reset();
        assert_eq!(integral.step(1, law(1.0, 2.0, 0.5), 0.0, 0.0, 0.1), 0.0);
    }

    /// `a* = −K_P e − K_D ė − ξ` on a point mass whose solver gives `solve(a*)` and whose model errs by `bias`.
    /// Returns the error in the end, ξ, and the largest overshoot past zero.
    fn run(ki: f64, seconds: f64, solve: impl Fn(f64, f64) -> f64, bias: f64) -> (f64, f64, f64) {
        let (kp, kd) = (9.0, 6.0);
        let law = law(kp, ki, 10.0);
        let mut integral = Integral::new(1);
        let (mut error, mut rate, mut given, mut term) = (1.0, 0.0, 0.0, 0.0);
        let mut overshoot = 0.0_f64;
        for k in 0..(seconds / PERIOD) as usize {
            term = integral.step(0, law, error, given, PERIOD);
            let asked = -kp * error - kd * rate - term;
            integral.ask(0, asked);
            given = solve(k as f64 * PERIOD, asked);
            rate += (given + bias) * PERIOD;
            error += rate * PERIOD;
            overshoot = overshoot.max(-error);
        }
        (error, term, overshoot)
    }

    #[test]
    fn removes_what_the_model_does_not_know() {
        let (error, ..) = run(0.0, 30.0, |_, a| a, -0.3);
        assert!((error + 0.3 / 9.0).abs() < 1e-6, "{error}");
        let (error, term, _) = run(4.0, 30.0, |_, a| a, -0.3);
        assert!(error.abs() < 1e-6, "{error}");
        assert!((term + 0.3).abs() < 1e-5, "{term}");
    }

    #[test]
    fn does_not_wind_up_against_a_limit() {
        // Held fast for 10 s at an error of 1, then free within a limit.
        let solve = |t: f64, a: f64| if t < 10.0 { 0.0 } else { a.clamp(-2.0, 2.0) };
        let (error, term, overshoot) = run(4.0, 40.0, solve, 0.0);
        assert!(error.abs() < 1e-3 && term.abs() < 1e-2, "{error} {term}");
        // It overshoots hardly more than a step without anything in the way.
        let (.., free) = run(4.0, 40.0, |_, a| a, 0.0);
        assert!(overshoot < free + 0.05, "{overshoot} {free}");
        // A conflict is not the integral's: what it took in before it saw the first answer goes again.
        let (_, held, _) = run(4.0, 20.0, |_, _| 0.0, 0.0);
        assert!(held.abs() < 1e-5, "{held}");
    }

    #[test]
    fn without_gain_it_is_not_there() {
        let (_, term, _) = run(0.0, 1.0, |_, _| 0.0, 0.0);
        assert_eq!(term, 0.0);
    }

    #[test]
    fn settings_are_refused_by_key() {
        let check = |ki: f64, anti_windup: Option<f64>, limit: f64| {
            let (kp, ki) = (PerRow::from(1.0), PerRow::from(ki));
            let anti_windup = anti_windup.map(PerRow::from);
            let settings = Settings {
                kp: &kp,
                ki: &ki,
                anti_windup: anti_windup.as_ref(),
                limit,
            };
            settings
                .validate(3, PERIOD)
                .map_err(|error| error.to_string())
        };
        assert_eq!(check(1.0, None, 1.0), Ok(()));
        for (key, refused) in [
            ("ki", check(-1.0, None, 1.0)),
            ("anti_windup", check(1.0, Some(-1.0), 1.0)),
            ("anti_windup", check(1.0, Some(250.0), 1.0)),
            ("anti_windup", check(300.0, None, 1.0)),
            ("integral_limit", check(1.0, None, 0.0)),
        ] {
            let error = refused.unwrap_err();
            assert!(error.starts_with(&format!("`{key}`")), "{error}");
        }
    }
}
