//! A robot as plain data: what a program has that reads another format.
//!
//! ```toml
//! [robot]
//! type = "tree"
//! name = "pendulum"
//! base = "fixed"
//!
//! [[robot.body]]
//! name = "stand"
//!
//! [[robot.body]]
//! name = "rod"
//! parent = "stand"
//! position = [0.0, 0.0, 1.0]
//! mass = 0.5
//! com = [0.0, 0.0, -0.2]
//! moments = [0.02, 0.02, 0.001]
//! joint = { name = "swing", type = "revolute", axis = [0.0, 1.0, 0.0] }
//!
//! [[robot.motor]]
//! name = "swing"
//! joint = "swing"
//! limits = [-2.0, 2.0]
//! ```
#![allow(non_snake_case)]

mod actuators;
mod bodies;

use std::{collections::BTreeMap, path::Path};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use wbqp::{
    dynamics::Data,
    model::Model,
    nalgebra::{Isometry3, Quaternion, UnitQuaternion},
    robot::{Robot, RobotError, RobotModel},
    serde_json::{self, Value},
    state::State,
    suggestion::suggestion,
};

use crate::{BaseKind, size};

/// A robot as plain data, for programs that read other formats: bodies, joints, frames, motors and rotors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Tree {
    /// The robot's name.
    pub name: String,
    /// `"floating"` or `"fixed"`.
    #[serde(default)]
    pub base: BaseKind,
    /// Gravity in world axes, m/s².
    #[serde(default = "gravity")]
    pub gravity: [f64; 3],
    /// Bodies, the base first, parents before children. One without a joint is part of its parent.
    #[serde(rename = "body")]
    pub bodies: Vec<TreeBody>,
    /// Further named frames; every body is one.
    #[serde(default, rename = "frame", skip_serializing_if = "Vec::is_empty")]
    pub frames: Vec<TreeFrame>,
    /// Rotors, the first of the actuators. Their thrusts may change at any rate: there is no `slew`.
    #[serde(default, rename = "rotor", skip_serializing_if = "Vec::is_empty")]
    pub rotors: Vec<TreeRotor>,
    /// Motors of joints; a joint without one is passive.
    #[serde(default, rename = "motor", skip_serializing_if = "Vec::is_empty")]
    pub motors: Vec<TreeMotor>,
    /// The home posture.
    #[serde(default)]
    pub home: TreeHome,
}

/// A rigid body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TreeBody {
    /// Unique name; a frame is called so too.
    pub name: String,
    /// The body that carries it; nothing for the base.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parent: Option<String>,
    /// Where its frame is in its parent with the joint at zero, m; not of the base.
    #[serde(default)]
    pub position: [f64; 3],
    /// Orientation of its frame in its parent with the joint at zero, w-x-y-z; not of the base.
    #[serde(default = "identity")]
    pub quaternion: [f64; 4],
    /// kg.
    #[serde(default)]
    pub mass: f64,
    /// Centre of mass in its frame, m.
    #[serde(default)]
    pub com: [f64; 3],
    /// Moments of inertia about the centre of mass along the axes of its frame, `[ixx, iyy, izz]`, kg·m².
    #[serde(default)]
    pub moments: [f64; 3],
    /// Products of inertia about the centre of mass, `[ixy, ixz, iyz]`, kg·m².
    #[serde(default)]
    pub products: [f64; 3],
    /// How it moves.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joint: Option<TreeJoint>,
}

/// A joint between a body and its parent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TreeJoint {
    /// Unique name.
    pub name: String,
    /// `"revolute"` or `"prismatic"`.
    #[serde(default, rename = "type")]
    pub kind: TreeJointKind,
    /// Direction in the body's frame, any length.
    pub axis: [f64; 3],
    /// A point of a revolute joint's axis in the body's frame, m.
    #[serde(default)]
    pub anchor: [f64; 3],
    /// Lowest and highest position, rad or m.
    #[serde(default = "unlimited")]
    pub range: [f64; 2],
    /// Largest speed, rad/s or m/s.
    #[serde(default = "never")]
    pub velocity: f64,
    /// Largest effort, N·m or N.
    #[serde(default = "never")]
    pub effort: f64,
    /// Inertia of the motor seen at the joint, kg·m² or kg.
    #[serde(default)]
    pub armature: f64,
    /// Viscous friction, N·m·s/rad or N·s/m; the plant has it.
    #[serde(default)]
    pub damping: f64,
    /// Coulomb friction, N·m or N; the plant has it.
    #[serde(default)]
    pub friction: f64,
    /// The joint that it follows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub follows: Option<TreeCoupling>,
}

