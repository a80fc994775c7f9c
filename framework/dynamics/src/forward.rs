//! Forward dynamics of the plant: the hybrid articulated-body algorithm.
//!
//! # Notation
//! World axes, about each body's origin. Seen through its joint, a subtree answers an acceleration `a` of its
//! root body with the force `f = I_A a + p_A` (`I_A` articulated inertia, `p_A` articulated bias force).
//! `U = I_A S`, `D = Sᵀ U + armature`. RBDA sections 7.3 (articulated bodies), 9.2 (hybrid dynamics: some
//! joints with given effort, some with given acceleration) and 9.4 (floating base). With mimic joints, which are loops
//! of the mechanism, the mass matrix is factorised instead.
#![allow(non_snake_case)]

use nalgebra::{DVector, Matrix3, Matrix6, Vector3, Vector6};

use super::{
    Data, Wrenches, coupled,
    data::Columns,
    spatial_inertia::SpatialInertia,
    spatial_vector::{Force, Motion},
};
use crate::{model::Model, spatial::skew};

/// What drives one joint of the plant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum JointDrive {
    /// Effort of the motor net of friction, N·m or N.
    Effort(f64),
    /// Acceleration enforced by a servo whatever effort it takes, rad/s² or m/s².
    Acceleration(f64),
}

/// Symmetric 6 × 6 inertia in blocks: `[f; n] = [ll, la; laᵀ, aa] [a; α]`.
#[derive(Clone, Copy, Debug)]
struct ArticulatedInertia {
    ll: Matrix3<f64>,
    la: Matrix3<f64>,
    aa: Matrix3<f64>,
}

/// What the pass to the base leaves at each body for the pass back.
#[derive(Clone, Copy, Debug)]
pub(super) struct ArticulatedLink {
    I_A: ArticulatedInertia,
    p_A: Force,
    U: Force,
    D: f64,
}

impl ArticulatedInertia {
    fn zero() -> Self {
        Self {
            ll: Matrix3::zeros(),
            la: Matrix3::zeros(),
            aa: Matrix3::zeros(),
        }
    }

    fn of_rigid(body: &SpatialInertia) -> Self {
        Self {
            ll: Matrix3::identity() * body.m,
            la: -skew(&body.h),
            aa: body.I,
        }
    }

    fn times(&self, a: &Motion) -> Force {
        Force {
            linear: self.ll * a.linear + self.la * a.angular,
            angular: self.la.tr_mul(&a.linear) + self.aa * a.angular,
        }
    }

    /// Takes away what a free joint cannot transmit: `I_A − U Uᵀ / D`.
    fn without_axis(&self, U: &Force, D: f64) -> Self {
        let (f, n) = (U.linear / D, U.angular / D);
        Self {
            ll: self.ll - f * U.linear.transpose(),
            la: self.la - f * U.angular.transpose(),
            aa: self.aa - n * U.angular.transpose(),
        }
    }

    /// Adds a child's inertia given about the child's origin at `r`.
    fn add_child(&mut self, child: &ArticulatedInertia, r: &Vector3<f64>) {
        // `A [r]×` is `−([r]× Aᵀ)ᵀ`.
        let la = child.la + turned(r, &child.ll.transpose()).transpose();
        self.ll += child.ll;
        self.la += la;
        self.aa += child.aa + turned(r, &la) + turned(r, &child.la).transpose();
    }

    /// The acceleration that a force gives to the free body; not finite if the inertia is not.
    fn solve(&self, force: &Force) -> Motion {
        let mut I = Matrix6::zeros();
        I.fixed_view_mut::<3, 3>(0, 0).copy_from(&self.ll);
        I.fixed_view_mut::<3, 3>(3, 0)
            .copy_from(&self.la.transpose());
        I.fixed_view_mut::<3, 3>(3, 3).copy_from(&self.aa);
        let mut a = Vector6::zeros();
        a.fixed_rows_mut::<3>(0).copy_from(&force.linear);
        a.fixed_rows_mut::<3>(3).copy_from(&force.angular);
        match I.cholesky() {
            Some(factor) => factor.solve_mut(&mut a),
            None => a.fill(f64::NAN),
        }
        Motion {
            linear: a.fixed_rows::<3>(0).into_owned(),
            angular: a.fixed_rows::<3>(3).into_owned(),
        }
    }
}

