//! Joint torques near a value.

use wbqp::{model::JointKind, prelude::*};

use crate::{
    effort::{Efforts, chosen},
    follow::stay,
};

/// Keeps joint torques near a value, by default near zero: the effort that other tasks leave open is then the
/// smallest, and a redundant robot has one solution.
///
/// One row per joint motor, N·m for a revolute joint, N for a prismatic one:
///
/// `τ = τ_d`.
///
/// Written as a task of small weight it is Tikhonov's regularisation of the torques; with `1/τ_max²` as the weight of
/// each row, shares of what the motors can bear are balanced.
///
/// Error: torque as sent last minus `τ_d`, N·m or N.
#[wbqp::task("joint_torque_regularisation")]
pub struct JointTorqueRegularisation {
    /// Which joints, by name; rows and reference are in this order. Default: all that have a motor, in the order of
    /// the actuators.
    pub joints: Option<Vec<String>>,
    /// The torques wanted: one per joint, N·m or N. Default: zero.
    #[wbqp(default = stay(), unit = "N·m or N")]
    pub reference: Box<dyn AnyReference>,
}

impl JointTorqueRegularisation {
    /// All motors, towards zero.
    pub fn new() -> Self {
        Self {
            joints: None,
            reference: stay(),
        }
    }

    /// Towards other torques: one per joint, N·m or N.
    pub fn following(mut self, reference: impl AnyReference) -> Self {
        self.reference = Box::new(reference);
        self
    }

    /// Only of these joints.
    pub fn only<S: Into<String>>(mut self, joints: impl IntoIterator<Item = S>) -> Self {
        self.joints = Some(joints.into_iter().map(Into::into).collect());
        self
    }
}

impl Default for JointTorqueRegularisation {
    fn default() -> Self {
        Self::new()
    }
}

impl Task for JointTorqueRegularisation {
    type Running = Efforts;

    fn bind(&self, setup: &mut Setup<'_>) -> Result<(Layout, Efforts), BindError> {
        let model = setup.model();
        let ids = || (0..model.joints().len()).filter_map(|i| model.joint(&model.joints()[i].name));
        let motor = |joint| setup.motor(joint).ok().map(|id| (joint, id));
        let mut motors = chosen(
            "joints",
            self.joints.as_deref(),
            || ids().filter_map(motor).collect(),
            |name| {
                let joint = setup.joint(name)?;
                motor(joint).ok_or_else(|| {
                    BindError::value("joints", format!("names `{name}`, which has no motor"))
                })
            },
        )?;
        if motors.is_empty() {
            return Err(BindError::Other(format!(
                "`{}` has no joint motor",
                model.name()
            )));
        }
        if self.joints.is_none() {
            motors.sort_by_key(|(_, id)| *id);
        }
        let turns = |kind| match kind {
            JointKind::Revolute => "N·m",
            JointKind::Prismatic => "N",
        };
        let units: Vec<_> = motors
            .iter()
            .map(|(joint, _)| turns(model.joints()[joint.index()].kind))
            .collect();
        let names = motors
            .iter()
            .map(|(joint, _)| model.joints()[joint.index()].name.as_str());
        let same = units.iter().all(|unit| *unit == units[0]);
        let layout = Layout::rows(names.zip(units.iter().copied()))
            .error_unit(if same { units[0] } else { "N·m or N" })
            .effort_unit(motors.iter().map(|(_, id)| *id));
        let indices = motors.into_iter().map(|(_, id)| id).collect();
        let efforts = Efforts::bind(setup, &*self.reference, indices)?;
        Ok((layout, efforts))
    }

    fn update(&self, efforts: &mut Efforts, tick: &Tick<'_>, rows: &mut Rows<'_>) {
        efforts.update(tick, rows);
    }

    fn remembered(&self, _: &mut Self::Running, _: &mut Remembered<'_>) {}
}
