//! Position and orientation of a frame.
//!
//! # Notation
//! W world, F the frame, D where it should be. All vectors in world axes.
#![allow(non_snake_case)]

use wbqp::{
    nalgebra::UnitQuaternion,
    plugin::{RotationReference, VectorReference},
    prelude::*,
};

use super::base_orientation::RotationError;
use crate::follow::stay;

/// Moves and turns a frame of the robot: [`FramePosition`](crate::FramePosition) and
/// [`FrameOrientation`](crate::FrameOrientation) in one entry.
///
/// Six rows in world axes, m/s² and rad/s²:
///
/// `J_F v̇ = [v̇_d; ẇ_d] − K_D ([v_WF; w_WF] − [v_d; w_d]) − K_P [p_WF − p_d; e] − J̇_F v`,
///
/// with the rotation error `e = log(R_WF R_WDᵀ)∨` or `½[R_WF R_WDᵀ − R_WD R_WFᵀ]∨` (Siciliano et al., *Robotics*,
/// 3.7.3 and 8.6.2). Metres and radians have different units: give the entry one weight per row, or write two tasks.
///
/// Replacing the reference while running replaces that of the position. Error: `[p_WF − p_d; e]`, m and rad.
#[wbqp::task("frame_pose", weight = [100.0, 100.0, 100.0, 10.0, 10.0, 10.0])]
pub struct FramePose {
    /// The frame, by name.
    pub frame: String,
    /// Stiffness `K_P`, 1/s²: one number, or six: x, y, z, then about x, y, z.
    #[wbqp(unit = "1/s²")]
    pub kp: PerRow,
    /// Damping `K_D`, 1/s: one number, or six. Default: critical, `2 √K_P`.
    #[wbqp(unit = "1/s", critical = "kp")]
    pub kd: PerRow,
    /// How the difference of two orientations is measured.
    #[wbqp(default)]
    pub error: RotationError,
    /// Where to go: position of the frame's origin in the world, m. Default: hold what is measured at the start.
    #[wbqp(default = stay(), unit = "m")]
    pub position: Box<dyn AnyReference>,
    /// How to turn: orientation of the frame in the world, `[roll, pitch, yaw]` in rad. Default: hold what is
    /// measured at the start.
    #[wbqp(default = stay(), unit = "rad")]
    pub orientation: Box<dyn AnyReference>,
}

impl FramePose {
    /// Holds the frame where it is at the start, with these gains (1/s², 1/s).
    pub fn new(frame: impl Into<String>, kp: impl Into<PerRow>, kd: impl Into<PerRow>) -> Self {
        Self {
            frame: frame.into(),
            kp: kp.into(),
            kd: kd.into(),
            error: RotationError::default(),
            position: stay(),
            orientation: stay(),
        }
    }

    /// Follows a trajectory of the position, m, world.
    pub fn moving(mut self, position: impl AnyReference) -> Self {
        self.position = Box::new(position);
        self
    }

    /// Follows a trajectory of the orientation in the world.
    pub fn turning(mut self, orientation: impl AnyReference) -> Self {
        self.orientation = Box::new(orientation);
        self
    }
}

/// Labels and units of the six rows of a pose.
pub(super) const POSE: [(&str, &str); 6] = [
    ("x", "m/s²"),
    ("y", "m/s²"),
    ("z", "m/s²"),
    ("turn x", "rad/s²"),
    ("turn y", "rad/s²"),
    ("turn z", "rad/s²"),
];

/// What runs of a [`FramePose`].
#[derive(Debug)]
pub struct RunningFramePose {
    frame: FrameHandle,
    position: VectorReference,
    orientation: RotationReference,
}

impl Task for FramePose {
    type Running = RunningFramePose;

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(Layout, RunningFramePose), BindError> {
        let frame = setup.frame(&self.frame)?;
        self.kp.validate("kp", 6)?;
        self.kd.validate("kd", 6)?;
        let running = RunningFramePose {
            frame,
            position: setup.follow_vector("position", &*self.position, 3, move |tick, p| {
                p.copy_from_slice(tick.frame(frame).p_WF.as_slice());
            })?,
            orientation: setup.follow_rotation("orientation", &*self.orientation, move |tick| {
                UnitQuaternion::from_rotation_matrix(&tick.frame(frame).R_WF)
            })?,
        };
        let layout = Layout::rows(POSE)
            .error_unit("m or rad")
            .vdot_frame(frame, 0..6);
        Ok((layout, running))
    }

    fn update(&self, running: &mut RunningFramePose, tick: &Tick<'_>, rows: &mut Rows<'_>) {
        let frame = tick.frame(running.frame);
        let place = tick.vector(running.position);
        let attitude = tick.rotation(running.orientation);
        let R_WF = UnitQuaternion::from_rotation_matrix(&frame.R_WF);
        let errors = [
            frame.p_WF - place.value3(),
            self.error.between(&R_WF, &attitude.rotation),
        ];
        let rates = [frame.v_WF - place.rate3(), frame.w_WF - attitude.rate];
        let accelerations = [place.acceleration3(), attitude.acceleration];
        for k in 0..6 {
            let (part, i) = (k / 3, k % 3);
            rows.motion(
                k,
                MotionRow {
                    error: errors[part][i],
                    rate: rates[part][i],
                    acceleration: accelerations[part][i],
                    kp: self.kp.row(k),
                    kd: self.kd.row(k),
                },
            );
        }
    }

    fn remembered(&self, _: &mut Self::Running, _: &mut Remembered<'_>) {}
}
