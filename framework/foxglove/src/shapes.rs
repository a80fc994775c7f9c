//! What a robot looks like, as a scene that does not change.
#![allow(non_snake_case)]

use foxglove::messages::{
    CubePrimitive, CylinderPrimitive, LinePrimitive, ModelPrimitive, SceneEntity, SceneUpdate,
    SpherePrimitive, line_primitive,
};
use nalgebra::{Isometry3, Vector3};
use wbqp::robot::RobotModel;
use wbqp_robots::visuals::{Shape, visuals};

use crate::{
    convert::{colour, length, point, pose, vector},
    frames::Frames,
    scene::{THRUST_LENGTH, entity},
    skeleton::skeleton,
};

const GREY: [f64; 4] = [0.6, 0.62, 0.65, 1.0];
const LIMIT: [f64; 4] = [0.5, 0.5, 0.5, 0.5];

/// Largest mesh that is put into a scene, bytes.
const LARGEST_MESH: u64 = 20_000_000;

/// Shapes of the links, each in its link's frame, or lines if the robot's files have none; and what rotors could
/// thrust.
pub(crate) fn scene(robot: &RobotModel, frames: &Frames, thrust_scale: f64) -> SceneUpdate {
    let mut entities: Vec<SceneEntity> = Vec::new();
    for visual in visuals(robot).0 {
        let id = format!("link/{}", visual.link);
        if entities.last().is_none_or(|entity| entity.id != id) {
            entities.push(entity(0.0, id, frames.name(visual.frame)));
        }
        if let Some(entity) = entities.last_mut() {
            let paint = visual.colour.unwrap_or(GREY);
            add_shape(entity, &visual.shape, &visual.X_LV, paint);
        }
    }
    if entities.is_empty() {
        entities = skeleton(&robot.model);
    }
    for (_, actuator, rotor) in robot.rotors() {
        let mut limits = entity(
            0.0,
            format!("rotor_limits/{}", actuator.name),
            frames.name(rotor.frame),
        );
        let ends = [actuator.lower, actuator.upper].map(|thrust| thrust * thrust_scale);
        let tick = 0.05 * THRUST_LENGTH;
        let ends = ends.map(|z| z.clamp(-2.0 * THRUST_LENGTH, 2.0 * THRUST_LENGTH));
        let marks = ends.map(|z| [Vector3::new(-tick, 0.0, z), Vector3::new(tick, 0.0, z)]);
        let axis = ends.map(|z| Vector3::new(0.0, 0.0, z));
        let points = marks.iter().flatten().chain(&axis).map(point);
        limits.lines.push(LinePrimitive {
            r#type: line_primitive::Type::LineList.into(),
            pose: Some(pose(&Isometry3::identity())),
            thickness: 1.5,
            scale_invariant: true,
            points: points.collect(),
            color: Some(colour(LIMIT)),
            ..LinePrimitive::default()
        });
        entities.push(limits);
    }
    SceneUpdate {
        deletions: Vec::new(),
        entities,
    }
}

fn add_shape(entity: &mut SceneEntity, shape: &Shape, X_LV: &Isometry3<f64>, paint: [f64; 4]) {
    let at = Some(pose(X_LV));
    let color = Some(colour(paint));
    let round = |radius: f64, height: f64| {
        let diameter = length(2.0 * radius);
        Some(vector(&Vector3::new(diameter, diameter, height)))
    };
    match shape {
        Shape::Box(size) => entity.cubes.push(CubePrimitive {
            pose: at,
            size: Some(vector(size)),
            color,
        }),
        Shape::Sphere(radius) => entity.spheres.push(SpherePrimitive {
            pose: at,
            size: round(*radius, 2.0 * radius),
            color,
        }),
        Shape::Cylinder { radius, length } => entity.cylinders.push(CylinderPrimitive {
            pose: at,
            size: round(*radius, *length),
            bottom_scale: 1.0,
            top_scale: 1.0,
            color,
        }),
        Shape::Capsule { radius, length } => {
            add_shape(entity, &cylinder(*radius, *length), X_LV, paint);
            for end in [-0.5, 0.5] {
                let X_LE = X_LV * Isometry3::translation(0.0, 0.0, end * length);
                add_shape(entity, &Shape::Sphere(*radius), &X_LE, paint);
            }
        }
        Shape::Mesh { file, scale } => {
            let size = std::fs::metadata(file).map_or(u64::MAX, |about| about.len());
            let extension = file.extension().map(|e| e.to_string_lossy().to_lowercase());
            let media_type = match extension.as_deref() {
                Some("stl") => "model/stl",
                Some("dae") => "model/vnd.collada+xml",
                Some("obj") => "model/obj",
                Some("glb") => "model/gltf-binary",
                _ => return,
            };
            // A view without a mesh is better than none at all.
            let Some(data) = (size <= LARGEST_MESH)
                .then(|| std::fs::read(file).ok())
                .flatten()
            else {
                return;
            };
            entity.models.push(ModelPrimitive {
                pose: at,
                scale: Some(vector(scale)),
                color,
                override_color: media_type == "model/stl",
                url: String::new(),
                media_type: media_type.to_owned(),
                data: data.into(),
            });
        }
        _ => {}
    }
}

fn cylinder(radius: f64, length: f64) -> Shape {
    Shape::Cylinder { radius, length }
}
