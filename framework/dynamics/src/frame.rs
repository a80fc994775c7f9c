//! Pose, velocity, Jacobian and bias acceleration of a frame.
//!
//! # Notation
//! Frame `F` is fixed to body `B` by `X_BF`; `o` = `p_BF_W` is its origin from B's origin, in world axes.
//! `[v_WF; w_WF] = J v` and `[v̇_WF; ẇ_WF] = J v̇ + J̇v`, linear first, world axes, of F's origin. A column of J
//! is the joint's axis carried to F's origin; `J̇v` is the body's bias acceleration carried there.
#![allow(non_snake_case)]

use nalgebra::{Isometry3, Matrix6xX, Rotation3, Vector3, Vector6};

use super::{Data, data::Columns, kinematics::Link};
use crate::model::{BodyId, FrameId, Model};

/// Pose and velocity of a frame: the light version for sensors and plants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameMotion {
    /// Origin, m, world.
    pub p_WF: Vector3<f64>,
    /// Orientation in the world.
    pub R_WF: Rotation3<f64>,
    /// Velocity of the origin, m/s, world axes.
    pub v_WF: Vector3<f64>,
    /// Angular velocity, rad/s, world axes.
    pub w_WF: Vector3<f64>,
}

/// Everything a task asks of a frame. Preallocated: updates never allocate.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameKinematics {
    /// Origin, m, world.
    pub p_WF: Vector3<f64>,
    /// Orientation in the world.
    pub R_WF: Rotation3<f64>,
    /// Velocity of the origin, m/s, world axes.
    pub v_WF: Vector3<f64>,
    /// Angular velocity, rad/s, world axes.
    pub w_WF: Vector3<f64>,
    /// Jacobian of the frame's origin, 6 × nv, linear rows first, world axes: `[v_WF; w_WF] = J v`.
    pub J: Matrix6xX<f64>,
    /// `J̇v`, m/s² and rad/s²: classical acceleration of the origin and angular acceleration when `v̇ = 0`.
    pub Jdot_v: Vector6<f64>,
}

/// Pose and velocity of a named frame. `data` must have its kinematics.
pub fn frame_motion(model: &Model, data: &Data, frame: FrameId) -> FrameMotion {
    let frame = &model.frames()[frame.index()];
    motion_at(&data.links[frame.body.index()], &frame.X_BF)
}

/// Position and velocity of a point of a body: lighter still, for points that need no orientation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointMotion {
    /// The point, m, world.
    pub p_WQ: Vector3<f64>,
    /// Its velocity, m/s, world axes.
    pub v_WQ: Vector3<f64>,
}

/// Position and velocity of the point at `p_BQ` (m, body axes, from the body's origin) of a body. `data` must have its
/// kinematics.
pub fn point_motion(data: &Data, body: BodyId, p_BQ: &Vector3<f64>) -> PointMotion {
    let link = &data.links[body.index()];
    let arm = link.R_WB * p_BQ;
    PointMotion {
        p_WQ: link.p_WB + arm,
        v_WQ: link.V.at_child(&arm).linear,
    }
}

fn motion_at(link: &Link, X_BF: &Isometry3<f64>) -> FrameMotion {
    let o = link.R_WB * X_BF.translation.vector;
    let V_WF = link.V.at_child(&o);
    FrameMotion {
        p_WF: link.p_WB + o,
        R_WF: (link.q_WB * X_BF.rotation).to_rotation_matrix(),
        v_WF: V_WF.linear,
        w_WF: V_WF.angular,
    }
}

impl FrameKinematics {
    /// Room for a model of nv velocities, all zero until the first update.
    pub fn new(model: &Model) -> Self {
        Self {
            p_WF: Vector3::zeros(),
            R_WF: Rotation3::identity(),
            v_WF: Vector3::zeros(),
            w_WF: Vector3::zeros(),
            J: Matrix6xX::zeros(model.nv()),
            Jdot_v: Vector6::zeros(),
        }
    }

    /// Fills in everything for a named frame. `data` must have its kinematics.
    pub fn update(&mut self, model: &Model, data: &Data, frame: FrameId) {
        let frame = &model.frames()[frame.index()];
        self.update_at(model, data, frame.body, &frame.X_BF);
    }

    /// Fills in everything for the frame at `X_BF` on `body`. `data` must have its kinematics.
    pub fn update_at(&mut self, model: &Model, data: &Data, body: BodyId, X_BF: &Isometry3<f64>) {
        let link = &data.links[body.index()];
        let motion = motion_at(link, X_BF);
        self.p_WF = motion.p_WF;
        self.R_WF = motion.R_WF;
        self.v_WF = motion.v_WF;
        self.w_WF = motion.w_WF;

        let o = motion.p_WF - link.p_WB;
        let w = &link.V.angular;
        let bias = link.bias.at_child(&o);
        let linear = bias.linear + w.cross(&w.cross(&o));
        self.Jdot_v.fixed_rows_mut::<3>(0).copy_from(&linear);
        self.Jdot_v.fixed_rows_mut::<3>(3).copy_from(&bias.angular);

        self.fill_jacobian(model, data, body);
    }

    /// Writes the columns of the joints that carry `body`, and of the base; all others are zero.
    fn fill_jacobian(&mut self, model: &Model, data: &Data, body: BodyId) {
        let offset = model.joint_offset();
        let (J, _) = self.J.as_mut_slice().as_chunks_mut::<6>();
        J.fill([0.0; 6]);
        let columns = data.columns;
        let mut i = body.index();
        while i != 0 {
            let link = &data.links[i];
            let column = link.S.at_child(&(self.p_WF - link.p_WB));
            let (v, w) = (column.linear, column.angular);
            let column = [v.x, v.y, v.z, w.x, w.y, w.z];
            match columns {
                Columns::Own => J[link.column] = column,
                Columns::Shared => {
                    for (sum, part) in J[link.column].iter_mut().zip(column) {
                        *sum += part;
                    }
                }
            }
            i = link.parent;
        }
        if offset == 6 {
            // Unit velocities of the base; a turn about an axis e moves the origin by e × r.
            let r = self.p_WF - data.links[0].p_WB;
            J[0] = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0];
            J[1] = [0.0, 1.0, 0.0, 0.0, 0.0, 0.0];
            J[2] = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
            J[3] = [0.0, -r.z, r.y, 1.0, 0.0, 0.0];
            J[4] = [r.z, 0.0, -r.x, 0.0, 1.0, 0.0];
            J[5] = [-r.y, r.x, 0.0, 0.0, 0.0, 1.0];
        }
    }
}
