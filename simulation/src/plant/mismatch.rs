//! The plant's own model: the controller's with other inertial parameters.
#![allow(non_snake_case)]

use std::sync::Arc;

use nalgebra::Vector3;
use wbqp::{
    actuator::{Actuator, ActuatorKind, Rotor},
    model::{Body, Inertia, Model, ModelError},
    robot::RobotModel,
};

use super::Mismatch;

impl Mismatch {
    /// A robot with this mismatch's inertias, whose rotors' limits are those of the thrust that they produce.
    pub(crate) fn robot(&self, robot: &RobotModel) -> Result<RobotModel, ModelError> {
        let mut own = RobotModel {
            model: Arc::new(self.apply(&robot.model)?),
            ..robot.clone()
        };
        let is_rotor = |actuator: &&mut Actuator| matches!(actuator.kind, ActuatorKind::Rotor(_));
        for (i, actuator) in own.actuators.iter_mut().filter(is_rotor).enumerate() {
            if let ActuatorKind::Rotor(rotor) = &mut actuator.kind {
                *rotor = self.rotor(rotor);
            }
            let scale = self.rotor_scale(i);
            actuator.lower = (scale * actuator.lower).min(self.thrust_max);
            actuator.upper = (scale * actuator.upper).min(self.thrust_max);
        }
        Ok(own)
    }

    /// A rotor with this mismatch's time constants.
    pub(super) fn rotor(&self, rotor: &Rotor) -> Rotor {
        Rotor {
            rise: rotor.rise * self.rotor_lag_scale,
            fall: rotor.fall * self.rotor_lag_scale,
            ..rotor.clone()
        }
    }

    /// Thrust that rotor `i` produces relative to the thrust that was commanded.
    pub fn rotor_scale(&self, i: usize) -> f64 {
        self.thrust_scale * self.rotor_scales.get(i).copied().unwrap_or(1.0)
    }

    /// A model of the same tree with this mismatch's inertias.
    pub(super) fn apply(&self, model: &Model) -> Result<Model, ModelError> {
        let changed = self.mass_scale != 1.0
            || self.inertia_scale != 1.0
            || self.com_shift.iter().any(|&x| x != 0.0);
        if !changed {
            return Ok(model.clone());
        }
        let mut is_base = true;
        model.with_inertias(|body| {
            let shift = if is_base { self.com_shift } else { [0.0; 3] };
            is_base = false;
            self.inertia(body, &Vector3::from(shift))
        })
    }

    fn inertia(&self, body: &Body, shift: &Vector3<f64>) -> Inertia {
        let own = &body.inertia;
        Inertia::from_com(
            own.mass * self.mass_scale,
            own.com() + shift,
            own.I_BBcm() * (self.mass_scale * self.inertia_scale),
        )
    }
}
