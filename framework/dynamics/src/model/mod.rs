//! The robot as a tree of rigid bodies: immutable, shared, validated when built.
//!
//! # Notation
//! Body `B` hangs on its parent body `P` by one joint. `X_PJ` places the joint frame `J` in `P`; the joint
//! turns or slides `B` along `axis` (unit vector in `J`, hence also in `B`), and `B = J` at `q = 0`. A named
//! frame `F` is fixed to a body by `X_BF`. World is `W`, z up; the base body's frame is `R`.
//!
//! A joint is a degree of freedom. A [`Mimic`] is a joint that is none: gears or a belt couple it to another, its
//! leader, by `q = multiplier × q_leader + offset`, so that both move with one velocity.
//!
//! Generalised velocity (floating base): `v = [v_WR; w_WR; q̇]`, linear first, of the origin of R, all in
//! world axes. A fixed base has `v = q̇`.
#![allow(non_snake_case)]

mod build;
mod error;
mod inertia;
mod mimic;

pub use build::ModelBuilder;
pub use error::ModelError;
pub use inertia::Inertia;
pub use mimic::Mimic;

use std::{collections::HashMap, ops::Index};

use nalgebra::{DVector, Isometry3, Unit, Vector3};

/// How the root body is attached to the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Base {
    /// Six free velocities: flying and legged robots.
    Floating,
    /// Bolted to the world at the pose given in the state.
    Fixed,
}

/// Index of a body; body 0 is the base.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct BodyId(pub(crate) u32);

/// Index of a joint, in the order of the velocity vector.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct JointId(pub(crate) u32);

/// Index of a named frame; frame 0 is the base's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct FrameId(pub(crate) u32);

/// Index of a component of the generalised velocity `v`, and of `v̇`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct VelocityId(pub(crate) u32);

macro_rules! index {
    ($($id:ident),*) => {$(
        impl $id {
            /// Of what stands at a position in the model's list.
            #[inline]
            pub fn new(index: usize) -> Self {
                Self(index as u32)
            }

            /// Position in the model's list.
            #[inline]
            pub fn index(self) -> usize {
                self.0 as usize
            }
        }
    )*};
}
index!(BodyId, JointId, FrameId, VelocityId);

impl Index<VelocityId> for DVector<f64> {
    type Output = f64;

    #[inline]
    fn index(&self, id: VelocityId) -> &f64 {
        &self[id.index()]
    }
}

/// What one degree of freedom does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// Rotation about the axis, rad; limits may be infinite (URDF `continuous`).
    Revolute,
    /// Translation along the axis, m.
    Prismatic,
}

/// Range, speed and effort that a joint can bear. Infinite where there is no limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLimits {
    /// Lowest position, rad or m.
    pub lower: f64,
    /// Highest position, rad or m.
    pub upper: f64,
    /// Largest speed, rad/s or m/s.
    pub velocity: f64,
    /// Largest torque or force, N·m or N.
    pub effort: f64,
}

/// One degree of freedom between a body and its parent.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Unique name.
    pub name: String,
    /// Rotation or translation.
    pub kind: JointKind,
    /// Unit axis in the joint frame.
    pub axis: Unit<Vector3<f64>>,
    /// Pose of the joint frame in the parent body.
    pub X_PJ: Isometry3<f64>,
    /// Position, speed and effort limits.
    pub limits: JointLimits,
    /// Viscous friction, N·m·s/rad or N·s/m. Not part of `h`; the plant applies it to torque-driven joints.
    pub damping: f64,
    /// Coulomb friction, N·m or N. Not part of `h`; the plant applies it to torque-driven joints.
    pub friction: f64,
    /// Rotor inertia seen at the joint (J_motor × gear²), kg·m² or kg; added to the diagonal of M.
    pub armature: f64,
}

/// What carries a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Carrier {
    /// Nothing, or the world: the base.
    Base,
    Joint(JointId),
    /// By index into [`Model::mimics`].
    Mimic(usize),
}

/// A rigid body and the joint that carries it (none for the base).
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Name of the link that gave the body its frame.
    pub name: String,
    /// Parent body; the base is its own parent.
    pub parent: BodyId,
    /// Mass, first moment and inertia about the body's origin, in body axes (merged fixed links included).
    pub inertia: Inertia,
    pub(crate) carrier: Carrier,
}

/// A named frame fixed to a body.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Unique name.
    pub name: String,
    /// The body it moves with.
    pub body: BodyId,
    /// Its pose in that body.
    pub X_BF: Isometry3<f64>,
}

/// An immutable rigid-body tree. Made by [`ModelBuilder`], which validates it; bodies are ordered so that a
/// parent comes before its children.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    name: String,
    base: Base,
    bodies: Vec<Body>,
    joints: Vec<Joint>,
    /// By joint.
    carried: Vec<BodyId>,
    mimics: Vec<Mimic>,
    frames: Vec<Frame>,
    gravity: Vector3<f64>,
    /// Of joints and frames, made when the tree is complete.
    names: Names,
}

/// Where names are: files ask for every joint and every frame by name.
#[derive(Clone, Debug, Default, PartialEq)]
struct Names {
    joints: HashMap<String, JointId>,
    frames: HashMap<String, FrameId>,
}

