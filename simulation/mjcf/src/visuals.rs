//! What a robot looks like, from its URDF.
#![allow(non_snake_case)]

use std::{
    collections::HashMap,
    path::{Path, PathBuf},
};

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use roxmltree::{Document, Node, ParsingOptions};
use wbqp::robot::RobotModel;

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
    shapes: Vec<Shape>,
    /// Name, file and scale.
    meshes: Vec<(String, PathBuf, [f64; 3])>,
}

#[derive(Debug)]
struct Shape {
    link: String,
    body: usize,
    at: Isometry3<f64>,
    kind: &'static str,
    size: Vec<f64>,
    mesh: Option<String>,
    colour: Option<[f64; 4]>,
}

/// The visuals of the first URDF among a robot's sources. One that cannot be drawn is left out and noted.
pub(crate) fn of(robot: &RobotModel, notes: &mut Vec<String>) -> Visuals {
    let mut visuals = Visuals::default();
    for source in &robot.sources {
        let options = ParsingOptions {
            allow_dtd: true,
            ..ParsingOptions::default()
        };
        let Ok(document) = Document::parse_with_options(&source.contents, options) else {
            continue;
        };
        let root = document.root_element();
        if root.tag_name().name() == "robot" {
            visuals.read(robot, root, Path::new(&source.name), notes);
            break;
        }
    }
    visuals
}

fn child<'a, 'i>(node: Node<'a, 'i>, name: &str) -> Option<Node<'a, 'i>> {
    node.children().find(|child| child.has_tag_name(name))
}

fn numbers<const N: usize>(node: Node<'_, '_>, attribute: &str) -> Option<[f64; N]> {
    let text = node.attribute(attribute)?;
    let values: Vec<f64> = text
        .split_whitespace()
        .map_while(|x| x.parse().ok())
        .collect();
    let values: [f64; N] = values.try_into().ok()?;
    values.iter().all(|x| x.is_finite()).then_some(values)
}

fn origin(node: Node<'_, '_>) -> Isometry3<f64> {
    let origin = child(node, "origin");
    let of = |name| {
        origin
            .and_then(|o| numbers::<3>(o, name))
            .unwrap_or_default()
    };
    let ([x, y, z], [roll, pitch, yaw]) = (of("xyz"), of("rpy"));
    let rotation = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
    Isometry3::from_parts(Vector3::new(x, y, z).into(), rotation)
}

fn colour(visual: Node<'_, '_>, palette: &HashMap<&str, [f64; 4]>) -> Option<[f64; 4]> {
    let material = child(visual, "material")?;
    let own = child(material, "color").and_then(|c| numbers::<4>(c, "rgba"));
    own.or_else(|| palette.get(material.attribute("name")?).copied())
}

/// Where a mesh is: beside the URDF, or, for `package://name/…`, under a folder above it that has or is the package.
fn file_of(reference: &str, urdf: &Path) -> Option<PathBuf> {
    let folder = urdf.parent()?;
    let Some(package) = reference.strip_prefix("package://") else {
        let path = reference.strip_prefix("file://").unwrap_or(reference);
        return Some(folder.join(path)).filter(|path| path.is_file());
    };
    let (name, rest) = package.split_once('/')?;
    folder.ancestors().find_map(|above| {
        let inside = above.join(package);
        let is_it = above.file_name().is_some_and(|own| own == name);
        let itself = above.join(rest);
        (inside.is_file().then_some(inside))
            .or_else(|| (is_it && itself.is_file()).then_some(itself))
    })
}

