//! What a check shows, as data: the JSON is this, and the text is made from it.

use std::path::Path;

use serde::Serialize;
use wbqp::{
    actuator::{Actuator, ActuatorKind, Drive},
    controller::Memory,
    dynamics::{Data, frame_motion},
    model::{Base, BodyId, Frame, Joint, JointId, JointKind, Model},
    robot::{Diagnostic, RobotModel},
};

use super::holding::Holding;
use crate::subject::Subject;

/// A file and what is in it. Lengths in m, angles in rad, masses in kg; a limit that there is not is absent.
#[derive(Clone, Debug, Serialize)]
pub struct Examination {
    /// The file, as given.
    pub file: String,
    /// What it is; `null` if that cannot be told.
    pub kind: Option<Subject>,
    /// The robot; absent if it was refused.
    #[serde(flatten)]
    pub robot: Option<Robot>,
    /// The controller of the file, of a scenario's first case; absent for a robot alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub controller: Option<ControllerFacts>,
    /// What the problem of a tick takes; absent if it was not known before something was refused.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub memory: Option<Memory>,
    /// What the robot's actuators do at home; absent if the controller was refused.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub holding: Option<Holding>,
    /// Why no controller can be made for a robot that loads.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub remark: Option<String>,
    /// What of a scenario's case is taken and can hardly be meant, a line each.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
    /// Why it was refused, a line each; empty if it loads.
    pub errors: Vec<String>,
    /// Why the controller does not work where it begins, a line each: its first tick is not optimal, it does not stand,
    /// or something is missing to hover. Empty if it does, and for a robot alone.
    pub faults: Vec<String>,
}

impl Examination {
    /// Of a file of which nothing is known yet.
    pub(super) fn new(file: &Path, kind: Option<Subject>) -> Self {
        Self {
            file: file.display().to_string(),
            kind,
            robot: None,
            controller: None,
            memory: None,
            holding: None,
            remark: None,
            warnings: Vec::new(),
            errors: Vec::new(),
            faults: Vec::new(),
        }
    }
}

/// A robot as it was loaded.
#[derive(Clone, Debug, Serialize)]
pub struct Robot {
    /// Its name.
    pub name: String,
    /// `floating` or `fixed`.
    pub base: &'static str,
    /// Generalised velocities: degrees of freedom.
    pub nv: usize,
    /// Actuators.
    pub nu: usize,
    /// kg.
    pub total_mass: f64,
    /// What the loader noticed, and did about it.
    pub diagnostics: Vec<Diagnostic>,
    /// Parents before children, the base first.
    pub bodies: Vec<BodyFacts>,
    /// In the order of the velocity vector.
    pub joints: Vec<JointFacts>,
    /// Joints that follow others.
    pub mimics: Vec<MimicFacts>,
    /// Everything that tasks and contacts can name.
    pub frames: Vec<FrameFacts>,
    /// In the order of `u`.
    pub actuators: Vec<ActuatorFacts>,
}

/// A rigid body with everything that is fixed to it.
#[derive(Clone, Debug, Serialize)]
pub struct BodyFacts {
    /// The link that gave it its name.
    pub name: String,
    /// The body that carries it.
    pub parent: Option<String>,
    /// The joint that carries it.
    pub joint: Option<String>,
    /// kg, links that are fixed to it included.
    pub mass: f64,
    /// m, body axes.
    pub center_of_mass: [f64; 3],
    /// Links that were merged into it, and other frames on it.
    pub merged: Vec<String>,
}

/// A degree of freedom.
#[derive(Clone, Debug, Serialize)]
pub struct JointFacts {
    /// Its name.
    pub name: String,
    /// `revolute` or `prismatic`.
    pub kind: &'static str,
    /// Of its position: `rad` or `m`.
    pub unit: &'static str,
    /// The body that it carries.
    pub body: String,
    /// Range.
    pub lower: Option<f64>,
    /// Range.
    pub upper: Option<f64>,
    /// rad/s or m/s.
    pub velocity: Option<f64>,
    /// N·m or N.
    pub effort: Option<f64>,
    /// kg·m² or kg.
    pub armature: f64,
    /// N·m·s/rad or N·s/m.
    pub damping: f64,
    /// N·m or N.
    pub friction: f64,
    /// Position at home.
    pub home: f64,
    /// Whether no actuator drives it.
    pub passive: bool,
}

/// A joint that follows another: `q = multiplier × q_leader + offset`.
#[derive(Clone, Debug, Serialize)]
pub struct MimicFacts {
    /// Its name.
    pub name: String,
    /// The body that it carries.
    pub body: String,
    /// The joint that it follows.
    pub leader: String,
    /// Its motion per unit of the leader's.
    pub multiplier: f64,
    /// Where it is with the leader at zero, rad or m.
    pub offset: f64,
}

/// A frame that can be named.
#[derive(Clone, Debug, Serialize)]
pub struct FrameFacts {
    /// Its name.
    pub name: String,
    /// The body that it moves with.
    pub body: String,
    /// Its origin with the robot at home, m, world.
    pub position: [f64; 3],
    /// Roll, pitch, yaw of its axes with the robot at home, rad, world.
    pub rpy: [f64; 3],
}

/// An actuator.
#[derive(Clone, Debug, Serialize)]
pub struct ActuatorFacts {
    /// Its name.
    pub name: String,
    /// `torque`, `servo` (commanded with a velocity) or `rotor`.
    pub kind: &'static str,
    /// Of its effort: `N·m` or `N`.
    pub unit: &'static str,
    /// Least effort.
    pub lower: Option<f64>,
    /// Largest effort.
    pub upper: Option<f64>,
}

