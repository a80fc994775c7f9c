//! Walls, contact points, and what happens between them.
//!
//! # Mathematics
//! MuJoCo's contact force along the normal is `f = (a_ref − a₀ − A f) / R` with `a_ref = −b v − k r` and
//! `R = Â (1 − d)/d`, where `A` is how easily the point moves, `Â` the compiler's estimate of it (`body_invweight0`)
//! and `d` the impedance. With `solref = (−s, −c)`, `k = s / d` and `b = c / d`: so for a small d
//! `f ≈ −(s r + c v) / Â − d a₀ / Â`, and `s = Â k_wall`, `c = Â c_wall` give the wall's spring and damper.
#![allow(non_snake_case)]

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use wbqp_sim::plant::WallConfig;

use crate::{
    MjcfError, Scene,
    names::Names,
    robot::pose,
    tree::Tree,
    xml::{Attributes, Writer},
};

/// Impedance d of every contact: the share of a rigid contact.
const IMPEDANCE: f64 = 1e-3;
/// Friction is as many times harder than the normal direction: a sticking point should not creep.
pub(crate) const IMPRATIO: f64 = 1e3;
/// Rate at which a sticking point comes to rest, 1/s.
const FRICTION_RATE: f64 = 1e3;
/// Radius of a contact point's sphere, m.
const RADIUS: f64 = 1e-3;

/// A sphere on a body.
#[derive(Debug)]
pub(crate) struct Point {
    pub(crate) geom: String,
    pub(crate) body: usize,
    /// In the body, m.
    position: Vector3<f64>,
    /// Â, 1/kg.
    mobility: f64,
}

#[derive(Debug)]
pub(crate) struct Contacts {
    pub(crate) walls: Vec<String>,
    pub(crate) points: Vec<Point>,
}

impl Contacts {
    pub(crate) fn new(scene: &Scene, tree: &Tree, geoms: &mut Names) -> Result<Self, MjcfError> {
        let walls = &scene.plant.walls;
        let walls = walls.iter().map(|wall| geoms.take(&wall.name)).collect();
        let model = &scene.robot.model;
        let mut points = Vec::new();
        if scene.plant.contact_points.is_empty() {
            return Ok(Self { walls, points });
        }
        let mobility = tree.mobility()?;
        for point in &scene.plant.contact_points {
            let frame = model
                .frame(&point.frame)
                .and_then(|id| model.frames().get(id.index()));
            let Some(frame) = frame else {
                return Err(MjcfError::Entry {
                    entry: format!("contact_point `{}`", point.frame),
                    what: "the robot has no such frame".into(),
                });
            };
            let body = frame.body.index();
            points.push(Point {
                geom: geoms.take(&point.frame),
                body,
                position: frame.X_BF.transform_point(&point.offset.into()).coords,
                mobility: mobility.get(body).copied().unwrap_or(0.0),
            });
        }
        Ok(Self { walls, points })
    }

    pub(crate) fn write_walls(&self, scene: &Scene, writer: &mut Writer) {
        for (name, wall) in self.walls.iter().zip(&scene.plant.walls) {
            let normal = Vector3::from(wall.normal).normalize();
            // The sphere touches the plane when its middle, the contact point, is at the wall.
            let position = Vector3::from(wall.point) - normal * RADIUS;
            let half_turn =
                UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
            let rotation =
                UnitQuaternion::rotation_between(&Vector3::z(), &normal).unwrap_or(half_turn);
            let at = Isometry3::from_parts(position.into(), rotation);
            let attributes = pose(
                Attributes::new().with("name", name).with("type", "plane"),
                &at,
            )
            // Without end; the last number is the distance of the lines that are drawn.
            .numbers("size", &[0.0, 0.0, 0.1])
            .numbers("rgba", &[0.7, 0.7, 0.7, 1.0])
            .with("contype", 0)
            .with("conaffinity", 0);
            writer.element("geom", &attributes);
        }
    }

    /// The spheres of a body.
    pub(crate) fn write_points(&self, body: usize, writer: &mut Writer) {
        for point in self.points.iter().filter(|point| point.body == body) {
            let attributes = Attributes::new()
                .with("name", &point.geom)
                .with("type", "sphere")
                .numbers("size", &[RADIUS])
                .numbers("pos", point.position.as_slice())
                .with("contype", 0)
                .with("conaffinity", 0)
                .with("mass", 0);
            writer.element("geom", &attributes);
        }
    }

    pub(crate) fn write_pairs(&self, scene: &Scene, writer: &mut Writer) {
        if self.points.is_empty() || self.walls.is_empty() {
            return;
        }
        writer.open("contact", &Attributes::new());
        for point in &self.points {
            for (name, wall) in self.walls.iter().zip(&scene.plant.walls) {
                writer.element("pair", &pair(point, name, wall));
            }
        }
        writer.close();
    }
}

fn pair(point: &Point, wall_name: &str, wall: &WallConfig) -> Attributes {
    let Point { geom, mobility, .. } = point;
    // `f = … / ((1 − d) Â)`, see above. A zero would make MuJoCo read another format.
    let scale = mobility * (1.0 - IMPEDANCE);
    let solref = [-wall.stiffness * scale, -(wall.damping * scale).max(1e-9)];
    Attributes::new()
        .with("geom1", wall_name)
        .with("geom2", geom)
        .with("condim", if wall.friction > 0.0 { 3 } else { 1 })
        .numbers("friction", &[wall.friction, wall.friction, 0.0, 0.0, 0.0])
        .numbers("solref", &solref)
        .numbers("solreffriction", &[-1.0, -FRICTION_RATE * IMPEDANCE])
        .numbers("solimp", &[IMPEDANCE, IMPEDANCE, 0.001, 0.5, 1.0])
}
