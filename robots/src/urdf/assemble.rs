//! Builds the model from a file whose outline and tree have been checked.
//!
//! # Notation
//! A link `L` is merged into, or is, the body `B`; its frame is at `X_BL`. A joint's origin is `X_LJ`.
#![allow(non_snake_case)]

use wbqp::{
    model::{
        Base, BodyId, Inertia, Joint, JointKind, JointLimits, Model, ModelBuilder, ModelError,
    },
    nalgebra::{Isometry3, Matrix3, Translation3, Unit, UnitQuaternion, Vector3},
    robot::RobotError,
};

use super::{
    syntax::{self, Outline},
    tree::Tree,
};
use crate::{options::Options, source::Source};

/// Builds and validates the model.
pub(super) fn assemble(
    source: &Source<'_>,
    outline: &Outline,
    tree: &Tree,
    robot: &urdf_rs::Robot,
    options: &Options,
) -> Result<Model, RobotError> {
    let file = File {
        source,
        outline,
        tree,
        robot,
        options,
    };
    file.same_elements()?;
    let base = Base::from(options.base);
    let (root, root_inertia) = file.link(tree.root)?;
    if base == Base::Floating {
        file.root_has_mass()?;
    }
    let mut builder = ModelBuilder::new(
        &robot.name,
        base,
        &root.name,
        root_inertia.unwrap_or(Inertia::zero()),
    );

    // Depth first with the joints of a link in the file's order: a stack, filled backwards.
    let mut stack = Vec::new();
    file.push_joints(&mut stack, tree.root, builder.base(), Isometry3::identity());
    while let Some((j, B, X_BL)) = stack.pop() {
        let (place, joint, link) = file.joint(j)?;
        let X_BJ = X_BL * pose(&joint.origin);
        let (child, inertia) = file.link(link)?;
        if place.fixed {
            let inertia = inertia.unwrap_or(Inertia::zero());
            builder.weld(B, X_BJ, &child.name, &inertia);
            file.push_joints(&mut stack, link, B, X_BJ);
        } else {
            let Some(inertia) = inertia else {
                return source.refuse(
                    child.offset,
                    &child.label(),
                    format!(
                        "moves on joint `{}` but has no <inertial>; give it its mass and inertia",
                        place.name
                    ),
                );
            };
            let joint = file.moving_joint(place, joint, X_BJ)?;
            let body = builder.body(B, joint, &child.name, inertia);
            file.push_joints(&mut stack, link, body, Isometry3::identity());
        }
    }
    builder.build().map_err(|e| file.model_error(e))
}

struct File<'a> {
    source: &'a Source<'a>,
    outline: &'a Outline,
    tree: &'a Tree,
    robot: &'a urdf_rs::Robot,
    options: &'a Options,
}

