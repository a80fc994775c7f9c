//! Rotors: a first-order motor and the wrench of a propeller.
//!
//! # Notation
//! `f` is the thrust produced, N; `z_i` the z axis of rotor i's frame in world axes; `k_m` the moment
//! coefficient, m; `σ` the sign of the reaction torque.
//! ```text
//! ḟ = (min(s·sat(f_cmd), f_m) − f) / τ    τ = rise while f rises, fall while it falls
//!                                         s = thrust_scale, f_m = thrust_max
//! force f z_i at the frame's origin, moment σ k_m f z_i
//! ```
#![allow(non_snake_case)]

use nalgebra::Vector3;
use wbqp::{
    actuator::{Actuator, Rotor},
    dynamics::{Data, Wrenches, frame_motion},
    model::{BodyId, FrameId, Model},
};

use super::PlantError;

/// A rotor of the plant.
#[derive(Clone, Copy, Debug)]
pub(super) struct RotorPlant {
    /// Index in the command.
    pub(super) actuator: usize,
    frame: FrameId,
    body: BodyId,
    lower: f64,
    upper: f64,
    scale: f64,
    max: f64,
    rise: f64,
    fall: f64,
    /// `σ k_m`, m.
    moment: f64,
}

impl RotorPlant {
    pub(super) fn new(
        index: usize,
        actuator: &Actuator,
        rotor: &Rotor,
        (scale, max): (f64, f64),
        step: f64,
        model: &Model,
    ) -> Result<Self, PlantError> {
        let refuse = |what: String| {
            Err(PlantError::Actuator {
                name: actuator.name.clone(),
                what,
            })
        };
        for (what, time) in [("rise", rotor.rise), ("fall", rotor.fall)] {
            if !time.is_finite() || time < 2.0 * step {
                return refuse(format!(
                    "time constant `{what}` is {time} s, must be at least two steps of {step} s"
                ));
            }
        }
        if !rotor.moment_coefficient.is_finite() {
            return refuse("moment coefficient is not finite".into());
        }
        let Some(frame) = model.frames().get(rotor.frame.index()) else {
            return refuse("its frame is not one of the robot's".into());
        };
        Ok(Self {
            actuator: index,
            frame: rotor.frame,
            body: frame.body,
            lower: actuator.lower,
            upper: actuator.upper,
            scale,
            max,
            rise: rotor.rise,
            fall: rotor.fall,
            moment: rotor.reaction.sign() * rotor.moment_coefficient,
        })
    }

    /// Thrust that a command leads to, N.
    pub(super) fn target(&self, command: f64) -> f64 {
        (self.scale * command.clamp(self.lower, self.upper)).min(self.max)
    }

    /// `ḟ`, N/s.
    pub(super) fn rate(&self, thrust: f64, command: f64) -> f64 {
        let missing = self.target(command) - thrust;
        let time = if missing > 0.0 { self.rise } else { self.fall };
        missing / time
    }

    /// Adds the propeller's wrench.
    pub(super) fn push(&self, model: &Model, data: &Data, thrust: f64, wrenches: &mut Wrenches) {
        let at = frame_motion(model, data, self.frame);
        let force: Vector3<f64> = at.R_WF.matrix().column(2) * thrust;
        let moment = force * self.moment;
        wrenches.add_wrench(data, self.body, &at.p_WF, &force, &moment);
    }
}
