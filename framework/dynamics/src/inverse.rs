//! Newton–Euler: generalised forces from accelerations.
//!
//! # Notation
//! World axes; every force is taken about its own body's origin. Recursive Newton–Euler algorithm: RBDA
//! sections 5.3 and 9.5.
#![allow(non_snake_case)]

use nalgebra::{DVector, Vector3};

use super::{Data, Wrenches, data::Columns, kinematics::Link, spatial_vector::Motion};
use crate::model::Model;

/// Generalised force (N, N·m; size nv) that gives the acceleration `vdot` under the given external wrenches:
/// `τ = M v̇ + h − Σ Jᵀ f`.
///
/// * `data`: after [`Data::update_kinematics`] or [`Data::update`] for the state in question;
/// * `vdot`: `[classical acceleration of R's origin; ẇ_WR; q̈]`, world axes, m/s² and rad/s², size nv;
/// * `wrenches`: what the environment does to each body;
/// * `out`: `[force on the base; moment about R's origin; joint efforts]`, world axes, size nv.
pub fn inverse_dynamics(
    model: &Model,
    data: &mut Data,
    vdot: &DVector<f64>,
    wrenches: &Wrenches,
    out: &mut DVector<f64>,
) {
    let offset = model.joint_offset();
    let columns = data.columns;
    let links = &mut data.links;
    // Gravity acts as an upward acceleration of the world.
    let mut base = Motion {
        linear: -model.gravity(),
        angular: Vector3::zeros(),
    };
    if offset == 6 {
        base.linear += Vector3::new(vdot[0], vdot[1], vdot[2]);
        base.angular += Vector3::new(vdot[3], vdot[4], vdot[5]);
    }
    for i in 0..links.len() {
        let acceleration = if i == 0 {
            base
        } else {
            let (before, after) = links.split_at(i);
            let link = &after[0];
            let parent = &before[link.parent].acceleration;
            parent.at_child(&link.r) + link.c + link.S * vdot[link.column]
        };
        let link = &mut links[i];
        link.acceleration = acceleration;
        link.force = link.inertial_force(&acceleration) - wrenches.on(i);
    }
    forces_to_base(links, offset, columns, out);
    for link in links.iter().skip(1) {
        out[link.column] += link.armature * vdot[link.column];
    }
}

/// Coriolis and centrifugal forces: `out` ← `h(q, v)` without gravity. Leaves the force that `v̇ = 0` needs at
/// the base in `links[0].force`.
pub(super) fn velocity_forces(
    links: &mut [Link],
    offset: usize,
    columns: Columns,
    out: &mut DVector<f64>,
) {
    for link in links.iter_mut() {
        link.force = link.inertial_force(&link.bias);
    }
    forces_to_base(links, offset, columns, out);
}

/// Carries `Link::force` from the tips to the base and writes its component along every axis.
fn forces_to_base(links: &mut [Link], offset: usize, columns: Columns, out: &mut DVector<f64>) {
    if columns == Columns::Shared {
        out.fill(0.0);
    }
    for i in (1..links.len()).rev() {
        let (before, after) = links.split_at_mut(i);
        let link = &after[0];
        let effort = link.S.dot(&link.force);
        match columns {
            Columns::Own => out[link.column] = effort,
            Columns::Shared => out[link.column] += effort,
        }
        before[link.parent].force += link.force.at_parent(&link.r);
    }
    if offset == 6 {
        let base = &links[0].force;
        for k in 0..3 {
            out[k] = base.linear[k];
            out[3 + k] = base.angular[k];
        }
    }
}
