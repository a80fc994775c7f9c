//! A contact before the first tick, and what is asked of it between ticks.
#![allow(non_snake_case)]

use nalgebra::{Matrix6xX, Rotation3, Translation3, Vector3, Vector6};

use super::{ContactBinding, ContactSpec, ContactState, SensorZero, SurfaceMotion, update::CUTOFF};
use crate::{error::BindError, switch::Switch};
use wbqp_dynamics::{FrameKinematics, elementary::low_pass, model::Model};

impl ContactBinding {
    pub(crate) fn new(spec: &ContactSpec, model: &Model, period: f64) -> Result<Self, BindError> {
        spec.validate()?;
        let id = model.frame(&spec.frame).ok_or_else(|| {
            let known = model.frames().iter().map(|f| f.name.as_str());
            BindError::unknown("frame", &spec.frame, known)
        })?;
        let frame = &model.frames()[id.index()];
        let offset = Translation3::from(Vector3::from(spec.offset));
        Ok(Self {
            switch: Switch::new(spec.active, spec.transition),
            switched_on: false,
            body: frame.body,
            X_BC: frame.X_BF * offset,
            kinematics: FrameKinematics::new(model),
            exit_force: 0.0,
            exit_alpha: 1.0,
            filtered: Vector3::zeros(),
            zero: SensorZero::default(),
            motion: SurfaceMotion::fixed(
                spec.surface.rotation()?,
                Vector3::from(spec.surface.origin),
            ),
            shares: [spec.free_force_cutoff, CUTOFF].map(|cutoff| low_pass(cutoff, period)),
            period,
            spec: spec.clone(),
        })
    }

    /// The state before the first tick.
    pub(crate) fn initial_state(&self, model: &Model) -> ContactState {
        let spec = &self.spec;
        ContactState {
            kind: spec.kind,
            live: spec.active,
            alpha: if spec.active { 1.0 } else { 0.0 },
            since: f64::NEG_INFINITY,
            R_WC: self.motion.R_WC,
            p_WS: self.motion.p_WS,
            p_SC: Vector3::zeros(),
            R_CE: Rotation3::identity(),
            V: Vector6::zeros(),
            J: Matrix6xX::zeros(model.nv()),
            Jdot_v: Vector6::zeros(),
            surface_acceleration: Vector6::zeros(),
            friction: spec.friction,
            force_limits: [spec.force_min, spec.force_max],
            measured: Vector6::zeros(),
            measured_at_switch: Vector6::zeros(),
            free_force: Vector6::zeros(),
            set_point: Vector3::zeros(),
            solution: Vector6::zeros(),
        }
    }

    /// Moves the surface from the next tick on.
    pub(crate) fn move_surface(&mut self, motion: &SurfaceMotion) {
        self.motion = *motion;
    }
}

impl SurfaceMotion {
    /// A surface at rest.
    pub fn fixed(R_WC: Rotation3<f64>, p_WS: Vector3<f64>) -> Self {
        Self {
            R_WC,
            p_WS,
            v_WS: Vector3::zeros(),
            w_WC: Vector3::zeros(),
            a_WS: Vector3::zeros(),
            alpha_WC: Vector3::zeros(),
        }
    }

    /// Whether every number is finite.
    pub fn is_finite(&self) -> bool {
        let vectors = [self.p_WS, self.v_WS, self.w_WC, self.a_WS, self.alpha_WC];
        vectors.iter().all(|v| v.iter().all(|x| x.is_finite()))
            && self.R_WC.matrix().iter().all(|x| x.is_finite())
    }
}

impl SensorZero {
    /// The mean reading is zero from now on. Before the first reading nothing changes.
    pub(crate) fn take(&mut self) {
        if let Some(mean) = self.mean {
            self.offset = mean;
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector6;

    use super::SensorZero;

    #[test]
    fn what_is_read_on_average_becomes_zero() {
        let mut zero = SensorZero::default();
        let bias = Vector6::new(0.2, -0.1, 0.3, 0.01, 0.0, -0.02);
        zero.take();
        assert_eq!(zero.correct(&bias), bias);
        for k in 0..500 {
            let noise = if k % 2 == 0 { 0.05 } else { -0.05 };
            zero.follow(&bias.add_scalar(noise), 0.016);
        }
        assert_eq!(zero.correct(&bias), bias);
        zero.take();
        assert!(zero.correct(&bias).amax() < 1e-3);
    }
}
