//! Joint positions (q_A).

use wbqp::{
    error::BindError,
    model::{JointId, JointKind},
    plugin::{
        Layout, AnyReference, Rows, Sample, Setup, Space, Task, Tick,
        reference::{ReferenceSlot, begin, begin_at},
    },
    schemars::JsonSchema,
    serde::{Deserialize, Serialize},
};

use crate::{
    follow::{component, stay},
    gain::Gain,
};

/// Moves joints, the paper's q_A.
///
/// Third row of (11), one row per joint, rad/s² or m/s²:
///
/// `q̈ = q̈_d − K_D (q̇ − q̇_d) − K_P (q − q_d)`.
///
/// Error: `q − q_d`, rad or m.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(crate = "wbqp::serde", deny_unknown_fields)]
#[schemars(crate = "wbqp::schemars", extend("x-weight" = 0.01))]
pub struct Posture {
    /// Stiffness `K_P`, 1/s²: one number, or one per joint.
    #[schemars(extend("x-unit" = "1/s²"))]
    pub kp: Gain,
    /// Damping `K_D`, 1/s: one number, or one per joint. Default: critical, `2 √K_P`.
    #[schemars(extend("x-unit" = "1/s", "x-critical" = "kp"))]
    pub kd: Gain,
    /// Which joints, by name; rows, gains and reference are in this order. Default: all, in the model's order.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joints: Option<Vec<String>>,
    /// Where to go: one position per joint, rad or m. Default: hold what is measured at the start.
    #[serde(default = "stay")]
    #[schemars(extend("x-unit" = "rad or m"))]
    pub reference: Box<dyn AnyReference>,
    #[serde(skip)]
    sample: Sample,
    #[serde(skip)]
    moved: Vec<JointId>,
}

impl Posture {
    /// Holds all joints where they are at the start with these gains (1/s², 1/s).
    pub fn new(kp: impl Into<Gain>, kd: impl Into<Gain>) -> Self {
        Self {
            kp: kp.into(),
            kd: kd.into(),
            joints: None,
            reference: stay(),
            sample: Sample::default(),
            moved: Vec::new(),
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

#[wbqp::task("posture")]
impl Task for Posture {
    fn bind(&mut self, setup: &mut Setup<'_>) -> Result<Layout, BindError> {
        let moved = self.resolve(setup)?;
        let n = moved.len();
        self.kp.validate("kp", n)?;
        self.kd.validate("kd", n)?;
        let home = &setup.robot().home.q;
        let home = Sample::at_rest(moved.iter().map(|j| home[j.index()]));
        self.sample = begin("reference", self.reference.as_mut(), Space::Vector(n), home)?;
        self.moved = moved;

        let model = setup.model();
        let joints = || self.moved.iter().map(|j| &model.joints()[j.index()]);
        let turns = joints().filter(|j| j.kind == JointKind::Revolute).count();
        let error_unit = match turns {
            0 => "m",
            k if k == n => "rad",
            _ => "rad or m",
        };
        let rows = joints().map(|joint| match joint.kind {
            JointKind::Revolute => (joint.name.as_str(), "rad/s²"),
            JointKind::Prismatic => (joint.name.as_str(), "m/s²"),
        });
        Ok(Layout::rows(rows)
            .error_unit(error_unit)
            .vdot_unit(self.moved.iter().map(|&j| model.velocity_index(j))))
    }

    fn begin(&mut self, tick: &Tick<'_>) {
        let measured = self.moved.iter().map(|joint| tick.state.q[joint.index()]);
        begin_at(self.reference.as_mut(), &mut self.sample, measured);
    }

    fn update(&mut self, tick: &Tick<'_>, rows: &mut Rows<'_>) {
        self.reference.sample(tick, &mut self.sample);
        for (k, &joint) in self.moved.iter().enumerate() {
            let q = tick.state.q[joint.index()];
            let rate = tick.state.v[tick.model.velocity_index(joint)];
            let error = q - component(&self.sample.value, k);
            rows.b()[k] = component(&self.sample.acceleration, k)
                - self.kd.axis(k) * (rate - component(&self.sample.rate, k))
                - self.kp.axis(k) * error;
            rows.error()[k] = error;
        }
    }

    fn follow(&mut self) -> Option<ReferenceSlot<'_>> {
        Some(ReferenceSlot {
            reference: &mut self.reference,
            sample: &self.sample,
            space: Space::Vector(self.moved.len()),
        })
    }
}