/// What a controller's file has.
#[derive(Clone, Debug, Serialize)]
pub struct ControllerFacts {
    /// Hz.
    pub rate: f64,
    /// Names.
    pub contacts: Vec<String>,
    /// Names.
    pub tasks: Vec<String>,
    /// Names.
    pub constraints: Vec<String>,
    /// The scenario's; empty if the file is a controller's.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub cases: Vec<String>,
}

fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}

impl Robot {
    /// Everything that a robot has.
    pub fn new(robot: &RobotModel) -> Self {
        let model = &robot.model;
        let joints = model.joints().iter().enumerate();
        Self {
            name: model.name().to_owned(),
            base: match model.base() {
                Base::Floating => "floating",
                Base::Fixed => "fixed",
            },
            nv: model.nv(),
            nu: robot.nu(),
            total_mass: model.mass(),
            diagnostics: robot.diagnostics.clone(),
            bodies: BodyFacts::all(model),
            joints: joints
                .map(|(i, joint)| JointFacts::new(robot, i, joint))
                .collect(),
            mimics: model
                .mimics()
                .iter()
                .map(|mimic| MimicFacts {
                    name: mimic.joint.name.clone(),
                    body: body_name(model, mimic.body),
                    leader: leader(model, mimic.leader),
                    multiplier: mimic.multiplier,
                    offset: mimic.offset,
                })
                .collect(),
            frames: FrameFacts::all(robot),
            actuators: robot
                .actuators
                .iter()
                .map(|a| ActuatorFacts::new(model, a))
                .collect(),
        }
    }
}

fn body_name(model: &Model, body: BodyId) -> String {
    let body = model.bodies().get(body.index());
    body.map(|b| b.name.clone()).unwrap_or_default()
}

fn leader(model: &Model, joint: JointId) -> String {
    let joint = model.joints().get(joint.index());
    joint.map(|j| j.name.clone()).unwrap_or_default()
}

impl BodyFacts {
    /// In the model's order.
    fn all(model: &Model) -> Vec<Self> {
        let bodies = model.bodies().iter().enumerate();
        let mut all: Vec<Self> = bodies
            .map(|(index, body)| {
                let parent = model.bodies().get(body.parent.index());
                Self {
                    name: body.name.clone(),
                    parent: parent.filter(|_| index > 0).map(|p| p.name.clone()),
                    joint: None,
                    mass: body.inertia.mass,
                    center_of_mass: body.inertia.com().into(),
                    merged: Vec::new(),
                }
            })
            .collect();
        let mimics = model.mimics().iter().map(|m| (m.body, &m.joint));
        let joints = model.joints().iter().filter_map(|joint| {
            let id = model.joint(&joint.name)?;
            Some((model.body_of(id), joint))
        });
        for (body, joint) in mimics.chain(joints) {
            if let Some(facts) = all.get_mut(body.index()) {
                facts.joint = Some(joint.name.clone());
            }
        }
        for frame in model.frames() {
            if let Some(facts) = all.get_mut(frame.body.index())
                && facts.name != frame.name
            {
                facts.merged.push(frame.name.clone());
            }
        }
        all
    }
}

impl JointFacts {
    fn new(robot: &RobotModel, index: usize, joint: &Joint) -> Self {
        let (kind, unit) = match joint.kind {
            JointKind::Revolute => ("revolute", "rad"),
            JointKind::Prismatic => ("prismatic", "m"),
        };
        let model = &robot.model;
        let id = model.joint(&joint.name);
        Self {
            name: joint.name.clone(),
            kind,
            unit,
            body: id
                .map(|id| body_name(model, model.body_of(id)))
                .unwrap_or_default(),
            lower: finite(joint.limits.lower),
            upper: finite(joint.limits.upper),
            velocity: finite(joint.limits.velocity),
            effort: finite(joint.limits.effort),
            armature: joint.armature,
            damping: joint.damping,
            friction: joint.friction,
            home: robot.home.q.get(index).copied().unwrap_or_default(),
            passive: id.is_none_or(|id| robot.joint_actuator(id).is_none()),
        }
    }
}

impl FrameFacts {
    /// In the model's order, with the robot at its home.
    pub(super) fn all(robot: &RobotModel) -> Vec<Self> {
        let model = &robot.model;
        let mut data = Data::new(model);
        data.update(model, &robot.home);
        let frames = model.frames().iter();
        let of = |frame: &Frame| {
            let motion = frame_motion(model, &data, model.frame(&frame.name)?);
            let (roll, pitch, yaw) = motion.R_WF.euler_angles();
            Some(Self {
                name: frame.name.clone(),
                body: body_name(model, frame.body),
                position: motion.p_WF.into(),
                rpy: [roll, pitch, yaw],
            })
        };
        frames.filter_map(of).collect()
    }
}

impl ActuatorFacts {
    fn new(model: &Model, actuator: &Actuator) -> Self {
        let kind = match &actuator.kind {
            ActuatorKind::Joint(motor) => match motor.drive {
                Drive::Torque => "torque",
                Drive::Velocity => "servo",
            },
            ActuatorKind::Rotor(_) => "rotor",
        };
        Self {
            name: actuator.name.clone(),
            kind,
            unit: effort_unit(model, actuator),
            lower: finite(actuator.lower),
            upper: finite(actuator.upper),
        }
    }
}

/// `N·m`, or `N` for a rotor and a joint that slides.
pub fn effort_unit(model: &Model, actuator: &Actuator) -> &'static str {
    match &actuator.kind {
        ActuatorKind::Joint(motor) => match model.joints().get(motor.joint.index()) {
            Some(joint) if joint.kind == JointKind::Prismatic => "N",
            _ => "N·m",
        },
        ActuatorKind::Rotor(_) => "N",
    }
}
