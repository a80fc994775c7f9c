//! A robot whose files say nothing of its looks: lines from joint to joint.
#![allow(non_snake_case)]

use foxglove::messages::{LinePrimitive, SceneEntity, SpherePrimitive, line_primitive};
use nalgebra::{Isometry3, Point3, Vector3};
use wbqp::model::{BodyId, Model};

use crate::{
    convert::{colour, point, pose, vector},
    scene::entity,
};

const BONE: [f64; 4] = [0.45, 0.48, 0.52, 1.0];
/// Thickness of lines and radius of joints, shares of the robot's size.
const THICKNESS: f64 = 0.02;

/// Of each body a line from its origin to each joint and to each frame that it carries.
pub(crate) fn skeleton(model: &Model) -> Vec<SceneEntity> {
    let bodies = model.bodies().iter().enumerate();
    let ends: Vec<(&str, Vec<Vector3<f64>>)> = bodies
        .map(|(i, body)| (body.name.as_str(), ends(model, i)))
        .collect();
    let size = ends.iter().flat_map(|(_, ends)| ends).map(Vector3::norm);
    let thickness = THICKNESS * size.fold(0.1, f64::max);
    let entities = ends.iter().map(|(name, ends)| {
        let mut entity = entity(0.0, format!("link/{name}"), name);
        let lines = ends.iter().flat_map(|end| [Vector3::zeros(), *end]);
        entity.lines.push(LinePrimitive {
            r#type: line_primitive::Type::LineList.into(),
            pose: Some(pose(&Isometry3::identity())),
            thickness,
            points: lines.map(|end| point(&end)).collect(),
            color: Some(colour(BONE)),
            ..LinePrimitive::default()
        });
        entity.spheres.push(SpherePrimitive {
            pose: Some(pose(&Isometry3::identity())),
            size: Some(vector(&Vector3::from_element(3.0 * thickness))),
            color: Some(colour(BONE)),
        });
        entity
    });
    entities.collect()
}

/// Where a body's lines end, m, in its axes.
fn ends(model: &Model, body: usize) -> Vec<Vector3<f64>> {
    let joints = model.joints().iter().zip(0..);
    let joints = joints.filter_map(|(joint, id)| {
        let child = model.body_of(wbqp::model::JointId::new(id));
        let parent: BodyId = model.bodies().get(child.index())?.parent;
        (parent.index() == body).then_some(joint.X_PJ)
    });
    let frames = model.frames().iter();
    let frames = frames.filter(|frame| frame.body.index() == body);
    let places = joints.chain(frames.map(|frame| frame.X_BF));
    let mut ends: Vec<Vector3<f64>> = Vec::new();
    for place in places {
        let end = (place * Point3::origin()).coords;
        let is_new = ends.iter().all(|known| (known - end).norm() > 1e-4);
        if end.norm() > 1e-3 && is_new {
            ends.push(end);
        }
    }
    ends
}
