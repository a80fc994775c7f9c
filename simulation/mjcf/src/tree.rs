//! The tree without couplings: MuJoCo's joints that follow others are joints with an equality between them.
//!
//! A [`Model`]'s leader bears limits, damping, friction and armature of the joints that follow it; here each has its
//! own.
#![allow(non_snake_case)]

use nalgebra::{DVector, Matrix3};
use wbqp::{
    dynamics::{Data, FrameKinematics},
    model::{Base, Body, Joint, Mimic, Model, ModelBuilder},
    state::State,
};

use crate::MjcfError;

/// The same bodies in the same order, each but the base on a joint of its own.
#[derive(Debug)]
pub(crate) struct Tree {
    pub(crate) model: Model,
}

impl Tree {
    pub(crate) fn new(model: &Model) -> Result<Self, MjcfError> {
        let bodies = model.bodies();
        let refuse = |what: &str| MjcfError::Robot(what.to_owned());
        let base = bodies.first().ok_or_else(|| refuse("it has no body"))?;
        let mut builder = ModelBuilder::new(model.name(), model.base(), &base.name, base.inertia)
            .gravity(model.gravity());
        for body in bodies.iter().skip(1) {
            builder.body(
                body.parent,
                joint_of(model, body)?,
                &body.name,
                body.inertia,
            );
        }
        let model = builder.build_with_any_inertia()?;
        Ok(Self { model })
    }

    /// Bodies that hang on a body, by position.
    pub(crate) fn children(&self, of: usize) -> impl Iterator<Item = usize> {
        let bodies = self.model.bodies().iter().enumerate();
        bodies
            .filter(move |(i, body)| *i > 0 && body.parent.index() == of)
            .map(|(i, _)| i)
    }

    /// The joint that carries a body, by the body's position; nothing for the base.
    pub(crate) fn joint(&self, body: usize) -> Option<&Joint> {
        self.model.joints().get(body.checked_sub(1)?)
    }

    /// MuJoCo's `body_invweight0`: how easily the centre of mass of each body moves with all joints at zero, the mean
    /// over the directions, 1/kg.
    pub(crate) fn mobility(&self) -> Result<Vec<f64>, MjcfError> {
        let model = &self.model;
        let mut data = Data::new(model);
        data.update(model, &State::neutral(model));
        let M = data.mass_matrix().clone();
        let Some(factor) = M.cholesky() else {
            let what = "its mass matrix is singular: a joint moves nothing, give it an `armature`";
            return Err(MjcfError::Robot(what.to_owned()));
        };
        let mut point = FrameKinematics::new(model);
        let mut all = Vec::new();
        for (index, body) in model.bodies().iter().enumerate() {
            if index == 0 && model.base() == Base::Fixed {
                all.push(0.0);
                continue;
            }
            let Some(id) = model.body_id(index) else {
                continue;
            };
            let at = nalgebra::Translation3::from(body.inertia.com()).into();
            point.update_at(model, &data, id, &at);
            let J = point.J.rows(0, 3).clone_owned();
            let A: Matrix3<f64> = (&J * factor.solve(&J.transpose()))
                .fixed_view::<3, 3>(0, 0)
                .into_owned();
            all.push(A.trace() / 3.0);
        }
        Ok(all)
    }
}

/// The joint of a body with its own limits and friction.
fn joint_of(model: &Model, body: &Body) -> Result<Joint, MjcfError> {
    let is_this = |other: &Mimic| {
        let carried = model.bodies().get(other.body.index());
        carried.is_some_and(|carried| carried.name == body.name)
    };
    if let Some(mimic) = model.mimics().iter().find(|mimic| is_this(mimic)) {
        return Ok(mimic.joint.clone());
    }
    let joints = model.joints().iter().enumerate();
    let carried = joints.filter_map(|(i, joint)| {
        let id = model.joint(&joint.name)?;
        let carries = model.bodies().get(model.body_of(id).index())?;
        (carries.name == body.name).then_some((i, joint))
    });
    let Some((index, joint)) = carried.into_iter().next() else {
        return Err(MjcfError::Robot(format!(
            "no joint carries body `{}`",
            body.name
        )));
    };
    let mut own = joint.clone();
    for mimic in model.mimics() {
        if mimic.leader.index() == index {
            let (ratio, of) = (mimic.multiplier.abs(), &mimic.joint);
            own.damping = (own.damping - ratio * ratio * of.damping).max(0.0);
            own.friction = (own.friction - ratio * of.friction).max(0.0);
            own.armature = (own.armature - ratio * ratio * of.armature).max(0.0);
        }
    }
    Ok(own)
}

/// Where every joint of the tree is in a state of the model, in the tree's order, rad or m.
pub(crate) fn positions(model: &Model, tree: &Tree, state: &State) -> DVector<f64> {
    let position = |joint: &Joint| {
        if let Some(id) = model.joint(&joint.name) {
            return state.q[id.index()];
        }
        let mimic = model.mimics().iter().find(|m| m.joint.name == joint.name);
        mimic.map_or(0.0, |m| m.multiplier * state.q[m.leader.index()] + m.offset)
    };
    let joints = tree.model.joints();
    DVector::from_iterator(joints.len(), joints.iter().map(position))
}
