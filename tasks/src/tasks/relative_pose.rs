//! Pose of one frame of the robot relative to another.
//!
//! # Notation
//! A the frame that is looked from, B the one that is looked at, D where B should be. `r = p_WB − p_WA`;
//! `V_AB = [v_AB; w_AB]` is the velocity of B relative to A **in A's axes**, which turn.
#![allow(non_snake_case)]

use wbqp::{
    dynamics::FrameKinematics,
    nalgebra::UnitQuaternion,
    plugin::{RotationReference, VectorReference},
    prelude::*,
};

use super::{base_orientation::RotationError, frame_pose::POSE};
use crate::follow::stay;

/// Moves a frame of the robot relative to another one: two hands that hold an object, a camera that follows a tool.
///
/// Six rows in the axes of A = `relative_to`, m/s² and rad/s², with B = `frame`, `r = p_WB − p_WA`:
///
/// `J_AB v̇ = [v̇_d; ẇ_d] − K_D (V_AB − V_d) − K_P [p_AB − p_d; e] − J̇_AB v`,
///
/// `p_AB = R_WAᵀ r`, `v_AB = R_WAᵀ (v_WB − v_WA − w_WA × r)`, `w_AB = R_WAᵀ (w_WB − w_WA)`,
///
/// `J̇_AB v = R_WAᵀ [a_B − a_A − α_A × r − w_A × (w_A × r) − 2 w_A × R_WA v_AB; α_B − α_A − w_A × w_B]`
///
/// where `a`, `α` are the frames' bias accelerations; the rotation error is `e = log(R_AB R_ADᵀ)∨` or its ½ form, in
/// A's axes (relative Jacobian: Siciliano et al., *Robotics*, 3.8; relative acceleration: any text on mechanics).
///
/// Gravity and the base's motion have no part in it. Replacing the reference while running replaces that of the
/// position. Error: `[p_AB − p_d; e]`, m and rad.
#[wbqp::task("relative_pose", weight = [100.0, 100.0, 100.0, 10.0, 10.0, 10.0])]
pub struct RelativePose {
    /// The frame B that is placed, by name.
    pub frame: String,
    /// The frame A that it is placed relative to, by name.
    pub relative_to: String,
    /// Stiffness `K_P`, 1/s²: one number, or six: x, y, z, then about x, y, z.
    #[wbqp(unit = "1/s²")]
    pub kp: PerRow,
    /// Damping `K_D`, 1/s: one number, or six. Default: critical, `2 √K_P`.
    #[wbqp(unit = "1/s", critical = "kp")]
    pub kd: PerRow,
    /// How the difference of two orientations is measured.
    #[wbqp(default)]
    pub error: RotationError,
    /// Where to go: position of B's origin in A, m. Default: hold what is measured at the start.
    #[wbqp(default = stay(), unit = "m")]
    pub position: Box<dyn AnyReference>,
    /// How to turn: orientation of B in A, `[roll, pitch, yaw]` in rad. Default: hold what is measured at the start.
    #[wbqp(default = stay(), unit = "rad")]
    pub orientation: Box<dyn AnyReference>,
}

impl RelativePose {
    /// Holds `frame` where it is at the start relative to `relative_to`, with these gains (1/s², 1/s).
    pub fn new(
        frame: impl Into<String>,
        relative_to: impl Into<String>,
        kp: impl Into<PerRow>,
        kd: impl Into<PerRow>,
    ) -> Self {
        Self {
            frame: frame.into(),
            relative_to: relative_to.into(),
            kp: kp.into(),
            kd: kd.into(),
            error: RotationError::default(),
            position: stay(),
            orientation: stay(),
        }
    }

    /// Follows a trajectory of the position in A, m.
    pub fn moving(mut self, position: impl AnyReference) -> Self {
        self.position = Box::new(position);
        self
    }

    /// Follows a trajectory of the orientation in A.
    pub fn turning(mut self, orientation: impl AnyReference) -> Self {
        self.orientation = Box::new(orientation);
        self
    }
}

