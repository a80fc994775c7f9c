//! What a robot looks like, as geometry of MuJoCo's.

use std::path::PathBuf;

use nalgebra::Isometry3;
use wbqp::robot::RobotModel;
use wbqp_robots::visuals::{self, Shape};

use crate::{
    names::Names,
    robot::pose,
    xml::{Attributes, Writer},
};

/// Formats of meshes that MuJoCo reads.
const MESHES: [&str; 3] = ["stl", "obj", "msh"];

/// Geometry on bodies.
#[derive(Debug, Default)]
pub(crate) struct Visuals {
    geoms: Vec<Geom>,
    /// Name, file and scale.
    meshes: Vec<(String, PathBuf, [f64; 3])>,
}

#[derive(Debug)]
struct Geom {
    link: String,
    body: usize,
    at: Isometry3<f64>,
    kind: &'static str,
    size: Vec<f64>,
    mesh: Option<String>,
    colour: Option<[f64; 4]>,
}

/// The visuals of a robot. One that cannot be drawn is left out and noted.
pub(crate) fn of(robot: &RobotModel, notes: &mut Vec<String>) -> Visuals {
    let mut visuals = Visuals::default();
    let (found, left_out) = visuals::visuals(robot);
    notes.extend(left_out);
    for visual in found {
        let Some(frame) = robot.model.frames().get(visual.frame.index()) else {
            continue;
        };
        match visuals.geometry(&visual.shape) {
            Ok((kind, size, mesh)) => visuals.geoms.push(Geom {
                body: frame.body.index(),
                at: frame.X_BF * visual.X_LV,
                link: visual.link,
                kind,
                size,
                mesh,
                colour: visual.colour,
            }),
            Err(what) => {
                let link = &visual.link;
                notes.push(format!("a visual of link `{link}` is left out: {what}"));
            }
        }
    }
    visuals
}

impl Visuals {
    /// Type, sizes and mesh of a geom.
    fn geometry(
        &mut self,
        shape: &Shape,
    ) -> Result<(&'static str, Vec<f64>, Option<String>), String> {
        Ok(match shape {
            Shape::Box(size) => ("box", (0.5 * size).as_slice().to_vec(), None),
            Shape::Sphere(radius) => ("sphere", vec![*radius], None),
            Shape::Cylinder { radius, length } => ("cylinder", vec![*radius, 0.5 * length], None),
            Shape::Capsule { radius, length } => ("capsule", vec![*radius, 0.5 * length], None),
            Shape::Mesh { file, scale } => {
                let extension = file.extension().map(|e| e.to_string_lossy().to_lowercase());
                if !extension.is_some_and(|e| MESHES.contains(&e.as_str())) {
                    return Err(format!("MuJoCo reads no such mesh: {}", file.display()));
                }
                let scale = [scale.x, scale.y, scale.z];
                ("mesh", Vec::new(), Some(self.mesh(file, scale)))
            }
            _ => return Err("MuJoCo has no such shape".to_owned()),
        })
    }

    fn mesh(&mut self, file: &PathBuf, scale: [f64; 3]) -> String {
        let mut meshes = self.meshes.iter();
        let known = meshes.find(|(_, f, s)| f == file && *s == scale);
        if let Some((name, ..)) = known {
            return name.clone();
        }
        let name = format!("mesh_{}", self.meshes.len());
        self.meshes.push((name.clone(), file.clone(), scale));
        name
    }

    pub(crate) fn write_assets(&self, writer: &mut Writer) {
        if self.meshes.is_empty() {
            return;
        }
        writer.open("asset", &Attributes::new());
        for (name, file, scale) in &self.meshes {
            // MuJoCo counts from the file that is written, and that may be anywhere.
            let file = std::path::absolute(file).unwrap_or_else(|_| file.clone());
            let attributes = Attributes::new()
                .with("name", name)
                .with("file", file.display())
                .numbers("scale", scale)
                // Has no mass: the volume does not matter, and that of a thin part may be zero.
                .with("inertia", "shell");
            writer.element("mesh", &attributes);
        }
        writer.close();
    }

    /// The shapes of a body.
    pub(crate) fn write(&self, body: usize, geoms: &mut Names, writer: &mut Writer) {
        for geom in self.geoms.iter().filter(|geom| geom.body == body) {
            let name = geoms.take(&format!("{}_visual", geom.link));
            let mut attributes = pose(
                Attributes::new().with("name", name).with("type", geom.kind),
                &geom.at,
            );
            if !geom.size.is_empty() {
                attributes = attributes.numbers("size", &geom.size);
            }
            if let Some(mesh) = &geom.mesh {
                attributes = attributes.with("mesh", mesh);
            }
            if let Some(rgba) = geom.colour {
                attributes = attributes.numbers("rgba", &rgba);
            }
            let attributes = attributes
                .with("contype", 0)
                .with("conaffinity", 0)
                .with("group", 2)
                .with("mass", 0);
            writer.element("geom", &attributes);
        }
    }
}
