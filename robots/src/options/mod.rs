//! What neither the URDF nor the rotor parameter file says.

mod inertia;
mod joints;
mod pattern;

pub use inertia::LinkInertia;
pub(crate) use joints::JointOptions;
pub(crate) use pattern::Names;

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use wbqp::{model::Base, robot::RobotError};

/// How a robot's files are to be understood. The default is a floating base with every joint driven by
/// torque and every number as in the files.
///
/// Joints and links are named as in the URDF, or by a regular expression that matches whole names, such as
/// `gripper_.*`. A name counts before an expression. What matches nothing is refused, and so are expressions that
/// disagree.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Options {
    /// Whether the root link floats or is bolted to the world.
    pub base: BaseKind,
    /// Refuse what the format or physics do not allow, instead of repairing it with a diagnostic.
    pub strict: bool,
    /// The link that is the base, instead of the one that no joint carries: the joints between the two are turned
    /// round.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub root: Option<String>,
    /// Joints with a position or velocity servo: commanded with a velocity, not with a torque.
    pub servo: Vec<String>,
    /// Joints without a motor: no actuator.
    pub passive: Vec<String>,
    /// Joints that are frozen at their home position: what they carry becomes one body with what carries them.
    pub lock: Vec<String>,
    /// What becomes of joints with `<mimic>`; those that are not listed are coupled.
    pub mimic: BTreeMap<String, MimicKind>,
    /// Home position per joint, rad or m. A joint that is not listed is where `state` says, else at 0, or at the limit
    /// nearest to 0.
    #[schemars(extend("x-unit" = "rad or m"))]
    pub home: BTreeMap<String, f64>,
    /// Group state of the SRDF file that is the home posture.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub state: Option<String>,
    /// Where a floating base's origin is at home, or where a fixed base is bolted, m, world. By default a state of the
    /// SRDF file says, or the `<origin>` of a floating joint; else a floating base stands on the contacts that are on
    /// at the start, and any other is at the origin.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "m"))]
    pub position: Option<[f64; 3]>,
    /// Range per joint, `[lower, upper]`, rad or m, instead of the URDF's.
    #[schemars(extend("x-unit" = "rad or m"))]
    pub range: BTreeMap<String, [f64; 2]>,
    /// Velocity limit per joint, rad/s or m/s, instead of the URDF's.
    #[schemars(extend("x-unit" = "rad/s or m/s"))]
    pub velocity: BTreeMap<String, f64>,
    /// Effort limit per joint, N·m or N, instead of the URDF's.
    #[schemars(extend("x-unit" = "N·m or N"))]
    pub effort: BTreeMap<String, f64>,
    /// Rotor inertia seen at the joint (J_motor × gear²), kg·m² or kg. URDF has no place for it.
    #[schemars(extend("x-unit" = "kg·m² or kg"))]
    pub armature: BTreeMap<String, f64>,
    /// Viscous friction per joint, N·m·s/rad or N·s/m, instead of the URDF's; for the plant.
    #[schemars(extend("x-unit" = "N·m·s/rad or N·s/m"))]
    pub damping: BTreeMap<String, f64>,
    /// Coulomb friction per joint, N·m or N, instead of the URDF's; for the plant.
    #[schemars(extend("x-unit" = "N·m or N"))]
    pub friction: BTreeMap<String, f64>,
    /// Mass, centre of mass and rotational inertia per link, instead of the URDF's.
    pub inertia: BTreeMap<String, LinkInertia>,
    /// Largest thrust of every rotor, N, instead of the rotor parameter file's.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-unit" = "N"))]
    pub thrust_max: Option<f64>,
    /// Drop the URDF's joint damping and friction, which are often dummies that keep a simulator stable.
    pub ignore_joint_friction: bool,
}

/// How the root link is attached to the world.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum BaseKind {
    /// Flying and legged robots.
    #[default]
    Floating,
    /// Bolted to the world.
    Fixed,
}

/// What becomes of a joint with `<mimic>`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum MimicKind {
    /// It follows its leader: one velocity and one motor for both.
    #[default]
    Couple,
    /// It moves on its own.
    Free,
    /// It is frozen where it is with its leader at home.
    Lock,
}

impl From<BaseKind> for Base {
    fn from(kind: BaseKind) -> Self {
        match kind {
            BaseKind::Floating => Base::Floating,
            BaseKind::Fixed => Base::Fixed,
        }
    }
}

pub(crate) fn refuse(option: &str, what: String) -> RobotError {
    RobotError::Option {
        option: option.to_owned(),
        what,
    }
}