/// The kinds of joints.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TreeJointKind {
    /// Turns about its axis.
    #[default]
    Revolute,
    /// Slides along its axis.
    Prismatic,
}

/// How a joint follows another: `q = multiplier × q_joint + offset`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TreeCoupling {
    /// The other joint.
    pub joint: String,
    /// How far this one moves per unit of the other's motion; not zero.
    #[serde(default = "one")]
    pub multiplier: f64,
    /// Where this one is with the other at zero, rad or m.
    #[serde(default)]
    pub offset: f64,
}

/// A named frame on a body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TreeFrame {
    /// Unique among frames and bodies.
    pub name: String,
    /// The body that carries it.
    pub body: String,
    /// Its origin in the body's frame, m.
    #[serde(default)]
    pub position: [f64; 3],
    /// Its orientation in the body's frame, w-x-y-z.
    #[serde(default = "identity")]
    pub quaternion: [f64; 4],
}

/// A rotor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TreeRotor {
    /// Unique among the actuators.
    pub name: String,
    /// The frame in which it is, thrust along +z.
    pub frame: String,
    /// Least and largest thrust, N.
    pub thrust: [f64; 2],
    /// Reaction torque along the frame's z per newton of thrust, m; its sign is the torque's.
    #[serde(default)]
    pub moment: f64,
    /// Thrust per squared speed, N/(rad/s)²: the speed follows from it that is commanded beside a thrust and logged;
    /// the optimum does not depend on it.
    #[serde(default = "one")]
    pub thrust_coefficient: f64,
    /// First-order lags of a rising and a falling thrust, s; the plant alone has them.
    #[serde(default = "lags")]
    pub time_constant: [f64; 2],
}

/// A motor of a joint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TreeMotor {
    /// Unique among the actuators.
    pub name: String,
    /// The joint that it drives.
    pub joint: String,
    /// Least and largest effort, N·m or N, as far as the joint's `effort` allows.
    #[serde(default = "unlimited")]
    pub limits: [f64; 2],
    /// `"torque"`, or `"velocity"` for a joint with a velocity servo.
    #[serde(default)]
    pub drive: TreeDrive,
}

/// What a motor is commanded with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TreeDrive {
    /// An effort.
    #[default]
    Torque,
    /// A velocity.
    Velocity,
}

/// Where the robot is at home.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TreeHome {
    /// Of the base, m, world; where its contacts have it if this is not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position: Option<[f64; 3]>,
    /// Of the base, w-x-y-z.
    #[serde(default = "identity")]
    pub quaternion: [f64; 4],
    /// Joints that are not at zero, rad or m.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub joints: BTreeMap<String, f64>,
}

impl Default for TreeHome {
    fn default() -> Self {
        Self {
            position: None,
            quaternion: identity(),
            joints: BTreeMap::new(),
        }
    }
}

fn gravity() -> [f64; 3] {
    [0.0, 0.0, -9.81]
}
fn identity() -> [f64; 4] {
    [1.0, 0.0, 0.0, 0.0]
}
fn unlimited() -> [f64; 2] {
    [f64::NEG_INFINITY, f64::INFINITY]
}
fn never() -> f64 {
    f64::INFINITY
}
fn one() -> f64 {
    1.0
}
fn lags() -> [f64; 2] {
    [0.02, 0.02]
}

