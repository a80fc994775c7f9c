//! Orientation of a frame.
//!
//! # Notation
//! W world, F the frame, D where it should be. `w` angular velocities in world axes.
#![allow(non_snake_case)]

use wbqp::{nalgebra::UnitQuaternion, plugin::RotationReference, prelude::*};

use super::base_orientation::{GainAxes, RotationError};
use crate::follow::stay;

/// Turns a frame of the robot.
///
/// Three rows in world axes, rad/s²:
///
/// `J_F v̇ = ẇ_d − K_D (w_WF − w_d) − K_P e − J̇_F v`, `e = log(R_WF R_WDᵀ)∨` or `½[R_WF R_WDᵀ − R_WD R_WFᵀ]∨`,
///
/// `J_F` the angular rows of the frame's world-aligned Jacobian. Errors as in
/// [`BaseOrientation`](crate::BaseOrientation); both forms are derived in Siciliano et al., *Robotics*, 3.7.3.
///
/// Error: `e`, rad, world axes.
#[wbqp::task("frame_orientation", weight = 10.0)]
pub struct FrameOrientation {
    /// The frame, by name.
    pub frame: String,
    /// Stiffness `K_P`, 1/s²: one number, or one per axis of `axes`.
    #[wbqp(unit = "1/s²")]
    pub kp: PerRow,
    /// Damping `K_D`, 1/s: one number, or one per axis of `axes`. Default: critical, `2 √K_P`.
    #[wbqp(unit = "1/s", critical = "kp")]
    pub kd: PerRow,
    /// How the difference of two orientations is measured.
    #[wbqp(default)]
    pub error: RotationError,
    /// Along which axes the gains count.
    #[wbqp(default)]
    pub axes: GainAxes,
    /// Where to go: orientation of the frame in the world, `[roll, pitch, yaw]` in rad. Default: hold what is
    /// measured at the start.
    #[wbqp(default = stay(), unit = "rad")]
    pub reference: Box<dyn AnyReference>,
}

impl FrameOrientation {
    /// Holds the frame's orientation of the start with these gains (1/s², 1/s), along world axes.
    pub fn new(frame: impl Into<String>, kp: impl Into<PerRow>, kd: impl Into<PerRow>) -> Self {
        Self {
            frame: frame.into(),
            kp: kp.into(),
            kd: kd.into(),
            error: RotationError::default(),
            axes: GainAxes::default(),
            reference: stay(),
        }
    }

    /// Follows a trajectory: orientation in the world.
    pub fn following(mut self, reference: impl AnyReference) -> Self {
        self.reference = Box::new(reference);
        self
    }
}

impl Task for FrameOrientation {
    type Running = (FrameHandle, RotationReference);

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(Layout, Self::Running), BindError> {
        let frame = setup.frame(&self.frame)?;
        self.kp.validate("kp", 3)?;
        self.kd.validate("kd", 3)?;
        let measured =
            move |tick: &Tick<'_>| UnitQuaternion::from_rotation_matrix(&tick.frame(frame).R_WF);
        let reference = setup.follow_rotation("reference", &*self.reference, measured)?;
        let layout = Layout::rows([("x", "rad/s²"), ("y", "rad/s²"), ("z", "rad/s²")])
            .error_unit("rad")
            .vdot_frame(frame, [3, 4, 5]);
        Ok((layout, (frame, reference)))
    }

    fn update(&self, (frame, reference): &mut Self::Running, tick: &Tick<'_>, rows: &mut Rows<'_>) {
        let (frame, desired) = (tick.frame(*frame), tick.rotation(*reference));
        let R_WF = UnitQuaternion::from_rotation_matrix(&frame.R_WF);
        let error = self.error.between(&R_WF, &desired.rotation);
        let rate = frame.w_WF - desired.rate;
        let gains = [&self.kp, &self.kd];
        let feedback = self.axes.feedback(gains, &R_WF, &error, &rate);
        for k in 0..3 {
            rows.acceleration(k, desired.acceleration[k] - feedback[k]);
        }
        rows.error().copy_from(&error);
    }

    fn remembered(&self, _: &mut Self::Running, _: &mut Remembered<'_>) {}
}
