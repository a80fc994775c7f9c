//! The pass from the base to the tips: pose, velocity, bias acceleration and world inertia of every body.
//!
//! # Notation
//! World axes. Body `B` hangs on parent `P`; `r` = `p_PB_W` is B's origin from P's origin; `S` is the joint's
//! axis as a unit motion of B (linear for a prismatic joint, angular for a revolute one, whose axis runs through
//! B's origin). Per body
//! ```text
//! V_B  = V_P at B + S q̇                          V = (v_WB; w_WB)
//! V̇_B = V̇_P at B + S q̈ + c                      V̇ = classical accelerations
//! c    = (w_P × (w_P × r) + 2 w_P × S_lin q̇ ;  w_P × S_ang q̇)
//! ```
//! (RBDA section 5.3 with classical accelerations; `c` is what q̈ = 0 and V̇_P = 0 leave.)
#![allow(non_snake_case)]

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

use super::{
    spatial_inertia::SpatialInertia,
    spatial_vector::{Force, Motion},
};
use crate::{
    elementary,
    model::{Carrier, Joint, JointKind, Model},
    state::State,
};

/// What is known of one body after the pass, and room for the passes that follow.
#[derive(Clone, Debug)]
pub(super) struct Link {
    /// Index of the parent; the base is its own.
    pub(super) parent: usize,
    /// Index in `v` of the velocity that moves the body relative to its parent; 0 for the base.
    pub(super) column: usize,
    pub(super) q_WB: UnitQuaternion<f64>,
    pub(super) R_WB: Matrix3<f64>,
    pub(super) p_WB: Vector3<f64>,
    /// `p_WB − p_WP`.
    pub(super) r: Vector3<f64>,
    /// Motion per unit of the joint's velocity: its axis; times the multiplier for a mimic joint.
    pub(super) S: Motion,
    /// Velocity of the joint, of a mimic joint's leader, rad/s or m/s.
    pub(super) qdot: f64,
    /// Rotor inertia at the joint, kg·m² or kg; a mimic joint's is in its leader's.
    pub(super) armature: f64,
    /// `(v_WB; w_WB)`.
    pub(super) V: Motion,
    /// Acceleration relative to the parent's with q̈ = 0.
    pub(super) c: Motion,
    /// Acceleration with v̇ = 0: `J̇v` of the body's origin.
    pub(super) bias: Motion,
    /// The body's own inertia.
    pub(super) inertia: SpatialInertia,
    /// The body's inertia with its subtree's, joints frozen (set by the mass matrix).
    pub(super) composite: SpatialInertia,
    /// Force through the joint, workspace of the Newton–Euler passes.
    pub(super) force: Force,
    /// Acceleration, workspace of inverse and forward dynamics.
    pub(super) acceleration: Motion,
}

impl Link {
    pub(super) fn new(parent: usize, column: usize, armature: f64) -> Self {
        Self {
            parent,
            column,
            q_WB: UnitQuaternion::identity(),
            R_WB: Matrix3::identity(),
            p_WB: Vector3::zeros(),
            r: Vector3::zeros(),
            S: Motion::zero(),
            qdot: 0.0,
            armature,
            V: Motion::zero(),
            c: Motion::zero(),
            bias: Motion::zero(),
            inertia: SpatialInertia::zero(),
            composite: SpatialInertia::zero(),
            force: Force::zero(),
            acceleration: Motion::zero(),
        }
    }

    /// Force on the body (about its origin) that gives it the acceleration `a`, gyroscopic terms included.
    pub(super) fn inertial_force(&self, a: &Motion) -> Force {
        self.inertia.times(a) + self.inertia.rotation_bias(&self.V.angular)
    }
}

/// The motion of the base alone.
fn place_base(link: &mut Link, model: &Model, state: &State) {
    link.q_WB = state.R_WR;
    link.R_WB = *link.q_WB.to_rotation_matrix().matrix();
    link.p_WB = state.p_WR;
    if model.joint_offset() == 6 {
        let v = &state.v;
        link.V = Motion {
            linear: Vector3::new(v[0], v[1], v[2]),
            angular: Vector3::new(v[3], v[4], v[5]),
        };
    }
}

/// The motion of a body from its parent's and its joint's. With `scale`, the body moves so much per unit of `qdot`.
fn place_child(
    link: &mut Link,
    parent: &Link,
    joint: &Joint,
    [q, qdot]: [f64; 2],
    scale: Option<f64>,
) {
    let q_WJ = parent.q_WB * joint.X_PJ.rotation;
    let r_J = parent.R_WB * joint.X_PJ.translation.vector;
    let axis = joint.axis.into_inner();
    match joint.kind {
        JointKind::Revolute => {
            let (sin, cos) = elementary::sin_cos(0.5 * q);
            let turn = Quaternion::from_parts(cos, axis * sin);
            link.q_WB = q_WJ * UnitQuaternion::new_unchecked(turn);
        }
        JointKind::Prismatic => link.q_WB = q_WJ,
    }
    link.R_WB = *link.q_WB.to_rotation_matrix().matrix();
    // Turning about it leaves the axis where it is.
    let axis = link.R_WB * axis;
    match joint.kind {
        JointKind::Revolute => {
            link.r = r_J;
            link.S.angular = axis;
        }
        JointKind::Prismatic => {
            link.r = r_J + axis * q;
            link.S.linear = axis;
        }
    }
    if let Some(scale) = scale {
        link.S = link.S * scale;
    }
    link.p_WB = parent.p_WB + link.r;
    link.qdot = qdot;

    let w = &parent.V.angular;
    let relative = link.S * qdot;
    link.V = parent.V.at_child(&link.r) + relative;
    link.c = Motion {
        linear: w.cross(&(w.cross(&link.r) + relative.linear * 2.0)),
        angular: w.cross(&relative.angular),
    };
    link.bias = parent.bias.at_child(&link.r) + link.c;
}

/// Runs the pass over all links (parents come before children).
pub(super) fn forward_pass(links: &mut [Link], model: &Model, state: &State) {
    debug_assert!(state.fits(model), "state and model differ in size");
    let offset = model.joint_offset();
    for (i, body) in model.bodies().iter().enumerate() {
        let (before, after) = links.split_at_mut(i);
        let link = &mut after[0];
        if i == 0 {
            place_base(link, model, state);
        } else {
            let parent = &before[link.parent];
            let qdot = state.v[link.column];
            let q = state.q[link.column - offset];
            match body.carrier {
                Carrier::Base => {}
                Carrier::Joint(joint) => {
                    let joint = &model.joints()[joint.index()];
                    place_child(link, parent, joint, [q, qdot], None);
                }
                Carrier::Mimic(index) => {
                    let mimic = &model.mimics()[index];
                    let q = mimic.multiplier * q + mimic.offset;
                    let scale = Some(mimic.multiplier);
                    place_child(link, parent, &mimic.joint, [q, qdot], scale);
                }
            }
        }
        link.inertia = SpatialInertia::of_body(&body.inertia, &link.R_WB);
    }
}
