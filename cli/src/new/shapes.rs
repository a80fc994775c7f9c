//! Sizes of feet, from the collision shapes of a URDF. Boxes, spheres, cylinders and capsules; meshes are not read.
//!
//! # Notation
//! A link `L` is merged into the body `B` at `X_BL`; a shape is at `X_LS`.
#![allow(non_snake_case)]

use wbqp::{
    model::BodyId,
    nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3},
    robot::RobotModel,
};

/// Corners of all shapes that are fixed to a body, m, body axes; spheres and round things by their extents.
pub(super) fn corners(robot: &RobotModel, body: BodyId) -> Vec<Vector3<f64>> {
    let Some(source) = robot.sources.first() else {
        return Vec::new();
    };
    let text = source.contents.trim_start_matches('\u{feff}');
    // The loader forgives more than XML allows: then there are no shapes.
    let Ok(document) = roxmltree::Document::parse(text) else {
        return Vec::new();
    };
    let links = document.root_element().children();
    let links = links.filter(|node| node.has_tag_name("link"));
    let mut corners = Vec::new();
    for link in links {
        let name = link.attribute("name").unwrap_or_default();
        let frame = robot.model.frame(name);
        let frame = frame.and_then(|id| robot.model.frames().get(id.index()));
        let Some(frame) = frame.filter(|frame| frame.body == body) else {
            continue;
        };
        for shape in link
            .children()
            .filter(|node| node.has_tag_name("collision"))
        {
            let X_BS = frame.X_BF * origin(shape);
            let extents = half_extents(shape).unwrap_or_default();
            corners.extend(extents.into_iter().map(|p| X_BS * p).map(|p| p.coords));
        }
    }
    corners
}

fn child<'a>(node: roxmltree::Node<'a, 'a>, name: &str) -> Option<roxmltree::Node<'a, 'a>> {
    node.children().find(|child| child.has_tag_name(name))
}

fn numbers(node: roxmltree::Node<'_, '_>, attribute: &str) -> Option<Vec<f64>> {
    let text = node.attribute(attribute)?;
    text.split_whitespace()
        .map(|word| word.parse().ok())
        .collect()
}

fn triple(node: roxmltree::Node<'_, '_>, attribute: &str) -> Option<[f64; 3]> {
    numbers(node, attribute)?.try_into().ok()
}

fn origin(shape: roxmltree::Node<'_, '_>) -> Isometry3<f64> {
    let Some(origin) = child(shape, "origin") else {
        return Isometry3::identity();
    };
    let [x, y, z] = triple(origin, "xyz").unwrap_or_default();
    let [roll, pitch, yaw] = triple(origin, "rpy").unwrap_or_default();
    let rotation = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
    Isometry3::from_parts(Translation3::new(x, y, z), rotation)
}

/// The corners of a shape in its own axes; nothing for a mesh.
fn half_extents(shape: roxmltree::Node<'_, '_>) -> Option<Vec<wbqp::nalgebra::Point3<f64>>> {
    let geometry = child(shape, "geometry")?;
    let number = |node: roxmltree::Node<'_, '_>, name: &str| numbers(node, name)?.first().copied();
    if let Some(sphere) = child(geometry, "sphere") {
        let r = number(sphere, "radius")?;
        let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
        let ends = axes.into_iter().flat_map(|axis| [r * axis, -r * axis]);
        return Some(ends.map(Into::into).collect());
    }
    let half = if let Some(cuboid) = child(geometry, "box") {
        Vector3::from(triple(cuboid, "size")?) / 2.0
    } else {
        let round = child(geometry, "cylinder").or_else(|| child(geometry, "capsule"))?;
        let r = number(round, "radius")?;
        Vector3::new(r, r, number(round, "length")? / 2.0)
    };
    let sides = [-1.0, 1.0];
    let mut corners = Vec::new();
    for x in sides {
        for y in sides {
            for z in sides {
                corners.push(Vector3::new(x, y, z).component_mul(&half).into());
            }
        }
    }
    Some(corners)
}
