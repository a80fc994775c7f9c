//! Position of a frame.
//!
//! # Notation
//! W world, F the frame. All vectors in world axes.
#![allow(non_snake_case)]

use wbqp::{
    error::BindError,
    plugin::{
        FrameHandle, Layout, AnyReference, Rows, Sample, Setup, Space, Task, Tick,
        reference::{ReferenceSlot, begin, begin_at},
    },
    schemars::JsonSchema,
    serde::{Deserialize, Serialize},
};

use crate::{
    axis::Axis,
    follow::{component, stay},
    gain::Gain,
};

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
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(crate = "wbqp::serde", deny_unknown_fields)]
#[schemars(crate = "wbqp::schemars", extend("x-weight" = 100.0))]
pub struct FramePosition {
    /// The frame, by name.
    pub frame: String,
    /// Stiffness `K_P`, 1/s²: one number, or one per axis.
    #[schemars(extend("x-unit" = "1/s²"))]
    pub kp: Gain,
    /// Damping `K_D`, 1/s: one number, or one per axis. Default: critical, `2 √K_P`.
    #[schemars(extend("x-unit" = "1/s", "x-critical" = "kp"))]
    pub kd: Gain,
    /// Which axes of the world; rows, gains and reference are in this order. Default: x, y, z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axes: Option<Vec<Axis>>,
    /// Where to go: one position per axis, m, world. Default: hold what is measured at the start.
    #[serde(default = "stay")]
    #[schemars(extend("x-unit" = "m"))]
    pub reference: Box<dyn AnyReference>,
    #[serde(skip)]
    sample: Sample,
    #[serde(skip)]
    bound: Option<(FrameHandle, Vec<Axis>)>,
}

impl FramePosition {
    /// Holds the frame where it is at the start, with these gains (1/s², 1/s).
    pub fn new(frame: impl Into<String>, kp: impl Into<Gain>, kd: impl Into<Gain>) -> Self {
        Self {
            frame: frame.into(),
            kp: kp.into(),
            kd: kd.into(),
            axes: None,
            reference: stay(),
            sample: Sample::default(),
            bound: None,
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

#[wbqp::task("frame_position")]
impl Task for FramePosition {
    fn bind(&mut self, setup: &mut Setup<'_>) -> Result<Layout, BindError> {
        let frame = setup.frame(&self.frame)?;
        let axes = Axis::chosen(self.axes.as_deref())?;
        let n = axes.len();
        self.kp.validate("kp", n)?;
        self.kd.validate("kd", n)?;
        let home = setup.frame_at_home(&self.frame)?.p_WF;
        let home = Sample::at_rest(axes.iter().map(|axis| home[axis.index()]));
        self.sample = begin("reference", self.reference.as_mut(), Space::Vector(n), home)?;
        let layout = Layout::rows(axes.iter().map(|axis| (axis.name(), "m/s²")))
            .error_unit("m")
            .vdot_frame(frame, axes.iter().map(|axis| axis.index()));
        self.bound = Some((frame, axes));
        Ok(layout)
    }

    fn begin(&mut self, tick: &Tick<'_>) {
        if let Some((frame, axes)) = &self.bound {
            let p_WF = tick.frame(*frame).p_WF;
            let measured = axes.iter().map(|axis| p_WF[axis.index()]);
            begin_at(self.reference.as_mut(), &mut self.sample, measured);
        }
    }

    fn update(&mut self, tick: &Tick<'_>, rows: &mut Rows<'_>) {
        let Some((frame, axes)) = &self.bound else {
            return;
        };
        self.reference.sample(tick, &mut self.sample);
        let frame = tick.frame(*frame);
        for (k, axis) in axes.iter().enumerate() {
            let i = axis.index();
            let error = frame.p_WF[i] - component(&self.sample.value, k);
            let rate = frame.v_WF[i] - component(&self.sample.rate, k);
            rows.b()[k] = component(&self.sample.acceleration, k)
                - self.kd.axis(k) * rate
                - self.kp.axis(k) * error
                - frame.Jdot_v[i];
            rows.error()[k] = error;
        }
    }

    fn follow(&mut self) -> Option<ReferenceSlot<'_>> {
        let (_, axes) = self.bound.as_ref()?;
        Some(ReferenceSlot {
            reference: &mut self.reference,
            sample: &self.sample,
            space: Space::Vector(axes.len()),
        })
    }
}