impl Model {
    /// The robot's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Floating or fixed.
    pub fn base(&self) -> Base {
        self.base
    }

    /// All bodies, the base first, parents before children.
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// All degrees of freedom beside a floating base; joint `i` owns velocity `joint_offset() + i`. Limits, damping,
    /// friction and armature are those of the joint with all mimic joints that follow it.
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// Joints that follow others.
    pub fn mimics(&self) -> &[Mimic] {
        &self.mimics
    }

    /// The body that a joint carries itself; the bodies of mimic joints move with it.
    pub fn body_of(&self, joint: JointId) -> BodyId {
        self.carried[joint.index()]
    }

    /// The joint whose motion moves a body relative to its parent, directly or as a mimic joint's leader; `None` for
    /// the base.
    pub fn joint_of(&self, body: BodyId) -> Option<JointId> {
        match self.bodies[body.index()].carrier {
            Carrier::Base => None,
            Carrier::Joint(joint) => Some(joint),
            Carrier::Mimic(index) => Some(self.mimics[index].leader),
        }
    }

    /// All named frames.
    pub fn frames(&self) -> &[Frame] {
        &self.frames
    }

    /// Gravity vector in world axes, m/s²; −9.81 z by default.
    pub fn gravity(&self) -> Vector3<f64> {
        self.gravity
    }

    /// Number of generalised velocities.
    pub fn nv(&self) -> usize {
        self.joint_offset() + self.joints.len()
    }

    /// Index of the first joint in `v`: 6 for a floating base, 0 for a fixed one.
    pub fn joint_offset(&self) -> usize {
        match self.base {
            Base::Floating => 6,
            Base::Fixed => 0,
        }
    }

    /// Where a joint's velocity is in `v`.
    pub fn velocity_index(&self, joint: JointId) -> VelocityId {
        VelocityId((self.joint_offset() + joint.index()) as u32)
    }

    /// Where the base's velocity is in `v`, linear first, if it has one.
    pub fn base_velocities(&self) -> Option<[VelocityId; 6]> {
        match self.base {
            Base::Floating => Some(std::array::from_fn(|i| VelocityId(i as u32))),
            Base::Fixed => None,
        }
    }

    /// Total mass, kg.
    pub fn mass(&self) -> f64 {
        self.bodies.iter().map(|b| b.inertia.mass).sum()
    }

    /// The joint of that name.
    pub fn joint(&self, name: &str) -> Option<JointId> {
        self.names.joints.get(name).copied()
    }

    /// The frame of that name.
    pub fn frame(&self, name: &str) -> Option<FrameId> {
        self.names.frames.get(name).copied()
    }

    /// Makes the index of names.
    fn index_names(&mut self) {
        let joints = (0..).map(JointId).zip(&self.joints);
        let frames = (0..).map(FrameId).zip(&self.frames);
        self.names = Names {
            joints: joints.map(|(id, joint)| (joint.name.clone(), id)).collect(),
            frames: frames.map(|(id, frame)| (frame.name.clone(), id)).collect(),
        };
    }

    /// The base's own frame R.
    pub fn base_frame(&self) -> FrameId {
        FrameId(0)
    }

    /// The body's identifier by position in [`Model::bodies`]; `None` beyond the end.
    pub fn body_id(&self, index: usize) -> Option<BodyId> {
        (index < self.bodies.len()).then_some(BodyId(index as u32))
    }

    /// The same tree with another named frame, at `X_FG` in the frame F that is there already.
    ///
    /// # Errors
    /// [`ModelError::Duplicate`] if a frame has that name; [`ModelError::Topology`] if F is not there, or a number is
    /// not finite.
    #[allow(non_snake_case)]
    pub fn with_frame(
        mut self,
        name: &str,
        frame: FrameId,
        X_FG: &Isometry3<f64>,
    ) -> Result<(Model, FrameId), ModelError> {
        if self.frame(name).is_some() {
            return Err(ModelError::Duplicate {
                kind: "frame",
                name: name.to_owned(),
            });
        }
        build::check_pose(name, X_FG)?;
        let Some(&Frame { body, X_BF, .. }) = self.frames.get(frame.index()) else {
            return Err(ModelError::Topology(format!(
                "frame `{name}` is to be in a frame that the model does not have"
            )));
        };
        let id = FrameId(self.frames.len() as u32);
        self.frames.push(Frame {
            name: name.to_owned(),
            body,
            X_BF: X_BF * X_FG,
        });
        self.names.frames.insert(name.to_owned(), id);
        Ok((self, id))
    }

    /// The same tree with other inertias: what a plant uses to differ from its controller.
    ///
    /// # Errors
    /// [`ModelError`] if an inertia is not physical any more.
    pub fn with_inertias(
        &self,
        mut change: impl FnMut(&Body) -> Inertia,
    ) -> Result<Model, ModelError> {
        let mut model = self.clone();
        for body in &mut model.bodies {
            let was_physical = body.inertia.validate(&body.name).is_ok();
            body.inertia = change(body);
            if was_physical {
                body.inertia.validate(&body.name)?;
            } else {
                body.inertia.check_numbers(&body.name)?;
            }
        }
        Ok(model)
    }
}
