//! Builds the model from a description, its tree and how its joints move.
//!
//! # Notation
//! A link `L` is merged into, or is, the body `B`; its frame is at `X_BL`. A joint's frame is `J`, at `X_PJ` in its
//! parent link P; with the joint at `q` its child C is at `X_PC = X_PJ exp(S q)`. A joint that is gone through from
//! child to parent has its frame in C, the axis `−S`, and carries P at `X_JP = X_PJ⁻¹`.
#![allow(non_snake_case)]

use wbqp::{
    model::{Base, BodyId, Inertia, Joint, JointKind, Model, ModelBuilder},
    nalgebra::{Isometry3, Unit, Vector3},
    robot::RobotError,
};

use super::{
    description::{Description, Kind},
    findings::{At, Findings},
    motion::{Motion, Motions},
    tree::{Edge, Tree},
};
use crate::{options::Options, size};

/// The model, and what its bodies are made of.
pub(super) struct Assembled {
    pub(super) model: Model,
    /// By body, the links that were merged into it, its own first.
    pub(super) links: Vec<Vec<usize>>,
}

/// Builds the model. `inertias` are by link, in the link's frame. What cannot be goes to `findings`.
pub(super) fn assemble(
    description: &Description,
    tree: &Tree,
    motions: &Motions<'_>,
    inertias: &[Inertia],
    options: &Options,
    findings: &mut Findings<'_>,
) -> Result<Option<Assembled>, RobotError> {
    let root = &description.links[tree.root];
    let base = Base::from(options.base);
    let mut assembly = Assembly {
        description,
        motions,
        inertias,
        options,
        builder: ModelBuilder::new(&description.name, base, &root.name, inertias[tree.root]),
        links: vec![vec![tree.root]],
    };
    // Depth first with the joints of a link in the file's order: a stack, filled backwards.
    let mut stack = Vec::new();
    let mut complete = true;
    let push = |stack: &mut Vec<_>, link: usize, body: BodyId, X_BL: Isometry3<f64>| {
        stack.extend(
            tree.edges[link]
                .iter()
                .rev()
                .map(|&edge| (edge, body, X_BL)),
        );
    };
    push(
        &mut stack,
        tree.root,
        assembly.builder.base(),
        Isometry3::identity(),
    );
    while let Some((edge, body, X_BL)) = stack.pop() {
        match assembly.add(edge, body, X_BL, findings) {
            Some((body, X_BL)) => push(&mut stack, edge.link, body, X_BL),
            None => complete = false,
        }
    }
    if !complete {
        return Ok(None);
    }
    let Assembly { builder, links, .. } = assembly;
    let model = if findings.is_strict() {
        builder.build()
    } else {
        builder.build_with_any_inertia()
    };
    let model = model.map_err(|source| RobotError::Model {
        file: findings.source.file.to_owned(),
        source,
    })?;
    size::check(&model).map_err(|what| RobotError::Syntax {
        place: findings.source.place(description.offset),
        what: format!("robot `{}` {what}", model.name()),
    })?;
    Ok(Some(Assembled { model, links }))
}

struct Assembly<'a> {
    description: &'a Description,
    motions: &'a Motions<'a>,
    inertias: &'a [Inertia],
    options: &'a Options,
    builder: ModelBuilder,
    /// By body.
    links: Vec<Vec<usize>>,
}

impl Assembly<'_> {
    /// Adds the link that an edge leads to: the body that it is, or was merged into, and where in it.
    fn add(
        &mut self,
        edge: Edge,
        parent: BodyId,
        X_BL: Isometry3<f64>,
        findings: &mut Findings<'_>,
    ) -> Option<(BodyId, Isometry3<f64>)> {
        let joint = &self.description.joints[edge.joint];
        let inertia = self.inertias[edge.link];
        let name = &self.description.links[edge.link].name;
        let label = joint.label();
        let at = At {
            offset: joint.offset,
            element: &label,
        };
        if joint.kind == Kind::Floating {
            findings.refuse(
                at,
                "type `floating` is supported for the joint between the world and a floating base alone; the model \
                 has one floating base: load each part as a robot of its own",
            );
            return None;
        }
        let leader = match &self.motions.of_joint[edge.joint] {
            Motion::Rigid { q } => {
                let X_PC = joint.X_PJ * joint.displacement(*q);
                let X_BM = X_BL
                    * if edge.is_reversed {
                        X_PC.inverse()
                    } else {
                        X_PC
                    };
                self.builder.weld(parent, X_BM, name, &inertia);
                if let Some(links) = self.links.get_mut(parent.index()) {
                    links.push(edge.link);
                }
                return Some((parent, X_BM));
            }
            Motion::Free => None,
            Motion::Follows {
                leader,
                multiplier,
                offset,
            } => Some((leader.as_str(), [*multiplier, *offset])),
        };
        let (X_BJ, axis, X_JL) = if edge.is_reversed {
            (X_BL, -joint.axis, joint.X_PJ.inverse())
        } else {
            (X_BL * joint.X_PJ, joint.axis, Isometry3::identity())
        };
        let moving = self.moving_joint(edge.joint, axis, X_BJ);
        let body = if edge.is_reversed {
            self.builder
                .body_at(parent, moving, leader, X_JL, name, &inertia)
        } else {
            match leader {
                None => self.builder.body(parent, moving, name, inertia),
                Some((leader, relation)) => self
                    .builder
                    .mimic_body(parent, moving, leader, relation, name, inertia),
            }
        };
        self.links.push(vec![edge.link]);
        Some((body, X_JL))
    }

    fn moving_joint(&self, index: usize, axis: Unit<Vector3<f64>>, X_BJ: Isometry3<f64>) -> Joint {
        let joint = &self.description.joints[index];
        let kind = match joint.kind {
            Kind::Prismatic => JointKind::Prismatic,
            _ => JointKind::Revolute,
        };
        let mut result = Joint::new(&joint.name, kind, axis, X_BJ, self.motions.limits(index));
        let options = self.motions.options(index);
        if !self.options.ignore_joint_friction {
            result.damping = joint.damping;
            result.friction = joint.friction;
        }
        if let Some(options) = options {
            result.damping = options.damping.unwrap_or(result.damping);
            result.friction = options.friction.unwrap_or(result.friction);
            result.armature = options.armature.unwrap_or(0.0);
        }
        result
    }
}
