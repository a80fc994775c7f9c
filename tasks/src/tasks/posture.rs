//! Joint positions (q_A).

use wbqp::{model::JointKind, plugin::VectorReference, prelude::*};

use crate::follow::stay;

/// Moves joints, the paper's q_A.
///
/// Third row of (11), one row per joint, rad/s² or m/s²:
///
/// `q̈ = q̈_d − K_D (q̇ − q̇_d) − K_P (q − q_d)`.
///
/// Error: `q − q_d`, rad or m.
#[wbqp::task("posture", weight = 0.01)]
pub struct Posture {
    /// Stiffness `K_P`, 1/s²: one number, or one per joint.
    #[wbqp(unit = "1/s²")]
    pub kp: PerRow,
    /// Damping `K_D`, 1/s: one number, or one per joint. Default: critical, `2 √K_P`.
    #[wbqp(unit = "1/s", critical = "kp")]
    pub kd: PerRow,
    /// Which joints, by name; rows, gains and reference are in this order. Default: all, in the model's order.
    pub joints: Option<Vec<String>>,
    /// Where to go: one position per joint, rad or m. Default: hold what is measured at the start.
    #[wbqp(default = stay(), unit = "rad or m")]
    pub reference: Box<dyn AnyReference>,
}

impl Posture {
    /// Holds all joints where they are at the start with these gains (1/s², 1/s).
    pub fn new(kp: impl Into<PerRow>, kd: impl Into<PerRow>) -> Self {
        Self {
            kp: kp.into(),
            kd: kd.into(),
            joints: None,
            reference: stay(),
        }
    }

    /// Follows a trajectory: one position per joint, rad or m.
    pub fn following(mut self, reference: impl AnyReference) -> Self {
        self.reference = Box::new(reference);
        self
    }

    /// Moves only these joints.
    pub fn only<S: Into<String>>(mut self, joints: impl IntoIterator<Item = S>) -> Self {
        self.joints = Some(joints.into_iter().map(Into::into).collect());
        self
    }

    fn resolve(&self, setup: &Setup<'_>) -> Result<Vec<JointId>, BindError> {
        let model = setup.model();
        let all = || model.joints().iter().map(|j| j.name.as_str()).collect();
        let names: Vec<&str> = match &self.joints {
            Some(names) => names.iter().map(String::as_str).collect(),
            None => all(),
        };
        if names.is_empty() {
            return Err(match self.joints {
                Some(_) => BindError::length("joints", 0, "at least one"),
                None => BindError::Other(format!("`{}` has no joints", model.name())),
            });
        }
        if let Some(i) = (0..names.len()).find(|&i| names[..i].contains(&names[i])) {
            let problem = format!("names `{}` twice", names[i]);
            return Err(BindError::value("joints", problem));
        }
        names.into_iter().map(|name| setup.joint(name)).collect()
    }
}

/// What runs of a [`Posture`].
#[derive(Debug)]
pub struct RunningPosture {
    joints: Vec<(JointId, VelocityId)>,
    reference: VectorReference,
}

impl Task for Posture {
    type Running = RunningPosture;

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(Layout, RunningPosture), BindError> {
        let moved = self.resolve(setup)?;
        let n = moved.len();
        self.kp.validate("kp", n)?;
        self.kd.validate("kd", n)?;
        let joints: Vec<_> = moved.iter().map(|&j| (j, setup.velocity(j))).collect();

        let model = setup.model();
        let kinds = || moved.iter().map(|j| &model.joints()[j.index()]);
        let turns = kinds().filter(|j| j.kind == JointKind::Revolute).count();
        let error_unit = match turns {
            0 => "m",
            k if k == n => "rad",
            _ => "rad or m",
        };
        let rows = kinds().map(|joint| match joint.kind {
            JointKind::Revolute => (joint.name.as_str(), "rad/s²"),
            JointKind::Prismatic => (joint.name.as_str(), "m/s²"),
        });
        let layout = Layout::rows(rows)
            .error_unit(error_unit)
            .vdot_unit(joints.iter().map(|(_, velocity)| *velocity));

        let measured = move |tick: &Tick<'_>, out: &mut [f64]| {
            for (out, joint) in out.iter_mut().zip(&moved) {
                *out = tick.state.q[joint.index()];
            }
        };
        let reference = setup.follow_vector("reference", &*self.reference, n, measured)?;
        Ok((layout, RunningPosture { joints, reference }))
    }

    fn update(&self, running: &mut RunningPosture, tick: &Tick<'_>, rows: &mut Rows<'_>) {
        let desired = tick.vector(running.reference);
        for (k, &(joint, velocity)) in running.joints.iter().enumerate() {
            let [value, rate, acceleration] = desired.component(k);
            rows.motion(
                k,
                MotionRow {
                    error: tick.state.q[joint.index()] - value,
                    rate: tick.state.v[velocity] - rate,
                    acceleration,
                    kp: self.kp.row(k),
                    kd: self.kd.row(k),
                },
            );
        }
    }

    fn remembered(&self, _: &mut Self::Running, _: &mut Remembered<'_>) {}
}
