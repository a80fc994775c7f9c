//! What the environment does to each body.
//!
//! # Notation
//! World axes, N and N·m. A wrench is stored about the origin of the body it acts on; points are world
//! positions `p_WQ`.
#![allow(non_snake_case)]

use nalgebra::Vector3;

use super::{Data, spatial_vector::Force};
use crate::model::{BodyId, Model};

/// One external wrench per body of a model.
#[derive(Clone, Debug)]
pub struct Wrenches {
    of_body: Vec<Force>,
}

impl Wrenches {
    /// No force on any body.
    pub fn new(model: &Model) -> Self {
        Self {
            of_body: vec![Force::zero(); model.bodies().len()],
        }
    }

    /// Takes all forces away again.
    pub fn clear(&mut self) {
        self.of_body.fill(Force::zero());
    }

    /// Adds `force_W` (N, world axes) acting on `body` at the world point `p_WQ` (m). `data` says where the
    /// body is: it must have its kinematics.
    pub fn add_force(
        &mut self,
        data: &Data,
        body: BodyId,
        p_WQ: &Vector3<f64>,
        force_W: &Vector3<f64>,
    ) {
        self.add_wrench(data, body, p_WQ, force_W, &Vector3::zeros());
    }

    /// Adds a force (N) acting on `body` at the world point `p_WQ` (m) and a moment about that point (N·m), all
    /// in world axes. `data` says where the body is: it must have its kinematics.
    pub fn add_wrench(
        &mut self,
        data: &Data,
        body: BodyId,
        p_WQ: &Vector3<f64>,
        force_W: &Vector3<f64>,
        moment_W: &Vector3<f64>,
    ) {
        let i = body.index();
        let arm = p_WQ - data.links[i].p_WB;
        self.of_body[i] += Force {
            linear: *force_W,
            angular: moment_W + arm.cross(force_W),
        };
    }

    /// Adds a force (N) and a moment about the body's origin (N·m), both in **body** axes. `data` says how the body is
    /// turned: it must have its kinematics.
    pub fn add_body_wrench(
        &mut self,
        data: &Data,
        body: BodyId,
        force_B: &Vector3<f64>,
        moment_B: &Vector3<f64>,
    ) {
        let i = body.index();
        let R_WB = &data.links[i].R_WB;
        self.of_body[i] += Force {
            linear: R_WB * force_B,
            angular: R_WB * moment_B,
        };
    }

    /// Force on a body, N, world axes.
    pub fn force(&self, body: BodyId) -> Vector3<f64> {
        self.of_body[body.index()].linear
    }

    /// Moment on a body about its origin, N·m, world axes.
    pub fn moment(&self, body: BodyId) -> Vector3<f64> {
        self.of_body[body.index()].angular
    }

    pub(super) fn on(&self, body: usize) -> Force {
        self.of_body[body]
    }
}
