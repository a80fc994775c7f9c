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

    /// Wrench per N of thrust on the body about its origin, body axes.
    fn unit_wrench(&self, model: &Model) -> UnitWrench {
        let X_BF = &model.frames()[self.frame.index()].X_BF;
        let z = X_BF.rotation * Vector3::z();
        UnitWrench {
            force: z,
            moment: X_BF.translation.vector.cross(&z) + z * self.moment,
        }
    }
}

/// What a rotor does to its body per N of thrust.
#[derive(Clone, Copy, Debug)]
struct UnitWrench {
    force: Vector3<f64>,
    /// m
    moment: Vector3<f64>,
}

/// All rotors of one body.
#[derive(Clone, Debug)]
pub(super) struct RotorGroup {
    body: BodyId,
    /// With their places among all rotors.
    rotors: Vec<(usize, UnitWrench)>,
}

impl RotorGroup {
    /// Rotors by the bodies that they are on.
    pub(super) fn all(rotors: &[RotorPlant], model: &Model) -> Vec<Self> {
        let mut groups: Vec<Self> = Vec::new();
        for (i, rotor) in rotors.iter().enumerate() {
            let wrench = (i, rotor.unit_wrench(model));
            match groups.iter_mut().find(|group| group.body == rotor.body) {
                Some(group) => group.rotors.push(wrench),
                None => groups.push(Self {
                    body: rotor.body,
                    rotors: vec![wrench],
                }),
            }
        }
        groups
    }

    /// Adds the wrench of its propellers.
    pub(super) fn push(&self, data: &Data, thrusts: &[f64], wrenches: &mut Wrenches) {
        let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
        for (i, unit) in &self.rotors {
            force += unit.force * thrusts[*i];
            moment += unit.moment * thrusts[*i];
        }
        wrenches.add_body_wrench(data, self.body, &force, &moment);
    }
}
