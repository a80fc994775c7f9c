//! What a URDF file says of links and joints, and where.
#![allow(non_snake_case)]

use wbqp::{
    model::Inertia,
    nalgebra::{Isometry3, Unit, Vector3},
};

/// The links and joints of a file, in its order.
pub(super) struct Description {
    pub(super) name: String,
    /// Byte offset of the element.
    pub(super) offset: usize,
    pub(super) links: Vec<Link>,
    pub(super) joints: Vec<Joint>,
}

/// A link.
pub(super) struct Link {
    pub(super) name: String,
    /// Byte offset of the element.
    pub(super) offset: usize,
    pub(super) inertial: Option<Inertial>,
    /// Whether it is not in the file, but between the motions of a planar joint.
    pub(super) is_between: bool,
}

/// What moves with a link.
#[derive(Clone, Copy)]
pub(super) struct Inertial {
    /// Byte offset of the element.
    pub(super) offset: usize,
    /// In the link's frame.
    pub(super) inertia: Inertia,
}

/// How a joint moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Fixed,
    Revolute,
    Continuous,
    Prismatic,
    /// In the plane that its axis is normal to, and about the axis; see [`planar`](super::planar).
    Planar,
    /// Any motion: a floating base written as a joint.
    Floating,
}

/// A joint and which links it names.
pub(super) struct Joint {
    pub(super) name: String,
    /// Byte offset of the element.
    pub(super) offset: usize,
    pub(super) kind: Kind,
    pub(super) parent: String,
    pub(super) child: String,
    /// Pose of the joint's frame in the parent link.
    pub(super) X_PJ: Isometry3<f64>,
    /// In the joint's frame.
    pub(super) axis: Unit<Vector3<f64>>,
    pub(super) limit: Limit,
    pub(super) damping: f64,
    pub(super) friction: f64,
    pub(super) mimic: Option<Mimic>,
    /// The planar joint that it is a part of.
    pub(super) part_of: Option<String>,
}

/// Limits as far as the file gives them; never NaN.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Limit {
    /// Byte offset of the element, or of the joint.
    pub(super) offset: usize,
    pub(super) lower: Option<f64>,
    pub(super) upper: Option<f64>,
    pub(super) velocity: Option<f64>,
    pub(super) effort: Option<f64>,
}

/// `<mimic>`: `q = multiplier × q_leader + offset`.
pub(super) struct Mimic {
    /// Byte offset of the element.
    pub(super) at: usize,
    pub(super) leader: String,
    pub(super) multiplier: f64,
    pub(super) offset: f64,
}

impl Link {
    /// As messages call it.
    pub(super) fn label(&self) -> String {
        format!("link `{}`", self.name)
    }
}

impl Joint {
    /// As messages call it.
    pub(super) fn label(&self) -> String {
        format!("joint `{}`", self.name)
    }

    /// Whether it has one degree of freedom.
    pub(super) fn is_simple(&self) -> bool {
        matches!(
            self.kind,
            Kind::Revolute | Kind::Continuous | Kind::Prismatic
        )
    }
}
