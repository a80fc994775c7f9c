//! Mass matrix, gravity vector and centre-of-mass Jacobian from composite inertias.
//!
//! # Notation
//! `I_c` is the inertia of a body with its whole subtree about the body's origin. `F = I_c S` is the force that
//! a unit acceleration of the joint needs. Composite-rigid-body algorithm: RBDA sections 6.2 and 9.3.
#![allow(non_snake_case)]

use nalgebra::{DMatrix, DVector, Matrix3xX, Vector3};

use super::{
    kinematics::Link,
    spatial_vector::{Force, Motion},
};

/// Sums the inertias from the tips to the base into `Link::composite`.
pub(super) fn composite_inertias(links: &mut [Link]) {
    for link in links.iter_mut() {
        link.composite = link.inertia;
    }
    for i in (1..links.len()).rev() {
        let (before, after) = links.split_at_mut(i);
        let link = &after[0];
        before[link.parent]
            .composite
            .add_child(&link.composite, &link.r);
    }
}

/// Writes `M` (nv × nv), `g` (nv) and `J_com` (3 × nv), of which the entries that the tree leaves zero are zero
/// already. Needs the composite inertias.
pub(super) fn mass_matrix(
    links: &[Link],
    gravity: &Vector3<f64>,
    offset: usize,
    M: &mut DMatrix<f64>,
    g: &mut DVector<f64>,
    J_com: &mut Matrix3xX<f64>,
) {
    let total = links[0].composite.m;
    let weightless = Motion {
        linear: -gravity,
        angular: Vector3::zeros(),
    };
    for i in (1..links.len()).rev() {
        let link = &links[i];
        let column = link.column;
        let mut F = link.composite.times(&link.S);
        M[(column, column)] = link.S.dot(&F) + link.armature;
        g[column] = weightless.dot(&F);
        J_com.set_column(column, &(F.linear / total));

        let mut j = i;
        loop {
            F = F.at_parent(&links[j].r);
            j = links[j].parent;
            if j == 0 {
                break;
            }
            let row = links[j].column;
            let value = links[j].S.dot(&F);
            M[(row, column)] = value;
            M[(column, row)] = value;
        }
        if offset == 6 {
            couple_to_base(M, column, &F);
        }
    }
    if offset == 6 {
        base_block(&links[0], &weightless, M, g, J_com);
    }
}

/// The same where several bodies move with one velocity: `Gᵀ M G`, `Gᵀ g` and `J_com G` are sums over bodies.
pub(super) fn coupled_mass_matrix(
    links: &[Link],
    gravity: &Vector3<f64>,
    offset: usize,
    M: &mut DMatrix<f64>,
    g: &mut DVector<f64>,
    J_com: &mut Matrix3xX<f64>,
) {
    let total = links[0].composite.m;
    let weightless = Motion {
        linear: -gravity,
        angular: Vector3::zeros(),
    };
    M.fill(0.0);
    g.fill(0.0);
    J_com.fill(0.0);
    for i in (1..links.len()).rev() {
        let link = &links[i];
        let column = link.column;
        let mut F = link.composite.times(&link.S);
        M[(column, column)] += link.S.dot(&F) + link.armature;
        g[column] += weightless.dot(&F);
        let mut share = J_com.column_mut(column);
        share += F.linear / total;

        let mut j = i;
        loop {
            F = F.at_parent(&links[j].r);
            j = links[j].parent;
            if j == 0 {
                break;
            }
            // For the same column, both triangles are one entry.
            let row = links[j].column;
            let value = links[j].S.dot(&F);
            M[(row, column)] += value;
            M[(column, row)] += value;
        }
        if offset == 6 {
            for k in 0..3 {
                M[(k, column)] += F.linear[k];
                M[(column, k)] += F.linear[k];
                M[(3 + k, column)] += F.angular[k];
                M[(column, 3 + k)] += F.angular[k];
            }
        }
    }
    if offset == 6 {
        base_block(&links[0], &weightless, M, g, J_com);
    }
}

/// Writes the six base rows of one joint's column, and their mirror.
fn couple_to_base(M: &mut DMatrix<f64>, column: usize, F: &Force) {
    for k in 0..3 {
        M[(k, column)] = F.linear[k];
        M[(column, k)] = F.linear[k];
        M[(3 + k, column)] = F.angular[k];
        M[(column, 3 + k)] = F.angular[k];
    }
}

/// Writes the 6 × 6 block of the whole robot as one rigid body, and the base's part of `g` and `J_com`.
fn base_block(
    base: &Link,
    weightless: &Motion,
    M: &mut DMatrix<f64>,
    g: &mut DVector<f64>,
    J_com: &mut Matrix3xX<f64>,
) {
    let whole = &base.composite;
    let S_h = crate::spatial::skew(&whole.h);
    let weight = whole.times(weightless);
    for a in 0..3 {
        g[a] = weight.linear[a];
        g[3 + a] = weight.angular[a];
        for b in 0..3 {
            let unit = if a == b { 1.0 } else { 0.0 };
            M[(a, b)] = unit * whole.m;
            M[(a, 3 + b)] = -S_h[(a, b)];
            M[(3 + a, b)] = S_h[(a, b)];
            // One triangle, so that M is symmetric to the last bit.
            M[(3 + a, 3 + b)] = whole.I[(a.min(b), a.max(b))];
            J_com[(a, b)] = unit;
            J_com[(a, 3 + b)] = -S_h[(a, b)] / whole.m;
        }
    }
}
