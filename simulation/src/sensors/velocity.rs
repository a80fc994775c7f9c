//! Velocities estimated from measured positions.
//!
//! # Mathematics
//! ```text
//! v_k = v_{k−1} + α ((x_k ⊖ x_{k−1}) / Δt − v_{k−1}),   α = 1 − exp(−2π f_c Δt)
//! ```
//! where `R ⊖ R'` is the rotation vector, in world axes, that turns `R'` into `R`. At rest before the second sample.

use std::f64::consts::TAU;

use wbqp::{spatial, state::State};

/// Differences through a first-order low-pass.
#[derive(Clone, Debug)]
pub(super) struct VelocityEstimate {
    /// Hz; none where velocities are measured.
    base: Option<f64>,
    joints: Option<f64>,
    /// s.
    time: Option<f64>,
    /// What was measured then, with the estimated velocities.
    last: State,
}

impl VelocityEstimate {
    /// `state` has the robot's sizes.
    pub(super) fn new(base: Option<f64>, joints: Option<f64>, state: &State) -> Self {
        let mut last = state.clone();
        last.v.fill(0.0);
        Self {
            base,
            joints,
            time: None,
            last,
        }
    }

    /// Replaces the velocities that are not measured, by those at a time in s.
    pub(super) fn replace(&mut self, time: f64, state: &mut State) {
        let (estimate, count) = (&mut self.last, state.q.len());
        let offset = state.v.len() - count;
        if let Some(period) = self
            .time
            .map(|last| time - last)
            .filter(|period| *period > 0.0)
        {
            let blend = |cutoff: f64| 1.0 - (-TAU * cutoff * period).exp();
            if let (Some(cutoff), 6) = (self.base, offset) {
                let moved = state.p_WR - estimate.p_WR;
                let turned = spatial::log(&(state.R_WR * estimate.R_WR.inverse()));
                for (v, step) in estimate.v.iter_mut().zip(moved.iter().chain(&turned)) {
                    *v += blend(cutoff) * (step / period - *v);
                }
            }
            if let Some(cutoff) = self.joints {
                for i in 0..count {
                    let rate = (state.q[i] - estimate.q[i]) / period;
                    let v = &mut estimate.v[offset + i];
                    *v += blend(cutoff) * (rate - *v);
                }
            }
        }
        self.time = Some(time);
        estimate.p_WR = state.p_WR;
        estimate.R_WR = state.R_WR;
        estimate.q.copy_from(&state.q);
        if self.base.is_some() {
            state
                .v
                .rows_mut(0, offset)
                .copy_from(&estimate.v.rows(0, offset));
        }
        if self.joints.is_some() {
            let own = estimate.v.rows(offset, count);
            state.v.rows_mut(offset, count).copy_from(&own);
        }
    }
}

#[cfg(test)]
mod tests {
    use wbqp::{
        model::{Base, Inertia, ModelBuilder},
        nalgebra::{Matrix3, Vector3},
        spatial,
        state::State,
    };

    use super::VelocityEstimate;

    #[test]
    fn a_steady_motion_is_found_and_what_is_measured_stays() {
        let inertia = Inertia::from_com(1.0, Vector3::zeros(), Matrix3::identity());
        let builder = ModelBuilder::new("ball", Base::Floating, "ball", inertia);
        let mut state = State::neutral(&builder.build().unwrap());
        let (v, w) = (Vector3::new(1.0, -2.0, 0.5), Vector3::new(0.3, 0.2, -0.9));
        let mut estimate = VelocityEstimate::new(Some(30.0), None, &state);
        let mut measured = VelocityEstimate::new(None, None, &state);
        for k in 0..200 {
            let time = f64::from(k) * 0.004;
            state.p_WR = v * time;
            state.R_WR = spatial::exp(&(w * time));
            state.v.fill(7.0);
            measured.replace(time, &mut state);
            assert_eq!(state.v[0], 7.0);
            estimate.replace(time, &mut state);
        }
        for axis in 0..3 {
            assert!((state.v[axis] - v[axis]).abs() < 1e-9);
            assert!((state.v[3 + axis] - w[axis]).abs() < 1e-9);
        }
    }
}