#[wbqp::robot("tree")]
impl Robot for Tree {
    fn load(&self, _: &Path) -> Result<RobotModel, RobotError> {
        self.check_numbers()?;
        let model = self.model()?;
        size::check(&model).map_err(|what| self.refuse("body", what))?;
        let home = self.home_of(&model)?;
        let mut data = Data::new(&model);
        data.update(&model, &home);
        if data.mass_matrix().clone().cholesky().is_none() {
            return Err(self.refuse(
                "body",
                "the mass matrix at home is not positive definite: a joint moves nothing, give it an `armature`",
            ));
        }
        let mut robot = RobotModel::new(model, Vec::new(), home);
        robot.base_is_placed = self.home.position.is_some() || self.base == BaseKind::Fixed;
        robot.actuators = self.actuators(&robot.model)?;
        Ok(robot)
    }
}

impl Tree {
    fn refuse(&self, element: &str, what: impl Into<String>) -> RobotError {
        RobotError::Option {
            option: format!("robot `{}`: {element}", self.name),
            what: what.into(),
        }
    }

    /// Refuses numbers that no robot has.
    fn check_numbers(&self) -> Result<(), RobotError> {
        // As JSON, to look at all of them by their keys; what is not finite is null there, and checked elsewhere.
        let data = serde_json::to_value(self).unwrap_or_default();
        too_large("", &data).map_or(Ok(()), |(element, number)| {
            let most = size::LARGEST_NUMBER;
            let what = format!(
                "has {number:e}, must be at most {most:e} (SI units); leave out what has no limit"
            );
            Err(self.refuse(&element, what))
        })
    }

    fn home_of(&self, model: &Model) -> Result<State, RobotError> {
        let mut state = State::neutral(model);
        let at = self.home.position.unwrap_or_default();
        let pose = self.pose("home", at, self.home.quaternion)?;
        state.p_WR = pose.translation.vector;
        state.R_WR = pose.rotation;
        for (joint, q) in model.joints().iter().zip(state.q.iter_mut()) {
            *q = q.clamp(joint.limits.lower, joint.limits.upper);
        }
        for (name, position) in &self.home.joints {
            // Joints that follow others have no position of their own.
            if model.mimics().iter().any(|m| m.joint.name == *name) {
                continue;
            }
            let Some(joint) = model.joint(name) else {
                return Err(self.refuse("home.joints", Self::unknown_joint(model, name)));
            };
            state.q[joint.index()] = *position;
        }
        Ok(state)
    }

    fn unknown_joint(model: &Model, name: &str) -> String {
        let known: Vec<&str> = model.joints().iter().map(|j| j.name.as_str()).collect();
        format!(
            "there is no joint `{name}` that moves by itself{}",
            suggestion(name, &known)
        )
    }

    fn pose(
        &self,
        element: &str,
        position: [f64; 3],
        [w, x, y, z]: [f64; 4],
    ) -> Result<Isometry3<f64>, RobotError> {
        let rotation = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-9)
            .filter(|q| q.coords.iter().all(|x| x.is_finite()));
        let rotation = rotation.ok_or_else(|| {
            self.refuse(
                element,
                "`quaternion` needs four finite numbers, not all zero",
            )
        })?;
        Ok(Isometry3::from_parts(position.into(), rotation))
    }
}

/// The first number that is too large, with the key or the entry that has it.
fn too_large(path: &str, value: &Value) -> Option<(String, f64)> {
    match value {
        Value::Number(number) => {
            let number = number.as_f64().filter(|x| x.abs() > size::LARGEST_NUMBER);
            number.map(|number| (path.to_owned(), number))
        }
        Value::Array(values) => values.iter().find_map(|value| too_large(path, value)),
        Value::Object(keys) => {
            let name = keys.get("name").and_then(Value::as_str);
            let entry = name.filter(|_| !path.is_empty());
            let entry = entry.map_or(path.to_owned(), |name| format!("{path} `{name}`"));
            let join = |key| if entry.is_empty() { String::new() } else { format!("{entry}: ") } + key;
            keys.iter()
                .find_map(|(key, value)| too_large(&join(key), value))
        }
        _ => None,
    }
}
