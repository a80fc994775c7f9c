//! The workspace of one model and the results of one state.
//!
//! # Notation
//! `R` base frame, `W` world, `v = [v_WR; w_WR; q̇]`; `M v̇ + h = S u + Σ Jᵀ f`. World axes throughout.
#![allow(non_snake_case)]

use nalgebra::{DMatrix, DVector, Isometry3, Matrix3xX, Translation3, Vector3, Vector6};

use super::{
    coupled::CoupledDynamics,
    forward::ArticulatedLink,
    inverse,
    kinematics::{self, Link},
    mass_matrix,
    spatial_vector::Force,
};
use crate::{
    model::{BodyId, Carrier, Model},
    state::State,
};

/// How many bodies one velocity moves relative to their parents: without mimic joints sums over bodies have one term
/// each, and are written, not added up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Columns {
    /// One.
    Own,
    /// Several, through mimic joints.
    Shared,
}

/// Preallocated workspace and results. Belongs to the model it was made for; never allocates after
/// [`Data::new`]. A state with a number that is not finite gives results that are not finite, no panic.
#[derive(Clone, Debug)]
pub struct Data {
    pub(super) links: Vec<Link>,
    pub(super) articulated: Vec<ArticulatedLink>,
    pub(super) columns: Columns,
    /// Where they are shared.
    pub(super) coupled: Option<Box<CoupledDynamics>>,
    floats: bool,
    mass_matrix: DMatrix<f64>,
    bias: DVector<f64>,
    gravity: DVector<f64>,
    com: Vector3<f64>,
    com_velocity: Vector3<f64>,
    com_jacobian: Matrix3xX<f64>,
    com_bias: Vector3<f64>,
    centroidal_momentum: Vector6<f64>,
}

impl Data {
    /// Room for `model`, holding the results for [`State::neutral`].
    pub fn new(model: &Model) -> Self {
        let nv = model.nv();
        let links = model.bodies().iter().map(|body| {
            let (column, armature) = match body.carrier {
                Carrier::Base => (0, 0.0),
                Carrier::Joint(joint) => {
                    let armature = model.joints()[joint.index()].armature;
                    (model.velocity_index(joint).index(), armature)
                }
                Carrier::Mimic(index) => (
                    model.velocity_index(model.mimics()[index].leader).index(),
                    0.0,
                ),
            };
            Link::new(body.parent.index(), column, armature)
        });
        let columns = if model.mimics().is_empty() {
            Columns::Own
        } else {
            Columns::Shared
        };
        let mut data = Self {
            links: links.collect(),
            articulated: vec![ArticulatedLink::zero(); model.bodies().len()],
            columns,
            coupled: (columns == Columns::Shared).then(|| Box::new(CoupledDynamics::new(nv))),
            floats: model.joint_offset() == 6,
            mass_matrix: DMatrix::zeros(nv, nv),
            bias: DVector::zeros(nv),
            gravity: DVector::zeros(nv),
            com: Vector3::zeros(),
            com_velocity: Vector3::zeros(),
            com_jacobian: Matrix3xX::zeros(nv),
            com_bias: Vector3::zeros(),
            centroidal_momentum: Vector6::zeros(),
        };
        data.update(model, &State::neutral(model));
        data
    }

    /// Everything a control tick needs: kinematics, M, h, gravity, centre of mass and momentum.
    pub fn update(&mut self, model: &Model, state: &State) {
        self.update_kinematics(model, state);
        let offset = model.joint_offset();
        mass_matrix::composite_inertias(&mut self.links);
        let mass_matrix = match self.columns {
            Columns::Own => mass_matrix::mass_matrix,
            Columns::Shared => mass_matrix::coupled_mass_matrix,
        };
        mass_matrix(
            &self.links,
            &model.gravity(),
            offset,
            &mut self.mass_matrix,
            &mut self.gravity,
            &mut self.com_jacobian,
        );
        inverse::velocity_forces(&mut self.links, offset, self.columns, &mut self.bias);
        self.bias += &self.gravity;
        self.update_centroid(&state.v);
    }

    /// Only the kinematic pass: what [`forward_dynamics`](super::forward_dynamics),
    /// [`inverse_dynamics`](super::inverse_dynamics), [`energy`](super::energy()) and the frame functions need. M, h,
    /// gravity, centre of mass and momentum keep the values of the last [`Data::update`].
    pub fn update_kinematics(&mut self, model: &Model, state: &State) {
        kinematics::forward_pass(&mut self.links, model, state);
    }