/// `[r]× A`, without the products with zeros.
fn turned(r: &Vector3<f64>, A: &Matrix3<f64>) -> Matrix3<f64> {
    Matrix3::from_columns(&[0, 1, 2].map(|j| r.cross(&A.column(j))))
}

impl ArticulatedLink {
    pub(super) fn zero() -> Self {
        Self {
            I_A: ArticulatedInertia::zero(),
            p_A: Force::zero(),
            U: Force::zero(),
            D: 0.0,
        }
    }
}

/// Accelerations and joint efforts of the robot under given joint drives and external wrenches.
///
/// * `data`: after [`Data::update_kinematics`] or [`Data::update`] for the state in question;
/// * `drives`: one per joint, in the model's order;
/// * `wrenches`: what the environment does to each body (rotor thrust, contact, disturbance);
/// * `vdot`: out, size nv, `[classical acceleration of R's origin; ẇ_WR; q̈]`, world axes, m/s² and rad/s²;
/// * `effort`: out, one per joint, N·m or N: the given effort, or the one that the given acceleration needs.
pub fn forward_dynamics(
    model: &Model,
    data: &mut Data,
    drives: &[JointDrive],
    wrenches: &Wrenches,
    vdot: &mut DVector<f64>,
    effort: &mut DVector<f64>,
) {
    if data.columns == Columns::Shared {
        coupled::forward_dynamics(model, data, drives, wrenches, [vdot, effort]);
        return;
    }
    articulate(data, drives, wrenches);
    let offset = model.joint_offset();
    let Data {
        links, articulated, ..
    } = data;

    // Accelerations are relative to free fall: gravity acts as an upward acceleration of the world.
    let gravity = model.gravity();
    links[0].acceleration = match offset {
        6 => articulated[0].I_A.solve(&(articulated[0].p_A * -1.0)),
        _ => Motion {
            linear: -gravity,
            angular: Vector3::zeros(),
        },
    };
    if offset == 6 {
        let base = links[0].acceleration;
        for k in 0..3 {
            vdot[k] = base.linear[k] + gravity[k];
            vdot[3 + k] = base.angular[k];
        }
    }
    for i in 1..links.len() {
        let (before, after) = links.split_at_mut(i);
        let link = &mut after[0];
        let at = &articulated[i];
        let carried = before[link.parent].acceleration.at_child(&link.r) + link.c;
        // By symmetry of I_A, Sᵀ I_A a = a·U.
        let needed = carried.dot(&at.U) + link.S.dot(&at.p_A);
        let (qddot, tau) = match drives[i - 1] {
            JointDrive::Effort(tau) => ((tau - needed) / at.D, tau),
            JointDrive::Acceleration(qddot) => (qddot, needed + at.D * qddot),
        };
        link.acceleration = carried + link.S * qddot;
        vdot[offset + i - 1] = qddot;
        effort[i - 1] = tau;
    }
}

/// The pass from the tips to the base: articulated inertias and bias forces.
fn articulate(data: &mut Data, drives: &[JointDrive], wrenches: &Wrenches) {
    let Data {
        links, articulated, ..
    } = data;
    for (i, (link, at)) in links.iter().zip(articulated.iter_mut()).enumerate() {
        at.I_A = ArticulatedInertia::of_rigid(&link.inertia);
        at.p_A = link.inertia.rotation_bias(&link.V.angular) - wrenches.on(i);
    }
    for i in (1..links.len()).rev() {
        let link = &links[i];
        let (before, after) = articulated.split_at_mut(i);
        let at = &mut after[0];
        at.U = at.I_A.times(&link.S);
        at.D = link.S.dot(&at.U) + link.armature;
        let (I_a, p_a) = match drives[i - 1] {
            JointDrive::Effort(tau) => {
                let I_a = at.I_A.without_axis(&at.U, at.D);
                let u = tau - link.S.dot(&at.p_A);
                (I_a, at.p_A + I_a.times(&link.c) + at.U * (u / at.D))
            }
            JointDrive::Acceleration(qddot) => {
                let a = link.c + link.S * qddot;
                (at.I_A, at.p_A + at.I_A.times(&a))
            }
        };
        let parent = &mut before[link.parent];
        parent.I_A.add_child(&I_a, &link.r);
        parent.p_A += p_a.at_parent(&link.r);
    }
}