impl Visuals {
    fn read(
        &mut self,
        robot: &RobotModel,
        root: Node<'_, '_>,
        urdf: &Path,
        notes: &mut Vec<String>,
    ) {
        let elements = |node: Node<'_, '_>, name: &'static str| {
            let found: Vec<_> = node
                .children()
                .filter(|c| c.has_tag_name(name))
                .map(|c| c.id())
                .collect();
            found
        };
        let document = root.document();
        let node = |id| document.get_node(id);
        let palette: HashMap<&str, [f64; 4]> = elements(root, "material")
            .into_iter()
            .filter_map(node)
            .filter_map(|material| {
                let rgba = child(material, "color").and_then(|c| numbers::<4>(c, "rgba"))?;
                Some((material.attribute("name")?, rgba))
            })
            .collect();
        for link in elements(root, "link").into_iter().filter_map(node) {
            let Some(name) = link.attribute("name") else {
                continue;
            };
            let model = &robot.model;
            let frame = model
                .frame(name)
                .and_then(|id| model.frames().get(id.index()));
            let Some(frame) = frame else {
                continue;
            };
            for visual in elements(link, "visual").into_iter().filter_map(node) {
                let at = frame.X_BF * origin(visual);
                let geometry = child(visual, "geometry").and_then(|g| g.first_element_child());
                let shape = geometry.ok_or_else(|| "no geometry".to_owned());
                match shape.and_then(|geometry| self.shape(geometry, urdf)) {
                    Ok((kind, size, mesh)) => self.shapes.push(Shape {
                        link: name.to_owned(),
                        body: frame.body.index(),
                        at,
                        kind,
                        size,
                        mesh,
                        colour: colour(visual, &palette),
                    }),
                    Err(what) => {
                        notes.push(format!("a visual of link `{name}` is left out: {what}"));
                    }
                }
            }
        }
    }

    fn shape(
        &mut self,
        geometry: Node<'_, '_>,
        urdf: &Path,
    ) -> Result<(&'static str, Vec<f64>, Option<String>), String> {
        let number = |name: &str| {
            let found = numbers::<1>(geometry, name)
                .map(|[x]| x)
                .filter(|x| *x > 0.0);
            found.ok_or_else(|| format!("its `{name}` is no positive number"))
        };
        match geometry.tag_name().name() {
            "box" => {
                let size = numbers::<3>(geometry, "size").filter(|s| s.iter().all(|x| *x > 0.0));
                let size = size.ok_or("its `size` is not three positive numbers")?;
                Ok(("box", size.map(|x| 0.5 * x).to_vec(), None))
            }
            "sphere" => Ok(("sphere", vec![number("radius")?], None)),
            kind @ ("cylinder" | "capsule") => {
                let kind = if kind == "cylinder" {
                    "cylinder"
                } else {
                    "capsule"
                };
                Ok((kind, vec![number("radius")?, 0.5 * number("length")?], None))
            }
            "mesh" => {
                let reference = geometry
                    .attribute("filename")
                    .ok_or("a mesh without a file")?;
                let file = file_of(reference, urdf)
                    .ok_or_else(|| format!("there is no file {reference}"))?;
                let extension = file.extension().map(|e| e.to_string_lossy().to_lowercase());
                if !extension.is_some_and(|e| MESHES.contains(&e.as_str())) {
                    return Err(format!("MuJoCo reads no such mesh: {reference}"));
                }
                let scale = numbers::<3>(geometry, "scale").unwrap_or([1.0; 3]);
                Ok(("mesh", Vec::new(), Some(self.mesh(file, scale))))
            }
            other => Err(format!("<{other}> is no shape of MuJoCo's")),
        }
    }

    fn mesh(&mut self, file: PathBuf, scale: [f64; 3]) -> String {
        let known = self
            .meshes
            .iter()
            .find(|(_, f, s)| *f == file && *s == scale);
        if let Some((name, ..)) = known {
            return name.clone();
        }
        let name = format!("mesh_{}", self.meshes.len());
        self.meshes.push((name.clone(), file, scale));
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
        for shape in self.shapes.iter().filter(|shape| shape.body == body) {
            let name = geoms.take(&format!("{}_visual", shape.link));
            let mut attributes = pose(
                Attributes::new()
                    .with("name", name)
                    .with("type", shape.kind),
                &shape.at,
            );
            if !shape.size.is_empty() {
                attributes = attributes.numbers("size", &shape.size);
            }
            if let Some(mesh) = &shape.mesh {
                attributes = attributes.with("mesh", mesh);
            }
            if let Some(rgba) = shape.colour {
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