/// Relative velocity and bias acceleration, `[linear; angular]` in A's axes.
fn motion(A: &FrameKinematics, B: &FrameKinematics) -> ([Vector3<f64>; 2], [Vector3<f64>; 2]) {
    let R_AW = A.R_WF.inverse();
    let r = B.p_WF - A.p_WF;
    let part =
        |frame: &FrameKinematics, first: usize| Vector3::from_fn(|i, _| frame.Jdot_v[first + i]);
    let (w_A, w_B) = (A.w_WF, B.w_WF);
    let v = B.v_WF - A.v_WF - w_A.cross(&r);
    let linear = part(B, 0)
        - part(A, 0)
        - part(A, 3).cross(&r)
        - w_A.cross(&w_A.cross(&r))
        - 2.0 * w_A.cross(&v);
    let angular = part(B, 3) - part(A, 3) - w_A.cross(&w_B);
    (
        [R_AW * v, R_AW * (w_B - w_A)],
        [R_AW * linear, R_AW * angular],
    )
}

/// What runs of a [`RelativePose`].
#[derive(Debug)]
pub struct RunningRelativePose {
    /// A and B.
    frames: [FrameHandle; 2],
    position: VectorReference,
    orientation: RotationReference,
}

impl Task for RelativePose {
    type Running = RunningRelativePose;

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(Layout, RunningRelativePose), BindError> {
        let frames = [setup.frame(&self.relative_to)?, setup.frame(&self.frame)?];
        if self.frame == self.relative_to {
            let problem = format!("is `{}`, the frame itself", self.frame);
            return Err(BindError::value("relative_to", problem));
        }
        self.kp.validate("kp", 6)?;
        self.kd.validate("kd", 6)?;
        let running = RunningRelativePose {
            frames,
            position: setup.follow_vector("position", &*self.position, 3, move |tick, p| {
                let [A, B] = frames.map(|frame| tick.frame(frame));
                let p_AB = A.R_WF.inverse() * (B.p_WF - A.p_WF);
                p.copy_from_slice(p_AB.as_slice());
            })?,
            orientation: setup.follow_rotation("orientation", &*self.orientation, move |tick| {
                let [A, B] = frames.map(|frame| tick.frame(frame));
                UnitQuaternion::from_rotation_matrix(&(A.R_WF.inverse() * B.R_WF))
            })?,
        };
        let layout = Layout::rows(POSE).error_unit("m or rad").vdot_dense();
        Ok((layout, running))
    }

    fn update(&self, running: &mut RunningRelativePose, tick: &Tick<'_>, rows: &mut Rows<'_>) {
        let [A, B] = running.frames.map(|frame| tick.frame(frame));
        let place = tick.vector(running.position);
        let attitude = tick.rotation(running.orientation);
        let R_AW = A.R_WF.inverse();
        let r = B.p_WF - A.p_WF;

        let mut vdot = rows.vdot();
        for (j, (a, b)) in A.J.column_iter().zip(B.J.column_iter()).enumerate() {
            let (linear_a, angular_a) = (a.fixed_rows::<3>(0), a.fixed_rows::<3>(3));
            let (linear_b, angular_b) = (b.fixed_rows::<3>(0), b.fixed_rows::<3>(3));
            let linear = R_AW * (linear_b - linear_a + r.cross(&angular_a));
            let angular = R_AW * (angular_b - angular_a);
            for i in 0..3 {
                vdot[(i, j)] = linear[i];
                vdot[(3 + i, j)] = angular[i];
            }
        }

        let R_AB = UnitQuaternion::from_rotation_matrix(&(R_AW * B.R_WF));
        let ([v, w], bias) = motion(A, B);
        let errors = [
            R_AW * r - place.value3(),
            self.error.between(&R_AB, &attitude.rotation),
        ];
        let rates = [v - place.rate3(), w - attitude.rate];
        let accelerations = [place.acceleration3(), attitude.acceleration];
        for k in 0..6 {
            let (part, i) = (k / 3, k % 3);
            rows.bias(k, bias[part][i]);
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
