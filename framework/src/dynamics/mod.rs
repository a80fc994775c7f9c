//! stub
use crate::{model::*, state::State};
use nalgebra::*;
/// stub
#[derive(Debug, Clone)]
pub struct Data {}
impl Data {
    /// s
    pub fn new(_: &Model) -> Self {
        Data {}
    }
    /// s
    pub fn update(&mut self, _: &Model, _: &State) {}
    /// s
    pub fn mass_matrix(&self) -> &DMatrix<f64> {
        todo!()
    }
    /// s
    pub fn bias(&self) -> &DVector<f64> {
        todo!()
    }
}
/// stub
#[derive(Debug, Clone)]
#[allow(non_snake_case, missing_docs)]
pub struct FrameKinematics {
    pub p_WF: Vector3<f64>,
    pub R_WF: Rotation3<f64>,
    pub v_WF: Vector3<f64>,
    pub w_WF: Vector3<f64>,
    pub J: Matrix6xX<f64>,
    pub Jdot_v: Vector6<f64>,
}
impl FrameKinematics {
    /// s
    pub fn new(_: &Model) -> Self {
        todo!()
    }
    /// s
    pub fn update(&mut self, _: &Model, _: &Data, _: FrameId) {}
}
