//! What a robot looks like, as a scene that does not change.
#![allow(non_snake_case)]

use std::path::Path;

use foxglove::messages::{
    CubePrimitive, CylinderPrimitive, LinePrimitive, ModelPrimitive, SceneEntity, SceneUpdate,
    SpherePrimitive, line_primitive,
};
use nalgebra::{Isometry3, Vector3};
use wbqp::{input, robot::RobotModel};
use wbqp_robots::visuals::{Shape, visuals};

use crate::{
    convert::{colour, point, pose, shown, vector},
    frames::Frames,
    scene::{THRUST_LENGTH, entity},
    skeleton::skeleton,
};

const GREY: [f64; 4] = [0.6, 0.62, 0.65, 1.0];
const LIMIT: [f64; 4] = [0.5, 0.5, 0.5, 0.5];

/// Meshes of a scene, bytes in all: they are one message.
const ALL_MESHES: u64 = 20_000_000;

/// Shapes of the links, each in its link's frame, or lines if the robot's files have none; and what rotors could
/// thrust. Also, in words, what cannot be drawn.
pub(crate) fn scene(
    robot: &RobotModel,
    frames: &Frames,
    thrust_scale: f64,
) -> (SceneUpdate, Vec<String>) {
    let mut entities: Vec<SceneEntity> = Vec::new();
    let (visuals, mut left_out) = visuals(robot);
    let mut room = ALL_MESHES;
    for visual in visuals {
        let id = format!("link/{}", visual.link);
        let known = entities.last_mut().filter(|entity| entity.id == id);
        let mut new = entity(0.0, id, frames.name(visual.frame));
        let is_known = known.is_some();
        let paint = visual.colour.unwrap_or(GREY);
        let entity = known.unwrap_or(&mut new);
        match add_shape(entity, &visual.shape, &visual.X_LV, paint, &mut room) {
            Ok(()) if is_known => {}
            Ok(()) => entities.push(new),
            Err(what) => {
                let link = &visual.link;
                left_out.push(format!("a visual of link `{link}` is left out: {what}"));
            }
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
    let scene = SceneUpdate {
        deletions: Vec::new(),
        entities,
    };
    (scene, left_out)
}

/// `room` is how many bytes of meshes there may still be.
fn add_shape(
    entity: &mut SceneEntity,
    shape: &Shape,
    X_LV: &Isometry3<f64>,
    paint: [f64; 4],
    room: &mut u64,
) -> Result<(), String> {
    let at = Some(pose(X_LV));
    let color = Some(colour(paint));
    let round = |radius: f64, height: f64| {
        let diameter = shown(2.0 * radius);
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
            let (radius, length) = (*radius, *length);
            let middle = Shape::Cylinder { radius, length };
            add_shape(entity, &middle, X_LV, paint, room)?;
            for end in [-0.5, 0.5] {
                let X_LE = X_LV * Isometry3::translation(0.0, 0.0, end * length);
                add_shape(entity, &Shape::Sphere(radius), &X_LE, paint, room)?;
            }
        }
        Shape::Mesh { file, scale } => {
            let (media_type, data) = read_mesh(file, room)?;
            entity.models.push(ModelPrimitive {
                pose: at,
                scale: Some(vector(scale)),
                color,
                // The other formats have colours of their own.
                override_color: media_type == "model/stl",
                url: String::new(),
                media_type: media_type.to_owned(),
                data: data.into(),
            });
        }
        _ => return Err("it is of no shape that is known here".to_owned()),
    }
    Ok(())
}

/// Media type and contents of a mesh.
fn read_mesh(file: &Path, room: &mut u64) -> Result<(&'static str, Vec<u8>), String> {
    let name = file.display();
    let extension = file.extension().map(|e| e.to_string_lossy().to_lowercase());
    let media_type = match extension.as_deref() {
        Some("stl") => "model/stl",
        Some("dae") => "model/vnd.collada+xml",
        Some("obj") => "model/obj",
        Some("glb") => "model/gltf-binary",
        _ => {
            return Err(format!(
                "{name} is no STL, COLLADA, OBJ or binary glTF file"
            ));
        }
    };
    let data = input::read(file, *room).map_err(|error| format!("{name}: {error}"))?;
    *room = room.saturating_sub(data.len() as u64);
    Ok((media_type, data))
}
