//! Forward dynamics of a floating robot whose joints all follow given accelerations.
//!
//! # Notation
//! World axes, about each body's origin. With its joints prescribed a subtree is one rigid body of inertia `(m, h, I)`
//! (RBDA section 2.13) that its own joints shake: it takes the force `f = I_C a + p` to give its root body the
//! acceleration `a`, where `p` is what velocities, joints and external wrenches ask for at `a = 0`. So the base alone
//! is unknown: six equations, of which the three of the angular acceleration are left once the linear one is
//! eliminated,
//! ```text
//! (I − (h·h 1 − h hᵀ)/m) α = n − h × f/m,   a = (f − α × h)/m
//! ```
#![allow(non_snake_case)]

use nalgebra::{DVector, Matrix3, Vector3};

use super::{
    Data, JointDrive, Wrenches,
    data::Columns,
    forward_dynamics,
    spatial_inertia::SpatialInertia,
    spatial_vector::{Force, Motion},
};
use crate::model::Model;

/// Like [`forward_dynamics`], to rounding, and quicker where the base floats and every joint's acceleration is given.
///
/// Arguments, results and units are the same.
pub fn forward_dynamics_of_servos(
    model: &Model,
    data: &mut Data,
    drives: &[JointDrive],
    wrenches: &Wrenches,
    vdot: &mut DVector<f64>,
    effort: &mut DVector<f64>,
) {
    let is_prescribed = |drive: &JointDrive| matches!(drive, JointDrive::Acceleration(_));
    if model.joint_offset() != 6
        || data.columns == Columns::Shared
        || !drives.iter().all(is_prescribed)
    {
        forward_dynamics(model, data, drives, wrenches, vdot, effort);
        return;
    }
    shake(data, drives, wrenches, vdot);
    let base = &data.links[0];
    // Accelerations are relative to free fall.
    let Motion { linear, angular } = solve(&base.composite, &(base.force * -1.0));
    let gravity = model.gravity();
    for k in 0..3 {
        vdot[k] = linear[k] + gravity[k];
        vdot[3 + k] = angular[k];
    }
    let origin = base.p_WB;
    let base = Motion { linear, angular };
    for (i, link) in data.links.iter().enumerate().skip(1) {
        let carried = base.at_child(&(link.p_WB - origin));
        let force = link.force + link.composite.times(&carried);
        effort[i - 1] = link.S.dot(&force) + link.armature * vdot[6 + i - 1];
    }
}

/// Accelerations with the base's at zero on the way out, the forces that they take and inertias of subtrees on the way
/// back.
fn shake(data: &mut Data, drives: &[JointDrive], wrenches: &Wrenches, vdot: &mut DVector<f64>) {
    let links = &mut data.links;
    for i in 0..links.len() {
        let (before, after) = links.split_at_mut(i);
        let link = &mut after[0];
        link.composite = link.inertia;
        let centrifugal = link.inertia.rotation_bias(&link.V.angular) - wrenches.on(i);
        let Some(parent) = before.get(link.parent) else {
            link.acceleration = Motion::zero();
            link.force = centrifugal;
            continue;
        };
        let qddot = match drives[i - 1] {
            JointDrive::Acceleration(qddot) => qddot,
            JointDrive::Effort(_) => f64::NAN,
        };
        vdot[6 + i - 1] = qddot;
        link.acceleration = parent.acceleration.at_child(&link.r) + link.c + link.S * qddot;
        link.force = link.inertia.times(&link.acceleration) + centrifugal;
    }
    for i in (1..links.len()).rev() {
        let (before, after) = links.split_at_mut(i);
        let link = &after[0];
        let parent = &mut before[link.parent];
        parent.composite.add_child(&link.composite, &link.r);
        parent.force += link.force.at_parent(&link.r);
    }
}

/// The acceleration that a force gives to a rigid body at rest; not finite if the inertia is not.
fn solve(inertia: &SpatialInertia, force: &Force) -> Motion {
    let SpatialInertia { m, h, I } = inertia;
    let c = h / *m;
    let about_com: Matrix3<f64> = I - Matrix3::from_diagonal_element(c.dot(h)) + c * h.transpose();
    let moment = force.angular - c.cross(&force.linear);
    let angular = solve_symmetric(&about_com, &moment);
    Motion {
        linear: force.linear / *m - angular.cross(&c),
        angular,
    }
}

/// By the Cholesky factor of a symmetric positive definite matrix; not finite of another one.
fn solve_symmetric(A: &Matrix3<f64>, b: &Vector3<f64>) -> Vector3<f64> {
    let d0 = A.m11;
    let (l10, l20) = (A.m21 / d0, A.m31 / d0);
    let d1 = A.m22 - l10 * A.m21;
    let t = A.m32 - l20 * A.m21;
    let l21 = t / d1;
    let d2 = A.m33 - l20 * A.m31 - l21 * t;
    if !(d0 > 0.0 && d1 > 0.0 && d2 > 0.0) {
        return Vector3::repeat(f64::NAN);
    }
    let y1 = b.y - l10 * b.x;
    let y2 = b.z - l20 * b.x - l21 * y1;
    let z = y2 / d2;
    let y = y1 / d1 - l21 * z;
    let x = b.x / d0 - l10 * y - l20 * z;
    Vector3::new(x, y, z)
}
