//! Position and orientation of a frame.
//!
//! # Notation
//! W world, F the frame, D where it should be. All vectors in world axes.
#![allow(non_snake_case)]

use wbqp::{
    error::BindError,
    nalgebra::UnitQuaternion,
    plugin::{
        FrameHandle, Layout, AnyReference, Rows, Sample, Setup, Space, Task, Tick,
        reference::{ReferenceSlot, begin, begin_at, begin_turned},
    },
    schemars::JsonSchema,
    serde::{Deserialize, Serialize},
};

use super::base_orientation::RotationError;
use crate::{follow::stay, gain::Gain};

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
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(crate = "wbqp::serde", deny_unknown_fields)]
#[schemars(crate = "wbqp::schemars", extend("x-weight" = [100.0, 100.0, 100.0, 10.0, 10.0, 10.0]))]
pub struct FramePose {
    /// The frame, by name.
    pub frame: String,
    /// Stiffness `K_P`, 1/s²: one number, or six: x, y, z, then about x, y, z.
    #[schemars(extend("x-unit" = "1/s²"))]
    pub kp: Gain,
    /// Damping `K_D`, 1/s: one number, or six. Default: critical, `2 √K_P`.
    #[schemars(extend("x-unit" = "1/s", "x-critical" = "kp"))]
    pub kd: Gain,
    /// How the difference of two orientations is measured.
    #[serde(default)]
    pub error: RotationError,
    /// Where to go: position of the frame's origin in the world, m. Default: hold what is measured at the start.
    #[serde(default = "stay")]
    #[schemars(extend("x-unit" = "m"))]
    pub position: Box<dyn AnyReference>,
    /// How to turn: orientation of the frame in the world, `[roll, pitch, yaw]` in rad. Default: hold what is
    /// measured at the start.
    #[serde(default = "stay")]
    #[schemars(extend("x-unit" = "rad"))]
    pub orientation: Box<dyn AnyReference>,
    #[serde(skip)]
    place: Sample,
    #[serde(skip)]
    attitude: Sample,
    #[serde(skip)]
    bound: Option<FrameHandle>,
}

impl FramePose {
    /// Holds the frame where it is at the start, with these gains (1/s², 1/s).
    pub fn new(frame: impl Into<String>, kp: impl Into<Gain>, kd: impl Into<Gain>) -> Self {
        Self {
            frame: frame.into(),
            kp: kp.into(),
            kd: kd.into(),
            error: RotationError::default(),
            position: stay(),
            orientation: stay(),
            place: Sample::default(),
            attitude: Sample::default(),
            bound: None,
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

#[wbqp::task("frame_pose")]
impl Task for FramePose {
    fn bind(&mut self, setup: &mut Setup<'_>) -> Result<Layout, BindError> {
        let frame = setup.frame(&self.frame)?;
        self.kp.validate("kp", 6)?;
        self.kd.validate("kd", 6)?;
        let home = setup.frame_at_home(&self.frame)?;
        let place = Sample::at_rest(home.p_WF.iter().copied());
        let attitude = Sample::turned(UnitQuaternion::from_rotation_matrix(&home.R_WF));
        let (position, orientation) = (self.position.as_mut(), self.orientation.as_mut());
        self.place = begin("position", position, Space::Vector(3), place)?;
        self.attitude = begin("orientation", orientation, Space::Rotation, attitude)?;
        self.bound = Some(frame);
        Ok(Layout::rows(POSE)
            .error_unit("m or rad")
            .vdot_frame(frame, 0..6))
    }

    fn begin(&mut self, tick: &Tick<'_>) {
        if let Some(frame) = self.bound {
            let frame = tick.frame(frame);
            let p_WF = frame.p_WF.iter().copied();
            begin_at(self.position.as_mut(), &mut self.place, p_WF);
            let R_WF = UnitQuaternion::from_rotation_matrix(&frame.R_WF);
            begin_turned(self.orientation.as_mut(), &mut self.attitude, &R_WF);
        }
    }

    fn update(&mut self, tick: &Tick<'_>, rows: &mut Rows<'_>) {
        let Some(frame) = self.bound else {
            return;
        };
        self.position.sample(tick, &mut self.place);
        self.orientation.sample(tick, &mut self.attitude);
        let frame = tick.frame(frame);
        let R_WF = UnitQuaternion::from_rotation_matrix(&frame.R_WF);
        let errors = [
            frame.p_WF - self.place.value3(),
            self.error.between(&R_WF, &self.attitude.rotation),
        ];
        let rates = [
            frame.v_WF - self.place.rate3(),
            frame.w_WF - self.attitude.rate3(),
        ];
        let accelerations = [self.place.acceleration3(), self.attitude.acceleration3()];
        for k in 0..6 {
            let (part, i) = (k / 3, k % 3);
            let (error, rate) = (errors[part][i], rates[part][i]);
            rows.b()[k] = accelerations[part][i]
                - self.kd.axis(k) * rate
                - self.kp.axis(k) * error
                - frame.Jdot_v[k];
            rows.error()[k] = error;
        }
    }

    fn follow(&mut self) -> Option<ReferenceSlot<'_>> {
        Some(ReferenceSlot {
            reference: &mut self.position,
            sample: &self.place,
            space: Space::Vector(3),
        })
    }
}
