//! Position of a frame.
//!
//! # Notation
//! W world, F the frame. All vectors in world axes.
#![allow(non_snake_case)]

use wbqp::{plugin::VectorReference, prelude::*};

use crate::{axis::Axis, follow::stay};

/// Moves the origin of a frame of the robot: an end effector, a foot, a camera.
///
/// One row per axis, world axes, m/s²:
///
/// `J_F v̇ = v̇_d − K_D (v_WF − v_d) − K_P (p_WF − p_d) − J̇_F v`,
///
/// `J_F` the linear rows of the frame's world-aligned Jacobian (Siciliano et al., *Robotics: Modelling, Planning and
/// Control*, 3.5 and 8.6.2: inverse dynamics in operational space).
///
/// Error: `p_WF − p_d`, m.
#[wbqp::task("frame_position", weight = 100.0)]
pub struct FramePosition {
    /// The frame, by name.
    pub frame: String,
    /// Stiffness `K_P`, 1/s²: one number, or one per axis.
    #[wbqp(unit = "1/s²")]
    pub kp: PerRow,
    /// Damping `K_D`, 1/s: one number, or one per axis. Default: critical, `2 √K_P`.
    #[wbqp(unit = "1/s", critical = "kp")]
    pub kd: PerRow,
    /// Which axes of the world; rows, gains and reference are in this order. Default: x, y, z.
    pub axes: Option<Vec<Axis>>,
    /// Where to go: one position per axis, m, world. Default: hold what is measured at the start.
    #[wbqp(default = stay(), unit = "m")]
    pub reference: Box<dyn AnyReference>,
}

impl FramePosition {
    /// Holds the frame where it is at the start, with these gains (1/s², 1/s).
    pub fn new(frame: impl Into<String>, kp: impl Into<PerRow>, kd: impl Into<PerRow>) -> Self {
        Self {
            frame: frame.into(),
            kp: kp.into(),
            kd: kd.into(),
            axes: None,
            reference: stay(),
        }
    }

    /// Follows a trajectory: one position per axis, m, world.
    pub fn following(mut self, reference: impl AnyReference) -> Self {
        self.reference = Box::new(reference);
        self
    }

    /// Moves only along these axes.
    pub fn along(mut self, axes: impl Into<Vec<Axis>>) -> Self {
        self.axes = Some(axes.into());
        self
    }
}

/// What runs of a [`FramePosition`].
#[derive(Debug)]
pub struct RunningFramePosition {
    frame: FrameHandle,
    axes: Vec<Axis>,
    reference: VectorReference,
}

impl Task for FramePosition {
    type Running = RunningFramePosition;

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(Layout, RunningFramePosition), BindError> {
        let frame = setup.frame(&self.frame)?;
        let axes = Axis::chosen(self.axes.as_deref())?;
        let n = axes.len();
        self.kp.validate("kp", n)?;
        self.kd.validate("kd", n)?;
        let measured = axes.clone();
        let measured = move |tick: &Tick<'_>, out: &mut [f64]| {
            let p_WF = tick.frame(frame).p_WF;
            for (out, axis) in out.iter_mut().zip(&measured) {
                *out = p_WF[axis.index()];
            }
        };
        let reference = setup.follow_vector("reference", &*self.reference, n, measured)?;
        let layout = Layout::rows(axes.iter().map(|axis| (axis.name(), "m/s²")))
            .error_unit("m")
            .vdot_frame(frame, axes.iter().map(|axis| axis.index()));
        Ok((
            layout,
            RunningFramePosition {
                frame,
                axes,
                reference,
            },
        ))
    }

    fn update(&self, running: &mut RunningFramePosition, tick: &Tick<'_>, rows: &mut Rows<'_>) {
        let frame = tick.frame(running.frame);
        let desired = tick.vector(running.reference);
        for (k, axis) in running.axes.iter().enumerate() {
            let i = axis.index();
            let [value, rate, acceleration] = desired.component(k);
            rows.motion(
                k,
                MotionRow {
                    error: frame.p_WF[i] - value,
                    rate: frame.v_WF[i] - rate,
                    acceleration,
                    kp: self.kp.row(k),
                    kd: self.kd.row(k),
                },
            );
        }
    }

    fn remembered(&self, _: &mut Self::Running, _: &mut Remembered<'_>) {}
}