impl File<'_> {
    /// Two parsers have read the text: refuse it if they do not see the same links and joints.
    fn same_elements(&self) -> Result<(), RobotError> {
        let links = self.outline.links.iter().map(|l| &l.name);
        let joints = self.outline.joints.iter().map(|j| &j.name);
        if links.eq(self.robot.links.iter().map(|l| &l.name))
            && joints.eq(self.robot.joints.iter().map(|j| &j.name))
        {
            return Ok(());
        }
        Err(RobotError::Syntax {
            place: self.source.place(0),
            what: "links and joints cannot be told apart: is it well-formed XML without entities of its own?"
                .into(),
        })
    }

    fn missing(&self) -> RobotError {
        RobotError::Syntax {
            place: self.source.place(0),
            what: "an element that was there is gone".into(),
        }
    }

    fn model_error(&self, source: ModelError) -> RobotError {
        RobotError::Model {
            file: self.source.file.to_owned(),
            source,
        }
    }

    /// A link's place and its inertia in its own frame, validated.
    fn link(&self, index: usize) -> Result<(&syntax::Link, Option<Inertia>), RobotError> {
        let pair = self
            .outline
            .links
            .get(index)
            .zip(self.robot.links.get(index));
        let (place, link) = pair.ok_or_else(|| self.missing())?;
        let Some(offset) = place.inertial else {
            return Ok((place, None));
        };
        let inertia = inertia(&link.inertial);
        match inertia.validate(&place.name) {
            Ok(()) => Ok((place, Some(inertia))),
            Err(ModelError::Inertia { what, .. }) => self.source.refuse(
                offset,
                &place.label(),
                format!("inertia {what}; no rigid body is like this"),
            ),
            Err(other) => Err(self.model_error(other)),
        }
    }

    /// A joint's place, its values and the link it carries.
    fn joint(&self, index: usize) -> Result<(&syntax::Joint, &urdf_rs::Joint, usize), RobotError> {
        let place = self.outline.joints.get(index);
        let joint = self.robot.joints.get(index);
        match (place, joint, self.tree.child.get(index)) {
            (Some(place), Some(joint), Some(&link)) => Ok((place, joint, link)),
            _ => Err(self.missing()),
        }
    }

    fn push_joints(
        &self,
        stack: &mut Vec<(usize, BodyId, Isometry3<f64>)>,
        link: usize,
        B: BodyId,
        X_BL: Isometry3<f64>,
    ) {
        if let Some(joints) = self.tree.children.get(link) {
            stack.extend(joints.iter().rev().map(|&j| (j, B, X_BL)));
        }
    }

    /// A floating root needs mass: its own, or that of the only link, fixed to it, that it carries.
    fn root_has_mass(&self) -> Result<(), RobotError> {
        let mut link = self.tree.root;
        loop {
            let (place, inertia) = self.link(link)?;
            if inertia.is_some() {
                return Ok(());
            }
            let only = match self.tree.children.get(link).map(Vec::as_slice) {
                Some(&[j]) => Some(self.joint(j)?),
                _ => None,
            };
            match only {
                Some((joint, _, child)) if joint.fixed => link = child,
                _ => {
                    return self.source.refuse(
                        place.offset,
                        &place.label(),
                        "is the floating base but has no <inertial>; give it its mass and inertia, \
                         or load the robot with a fixed base",
                    );
                }
            }
        }
    }

    fn moving_joint(
        &self,
        place: &syntax::Joint,
        joint: &urdf_rs::Joint,
        X_PJ: Isometry3<f64>,
    ) -> Result<Joint, RobotError> {
        let (kind, ranged) = match joint.joint_type {
            urdf_rs::JointType::Revolute => (JointKind::Revolute, true),
            urdf_rs::JointType::Continuous => (JointKind::Revolute, false),
            urdf_rs::JointType::Prismatic => (JointKind::Prismatic, true),
            _ => {
                return self
                    .source
                    .refuse(place.offset, &place.label(), "cannot move");
            }
        };
        let axis = Vector3::from(*joint.axis.xyz);
        // Scaled first: the squares of a tiny axis vanish.
        let Some(axis) = Unit::try_new(axis / axis.amax(), 0.0) else {
            return self
                .source
                .refuse(place.offset, &place.label(), "axis has no direction");
        };
        let limit = &joint.limit;
        let options = self.options;
        let limits = JointLimits {
            lower: if ranged {
                limit.lower
            } else {
                f64::NEG_INFINITY
            },
            upper: if ranged { limit.upper } else { f64::INFINITY },
            velocity: limit.velocity,
            effort: options
                .effort
                .get(&place.name)
                .copied()
                .unwrap_or(limit.effort),
        };
        let mut result = Joint::new(&place.name, kind, axis, X_PJ, limits);
        if let Some(dynamics) = &joint.dynamics
            && !options.ignore_joint_friction
        {
            result.damping = dynamics.damping;
            result.friction = dynamics.friction;
        }
        result.armature = options.armature.get(&place.name).copied().unwrap_or(0.0);
        Ok(result)
    }
}

fn inertia(inertial: &urdf_rs::Inertial) -> Inertia {
    let i = &inertial.inertia;
    let I_cm = Matrix3::new(
        i.ixx, i.ixy, i.ixz, //
        i.ixy, i.iyy, i.iyz, //
        i.ixz, i.iyz, i.izz,
    );
    Inertia::from_com(inertial.mass.value, Vector3::zeros(), I_cm)
        .transformed(&pose(&inertial.origin))
}

/// URDF's rpy are about fixed axes: x first, then y, then z.
fn pose(origin: &urdf_rs::Pose) -> Isometry3<f64> {
    let [roll, pitch, yaw] = *origin.rpy;
    let [x, y, z] = *origin.xyz;
    Isometry3::from_parts(
        Translation3::new(x, y, z),
        UnitQuaternion::from_euler_angles(roll, pitch, yaw),
    )
}
