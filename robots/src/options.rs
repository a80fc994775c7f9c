//! What neither the URDF nor the rotor side-car says.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use wbqp::{
    model::{Base, Model},
    robot::RobotError,
    suggestion::suggestion,
};

/// How a robot's files are to be understood. The default is a floating base with every joint driven by
/// torque and every number as in the files.
///
/// Joints are named as in the URDF; a name that it does not have is refused.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Options {
    /// Whether the root link floats or is bolted to the world.
    pub base: BaseKind,
    /// Joints with a position or velocity servo: commanded with a velocity, not with a torque.
    pub servo: Vec<String>,
    /// Joints without a motor: no actuator.
    pub passive: Vec<String>,
    /// Home position per joint, rad or m. A joint that is not listed is at 0, or at the limit nearest to 0.
    #[schemars(extend("x-unit" = "rad or m"))]
    pub home: BTreeMap<String, f64>,
    /// Effort limit per joint, N·m or N, instead of the URDF's.
    #[schemars(extend("x-unit" = "N·m or N"))]
    pub effort: BTreeMap<String, f64>,
    /// Rotor inertia seen at the joint (J_motor × gear²), kg·m² or kg. URDF has no place for it.
    #[schemars(extend("x-unit" = "kg·m² or kg"))]
    pub armature: BTreeMap<String, f64>,
    /// Largest thrust of every rotor, N, instead of the side-car's.
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

impl From<BaseKind> for Base {
    fn from(kind: BaseKind) -> Self {
        match kind {
            BaseKind::Floating => Base::Floating,
            BaseKind::Fixed => Base::Fixed,
        }
    }
}

impl Options {
    /// Refuses names that are not joints of `model`, and values that no joint can have.
    pub(crate) fn check(&self, model: &Model) -> Result<(), RobotError> {
        let lists = [("servo", &self.servo), ("passive", &self.passive)];
        let tables = [
            ("home", &self.home),
            ("effort", &self.effort),
            ("armature", &self.armature),
        ];
        for (option, list) in lists {
            for name in list {
                joint(model, option, name)?;
            }
        }
        for (option, table) in tables {
            for name in table.keys() {
                joint(model, option, name)?;
            }
        }
        if let Some(both) = self.servo.iter().find(|name| self.passive.contains(name)) {
            return refuse(
                "passive",
                format!("joint `{both}` is also in `servo`; a passive joint has no motor"),
            );
        }
        for (name, &position) in &self.home {
            let limits = joint(model, "home", name)?.limits;
            if !position.is_finite() || position < limits.lower || position > limits.upper {
                return refuse(
                    "home",
                    format!(
                        "joint `{name}` at {position} is outside its range {} to {}",
                        limits.lower, limits.upper
                    ),
                );
            }
        }
        Ok(())
    }

    /// Refuses numbers that the model would take without knowing the option they came from.
    pub(crate) fn check_numbers(&self) -> Result<(), RobotError> {
        for (name, &effort) in &self.effort {
            if effort.is_nan() || effort <= 0.0 {
                return refuse(
                    "effort",
                    format!(
                        "joint `{name}`: {effort} must be positive; list a joint without a motor in `passive`"
                    ),
                );
            }
        }
        for (name, &armature) in &self.armature {
            if !armature.is_finite() || armature < 0.0 {
                return refuse(
                    "armature",
                    format!("joint `{name}`: {armature} must be finite and not negative"),
                );
            }
        }
        Ok(())
    }
}

fn refuse<T>(option: &str, what: String) -> Result<T, RobotError> {
    Err(RobotError::Option {
        option: option.to_owned(),
        what,
    })
}

fn joint<'a>(
    model: &'a Model,
    option: &str,
    name: &str,
) -> Result<&'a wbqp::model::Joint, RobotError> {
    let joints = model.joints();
    if let Some(joint) = joints.iter().find(|j| j.name == name) {
        return Ok(joint);
    }
    let known: Vec<&str> = joints.iter().map(|j| j.name.as_str()).collect();
    let hint = suggestion(name, &known);
    let robot = model.name();
    refuse(
        option,
        format!("robot `{robot}` has no moving joint `{name}`{hint}"),
    )
}
