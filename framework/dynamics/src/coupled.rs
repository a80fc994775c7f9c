//! Forward dynamics of a robot with mimic joints.
//!
//! # Mathematics
//! `M v̇ + n = τ` with `n = h − Σ Jᵀ f`. Where a joint's acceleration is given (`g`), its effort is what is asked for;
//! for the others (`f`, the base's with effort zero) `M_ff v̇_f = τ_f − n_f − M_fg v̇_g`, by Cholesky factorisation.
//! The coupling is in M and n already. RBDA section 6.1.
#![allow(non_snake_case)]

use nalgebra::{Cholesky, DMatrix, DVector, Matrix3xX};

use super::{
    Data, JointDrive, Wrenches,
    inverse::inverse_dynamics,
    mass_matrix::{composite_inertias, coupled_mass_matrix},
};
use crate::model::Model;

/// Storage made once.
#[derive(Clone, Debug)]
pub(super) struct CoupledDynamics {
    M: DMatrix<f64>,
    factor: DMatrix<f64>,
    /// `n`.
    known: DVector<f64>,
    gravity: DVector<f64>,
    com_jacobian: Matrix3xX<f64>,
}

impl CoupledDynamics {
    pub(super) fn new(nv: usize) -> Self {
        Self {
            M: DMatrix::zeros(nv, nv),
            factor: DMatrix::zeros(nv, nv),
            known: DVector::zeros(nv),
            gravity: DVector::zeros(nv),
            com_jacobian: Matrix3xX::zeros(nv),
        }
    }
}

/// See [`forward_dynamics`](super::forward_dynamics).
pub(super) fn forward_dynamics(
    model: &Model,
    data: &mut Data,
    drives: &[JointDrive],
    wrenches: &Wrenches,
    [vdot, effort]: [&mut DVector<f64>; 2],
) {
    let Some(mut work) = data.coupled.take() else {
        return;
    };
    let offset = model.joint_offset();
    vdot.fill(0.0);
    inverse_dynamics(model, data, vdot, wrenches, &mut work.known);
    composite_inertias(&mut data.links);
    let CoupledDynamics {
        M,
        gravity,
        com_jacobian,
        ..
    } = &mut *work;
    coupled_mass_matrix(
        &data.links,
        &model.gravity(),
        offset,
        M,
        gravity,
        com_jacobian,
    );
    solve(&mut work, offset, drives, vdot);
    for (i, drive) in drives.iter().enumerate() {
        effort[i] = match drive {
            JointDrive::Effort(tau) => *tau,
            JointDrive::Acceleration(_) => {
                let row = work.M.row(offset + i);
                row.iter().zip(vdot.iter()).map(|(m, a)| m * a).sum::<f64>()
                    + work.known[offset + i]
            }
        };
    }
    data.coupled = Some(work);
}

/// Writes `v̇`; not a number where M is not positive definite.
fn solve(
    work: &mut CoupledDynamics,
    offset: usize,
    drives: &[JointDrive],
    vdot: &mut DVector<f64>,
) {
    let CoupledDynamics {
        M, factor, known, ..
    } = work;
    factor.copy_from(M);
    for k in 0..offset {
        vdot[k] = -known[k];
    }
    for (i, drive) in drives.iter().enumerate() {
        if let JointDrive::Effort(tau) = drive {
            vdot[offset + i] = tau - known[offset + i];
        }
    }
    for (i, drive) in drives.iter().enumerate() {
        if let JointDrive::Acceleration(given) = drive {
            let g = offset + i;
            vdot.axpy(-given, &M.column(g), 1.0);
            factor.row_mut(g).fill(0.0);
            factor.column_mut(g).fill(0.0);
            factor[(g, g)] = 1.0;
        }
    }
    for (i, drive) in drives.iter().enumerate() {
        if let JointDrive::Acceleration(given) = drive {
            vdot[offset + i] = *given;
        }
    }
    let storage = std::mem::replace(factor, DMatrix::zeros(0, 0));
    if let Some(cholesky) = Cholesky::new(storage) {
        cholesky.solve_mut(vdot);
        *factor = cholesky.unpack_dirty();
    } else {
        *factor = DMatrix::zeros(M.nrows(), M.ncols());
        vdot.fill(f64::NAN);
    }
}
