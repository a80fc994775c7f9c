//! The feedback loop of the normal force.

use wbqp::plugin::Remembered;

/// Gains of the loop.
#[derive(Clone, Copy, Debug)]
pub(super) struct Settings {
    /// N/N.
    pub(super) kp: f64,
    /// 1/s.
    pub(super) ki: f64,
    /// 1/s.
    pub(super) anti_windup: f64,
    /// N.
    pub(super) clamp: f64,
}

/// `f* = f^d − K_P (f^m − f^d) − ξ`, `ξ̇ = K_I (f^m − f^d) + k_aw (f* − f_QP)`, `|ξ| ≤ clamp`.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Loop {
    /// ξ, N.
    xi: f64,
    /// `f*` of the last step, N; the solution that this step sees is the answer to it.
    asked: Option<f64>,
    clamped: bool,
}

impl Loop {
    /// One period: set point, measured force and last solution to virtual input, N.
    pub(super) fn step(
        &mut self,
        settings: &Settings,
        period: f64,
        set_point: f64,
        measured: f64,
        solution: f64,
    ) -> f64 {
        let error = measured - set_point;
        let shortfall = self.asked.map_or(0.0, |asked| asked - solution);
        // A tick that stands for several periods takes no more back than was too much.
        let anti_windup = settings.anti_windup.min(1.0 / period);
        let next = self.xi + period * (settings.ki * error + anti_windup * shortfall);
        if next.is_finite() {
            self.clamped = next.abs() >= settings.clamp;
            self.xi = next.min(settings.clamp).max(-settings.clamp);
        }
        let input = set_point - settings.kp * error - self.xi;
        self.asked = Some(input);
        input
    }

    /// Shows what is remembered from tick to tick.
    pub(super) fn remembered(&mut self, numbers: &mut Remembered<'_>) {
        numbers.number(&mut self.xi);
        numbers.maybe(&mut self.asked);
        numbers.flag(&mut self.clamped);
    }

    /// Whether ξ stands at its clamp.
    pub(super) fn clamped(&self) -> bool {
        self.clamped
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: f64 = 0.004;

    fn settings() -> Settings {
        Settings {
            kp: 0.2,
            ki: 1.5,
            anti_windup: 0.5,
            clamp: 2.0,
        }
    }

    /// Runs the loop against a plant `f_QP = solve(f*)`, `f^m = sense(f_QP)`, one period later each; gives the loop and
    /// the last `(f*, f^m)`.
    fn run(
        settings: &Settings,
        set_point: f64,
        seconds: f64,
        solve: impl Fn(f64) -> f64,
        sense: impl Fn(f64) -> f64,
    ) -> (Loop, f64, f64) {
        let mut feedback = Loop::default();
        let (mut solution, mut input) = (0.0, 0.0);
        for _ in 0..(seconds / PERIOD) as usize {
            input = feedback.step(settings, PERIOD, set_point, sense(solution), solution);
            solution = solve(input);
        }
        (feedback, input, sense(solution))
    }

    #[test]
    fn converges_against_an_ideal_contact() {
        let (feedback, input, measured) = run(&settings(), 5.0, 20.0, |f| f, |f| f);
        assert!((measured - 5.0).abs() < 1e-6);
        assert!((input - 5.0).abs() < 1e-6);
        assert!(!feedback.clamped());
    }

    #[test]
    fn a_force_that_is_lost_on_the_way_is_asked_for_in_addition() {
        let (feedback, input, measured) = run(&settings(), 5.0, 20.0, |f| f, |f| f - 1.0);
        assert!((measured - 5.0).abs() < 1e-6);
        assert!((input - 6.0).abs() < 1e-6);
        assert!(!feedback.clamped());
    }

    #[test]
    fn the_proportional_gain_must_stay_below_one() {
        let proportional = |kp| Settings {
            kp,
            ki: 0.0,
            ..settings()
        };
        let sense = |f: f64| f - 1.0;
        let (_, _, measured) = run(&proportional(0.9), 5.0, 4.0, |f| f, sense);
        assert!((measured - (5.0 - 1.0 / 1.9)).abs() < 1e-6);
        let (_, input, _) = run(&proportional(1.1), 5.0, 4.0, |f| f, sense);
        assert!(input.abs() > 1e3, "must diverge: {input}");
    }

    #[test]
    fn back_calculation_brings_the_request_down_to_what_is_given() {
        let limit = |f: f64| f.min(4.0);
        let wide = Settings {
            clamp: 1e3,
            ..settings()
        };
        let open = Settings {
            anti_windup: 0.0,
            ..wide
        };
        let (feedback, with, _) = run(&wide, 5.0, 30.0, limit, |f| f);
        let (_, without, _) = run(&open, 5.0, 30.0, limit, |f| f);
        // Balance: K_I (4 − 5) + k_aw (f* − 4) = 0.
        assert!((with - 7.0).abs() < 1e-3, "{with}");
        assert!(without > 40.0, "{without}");
        assert!(!feedback.clamped());
        // A plant that gives less than asked, with no error to integrate: the request comes down.
        let mut feedback = Loop::default();
        let first = feedback.step(&settings(), PERIOD, 5.0, 5.0, 5.0);
        let second = feedback.step(&settings(), PERIOD, 5.0, 5.0, 3.0);
        assert_eq!(first, 5.0);
        assert!(second < first);
    }

    #[test]
    fn the_clamp_bounds_the_correction_and_is_reported() {
        let (feedback, input, measured) = run(&settings(), 5.0, 30.0, |f| f, |f| f - 4.0);
        assert!(feedback.clamped());
        assert!((input - (5.0 - 0.2 * (measured - 5.0) + 2.0)).abs() < 1e-9);
        assert!(measured < 4.0);
    }

    #[test]
    fn recovers_from_a_limit_without_a_long_overshoot() {
        let mut feedback = Loop::default();
        let (mut solution, mut peak, mut over) = (0.0, 0.0_f64, 0);
        for k in 0..5000 {
            let input = feedback.step(&settings(), PERIOD, 5.0, solution, solution);
            solution = if k < 2500 { input.min(4.0) } else { input };
            if k >= 2500 {
                peak = peak.max(solution);
                over += usize::from(solution > 5.1);
            }
        }
        assert!(peak <= 7.01, "{peak}");
        assert!(over as f64 * PERIOD < 3.0);
        assert!((solution - 5.0).abs() < 1e-2);
    }

    #[test]
    fn survives_a_measurement_that_is_not_a_number() {
        let mut feedback = Loop::default();
        feedback.step(&settings(), PERIOD, 5.0, 4.0, 4.0);
        feedback.step(&settings(), PERIOD, 5.0, f64::NAN, 4.0);
        // The request of that step is lost, the integrator is not.
        assert!(feedback.xi.is_finite());
    }

    #[test]
    fn without_gains_it_passes_the_set_point_through() {
        let off = Settings {
            kp: 0.0,
            ki: 0.0,
            anti_windup: 0.0,
            clamp: 2.0,
        };
        let (_, input, _) = run(&off, 5.0, 1.0, |f| f.min(3.0), |f| f - 1.0);
        assert_eq!(input, 5.0);
    }
}