    /// Position, velocity, bias acceleration and momentum of the centre of mass. Needs the composite inertias, the
    /// mass matrix and the base force of the velocity terms.
    fn update_centroid(&mut self, v: &DVector<f64>) {
        let base = &self.links[0];
        let whole = &base.composite;
        self.com = base.p_WB + whole.h / whole.m;
        self.com_bias = base.force.linear / whole.m;

        let momentum = if self.floats {
            let arm = base.p_WB - self.com;
            base_momentum(&self.mass_matrix, v).at_parent(&arm)
        } else {
            let links = self.links.iter();
            links.fold(Force::zero(), |sum, link| {
                let own = link.inertia.times(&link.V);
                sum + own.at_parent(&(link.p_WB - self.com))
            })
        };
        self.com_velocity = momentum.linear / whole.m;
        self.centroidal_momentum
            .fixed_rows_mut::<3>(0)
            .copy_from(&momentum.linear);
        self.centroidal_momentum
            .fixed_rows_mut::<3>(3)
            .copy_from(&momentum.angular);
    }

    /// Mass matrix `M`, nv × nv, symmetric and full, armature on the diagonal. Units kg, kg·m, kg·m² by block;
    /// base rows in world axes about R's origin (RBDA section 6.2).
    pub fn mass_matrix(&self) -> &DMatrix<f64> {
        &self.mass_matrix
    }

    /// `h(q, v)`, size nv: Coriolis, centrifugal and gravity terms, without damping and friction. N and N·m; base
    /// rows in world axes about R's origin (RBDA section 5.3).
    pub fn bias(&self) -> &DVector<f64> {
        &self.bias
    }

    /// `g(q) = h(q, 0)`, size nv, N and N·m: what holds the robot still; its third entry is the weight.
    pub fn gravity(&self) -> &DVector<f64> {
        &self.gravity
    }

    /// Centre of mass of the whole robot, m, world; of a fixed base with the links that are fixed.
    pub fn center_of_mass(&self) -> Vector3<f64> {
        self.com
    }

    /// Velocity of the centre of mass, m/s, world axes.
    pub fn center_of_mass_velocity(&self) -> Vector3<f64> {
        self.com_velocity
    }

    /// Jacobian of the centre of mass, 3 × nv, world axes: `ṗ_com = J_com v`.
    pub fn center_of_mass_jacobian(&self) -> &Matrix3xX<f64> {
        &self.com_jacobian
    }

    /// `J̇_com v`, m/s², world axes: acceleration of the centre of mass when `v̇ = 0`.
    pub fn center_of_mass_bias(&self) -> Vector3<f64> {
        self.com_bias
    }

    /// `[linear; angular]` momentum, kg·m/s and kg·m²/s, world axes, the angular part about the centre of mass.
    /// Spinning rotors hidden in armatures have no part in it.
    pub fn centroidal_momentum(&self) -> Vector6<f64> {
        self.centroidal_momentum
    }

    /// Pose `X_WB` of a body, m, world.
    pub fn body_pose(&self, body: BodyId) -> Isometry3<f64> {
        let link = &self.links[body.index()];
        Isometry3::from_parts(Translation3::from(link.p_WB), link.q_WB)
    }

    /// `Jᵀ w` of a wrench on a body about its origin, N and N·m, **body** axes: hands out each velocity's index and the
    /// generalised force on it, for the velocities that move the body; with mimic joints an index may come more than
    /// once, with the parts of a sum.
    pub(crate) fn generalised_force(
        &self,
        body: BodyId,
        force_B: &Vector3<f64>,
        moment_B: &Vector3<f64>,
        mut write: impl FnMut(usize, f64),
    ) {
        let R_WB = &self.links[body.index()].R_WB;
        let mut force = Force {
            linear: R_WB * force_B,
            angular: R_WB * moment_B,
        };
        let mut i = body.index();
        while i != 0 {
            let link = &self.links[i];
            write(link.column, link.S.dot(&force));
            force = force.at_parent(&link.r);
            i = link.parent;
        }
        if self.floats {
            for k in 0..3 {
                write(k, force.linear[k]);
                write(3 + k, force.angular[k]);
            }
        }
    }
}

/// The base rows of `M v`: the whole robot's momentum, kg·m/s and kg·m²/s, world axes, about the base's origin.
fn base_momentum(M: &DMatrix<f64>, v: &DVector<f64>) -> Force {
    let mut sum = Force::zero();
    for (column, v) in M.column_iter().zip(v) {
        sum.linear += Vector3::new(column[0], column[1], column[2]) * *v;
        sum.angular += Vector3::new(column[3], column[4], column[5]) * *v;
    }
    sum
}
