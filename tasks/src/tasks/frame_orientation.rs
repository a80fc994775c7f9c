//! Orientation of a frame.
//!
//! # Notation
//! W world, F the frame, D where it should be. `w` angular velocities in world axes.
#![allow(non_snake_case)]

use wbqp::{
    error::BindError,
    nalgebra::{UnitQuaternion, Vector3},
    plugin::{
        FrameHandle, Layout, AnyReference, Rows, Sample, Setup, Space, Task, Tick,
        reference::{ReferenceSlot, begin, begin_turned},
    },
    schemars::JsonSchema,
    serde::{Deserialize, Serialize},
};

use super::base_orientation::{GainAxes, RotationError};
use crate::{follow::stay, gain::Gain};

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
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(crate = "wbqp::serde", deny_unknown_fields)]
#[schemars(crate = "wbqp::schemars", extend("x-weight" = 10.0))]
pub struct FrameOrientation {
    /// The frame, by name.
    pub frame: String,
    /// Stiffness `K_P`, 1/s²: one number, or one per axis of `axes`.
    #[schemars(extend("x-unit" = "1/s²"))]
    pub kp: Gain,
    /// Damping `K_D`, 1/s: one number, or one per axis of `axes`. Default: critical, `2 √K_P`.
    #[schemars(extend("x-unit" = "1/s", "x-critical" = "kp"))]
    pub kd: Gain,
    /// How the difference of two orientations is measured.
    #[serde(default)]
    pub error: RotationError,
    /// Along which axes the gains count.
    #[serde(default)]
    pub axes: GainAxes,
    /// Where to go: orientation of the frame in the world, `[roll, pitch, yaw]` in rad. Default: hold what is
    /// measured at the start.
    #[serde(default = "stay")]
    #[schemars(extend("x-unit" = "rad"))]
    pub reference: Box<dyn AnyReference>,
    #[serde(skip)]
    sample: Sample,
    #[serde(skip)]
    bound: Option<FrameHandle>,
}

impl FrameOrientation {
    /// Holds the frame's orientation of the start with these gains (1/s², 1/s), along world axes.
    pub fn new(frame: impl Into<String>, kp: impl Into<Gain>, kd: impl Into<Gain>) -> Self {
        Self {
            frame: frame.into(),
            kp: kp.into(),
            kd: kd.into(),
            error: RotationError::default(),
            axes: GainAxes::default(),
            reference: stay(),
            sample: Sample::default(),
            bound: None,
        }
    }

    /// Follows a trajectory: orientation in the world.
    pub fn following(mut self, reference: impl AnyReference) -> Self {
        self.reference = Box::new(reference);
        self
    }
}

#[wbqp::task("frame_orientation")]
impl Task for FrameOrientation {
    fn bind(&mut self, setup: &mut Setup<'_>) -> Result<Layout, BindError> {
        let frame = setup.frame(&self.frame)?;
        self.kp.validate("kp", 3)?;
        self.kd.validate("kd", 3)?;
        let R_WF = setup.frame_at_home(&self.frame)?.R_WF;
        let home = Sample::turned(UnitQuaternion::from_rotation_matrix(&R_WF));
        self.sample = begin("reference", self.reference.as_mut(), Space::Rotation, home)?;
        self.bound = Some(frame);
        Ok(
            Layout::rows([("x", "rad/s²"), ("y", "rad/s²"), ("z", "rad/s²")])
                .error_unit("rad")
                .vdot_frame(frame, [3, 4, 5]),
        )
    }

    fn begin(&mut self, tick: &Tick<'_>) {
        if let Some(frame) = self.bound {
            let R_WF = UnitQuaternion::from_rotation_matrix(&tick.frame(frame).R_WF);
            begin_turned(self.reference.as_mut(), &mut self.sample, &R_WF);
        }
    }

    fn update(&mut self, tick: &Tick<'_>, rows: &mut Rows<'_>) {
        let Some(frame) = self.bound else {
            return;
        };
        self.reference.sample(tick, &mut self.sample);
        let frame = tick.frame(frame);
        let R_WF = UnitQuaternion::from_rotation_matrix(&frame.R_WF);
        let error = self.error.between(&R_WF, &self.sample.rotation);
        let rate = frame.w_WF - self.sample.rate3();
        let gains = [&self.kp, &self.kd];
        let bias = Vector3::from_fn(|i, _| frame.Jdot_v[3 + i]);
        let feedback = self.axes.feedback(gains, &R_WF, &error, &rate);
        rows.b()
            .copy_from(&(self.sample.acceleration3() - feedback - bias));
        rows.error().copy_from(&error);
    }

    fn follow(&mut self) -> Option<ReferenceSlot<'_>> {
        Some(ReferenceSlot {
            reference: &mut self.reference,
            sample: &self.sample,
            space: Space::Rotation,
        })
    }
}
