//! Inertia of one body or of a rigidly joined subtree, in world axes about a body's origin.
//!
//! # Notation
//! `m` mass (kg), `h` first moment from the body's origin (kg·m), `I` rotational inertia about the origin
//! (kg·m²): the ten numbers of RBDA section 2.13. `r` is the body's origin from its parent's.
#![allow(non_snake_case)]

use nalgebra::{Matrix3, Vector3};

use super::spatial_vector::{Force, Motion};
use crate::model::Inertia;

#[derive(Clone, Copy, Debug)]
pub(super) struct SpatialInertia {
    pub(super) m: f64,
    pub(super) h: Vector3<f64>,
    pub(super) I: Matrix3<f64>,
}

impl SpatialInertia {
    pub(super) fn zero() -> Self {
        Self {
            m: 0.0,
            h: Vector3::zeros(),
            I: Matrix3::zeros(),
        }
    }

    /// A body's inertia turned into world axes.
    pub(super) fn of_body(body: &Inertia, R_WB: &Matrix3<f64>) -> Self {
        let turned = R_WB * body.I_BBo;
        let entry = |a: usize, b: usize| turned.row(a).dot(&R_WB.row(b));
        let (xy, xz, yz) = (entry(0, 1), entry(0, 2), entry(1, 2));
        Self {
            m: body.mass,
            h: R_WB * body.first_moment,
            I: Matrix3::new(
                entry(0, 0),
                xy,
                xz,
                xy,
                entry(1, 1),
                yz,
                xz,
                yz,
                entry(2, 2),
            ),
        }
    }

    /// Force that gives the acceleration `a` to the body at rest; momentum if `a` is a velocity.
    pub(super) fn times(&self, a: &Motion) -> Force {
        Force {
            linear: a.linear * self.m + a.angular.cross(&self.h),
            angular: self.I * a.angular + self.h.cross(&a.linear),
        }
    }

    /// Force that keeps the body turning at `w` (rad/s) with no acceleration of its origin:
    /// centrifugal and gyroscopic terms.
    pub(super) fn rotation_bias(&self, w: &Vector3<f64>) -> Force {
        Force {
            linear: w.cross(&w.cross(&self.h)),
            angular: w.cross(&(self.I * w)),
        }
    }

    /// Adds a child's inertia, given about the child's origin at `r` (parallel axes, RBDA section 2.13).
    pub(super) fn add_child(&mut self, child: &SpatialInertia, r: &Vector3<f64>) {
        let SpatialInertia { m, h, I } = child;
        let s = r * *m + h;
        // (r·s + r·h) 1 − r sᵀ − h rᵀ, with s = m r + h.
        let mut shift = -(r * s.transpose() + h * r.transpose());
        let diagonal = r.dot(&s) + r.dot(h);
        for k in 0..3 {
            shift[(k, k)] += diagonal;
        }
        self.m += m;
        self.h += s;
        self.I += I + shift;
    }
}
