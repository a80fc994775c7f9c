//! What a robot looks like: the visuals of its URDF, for programs that draw it.
#![allow(non_snake_case)]

use std::{
    collections::HashMap,
    path::{Path, PathBuf},
};

use roxmltree::Node;
use wbqp::{
    model::FrameId,
    nalgebra::{Isometry3, UnitQuaternion, Vector3},
    robot::RobotModel,
};

use crate::xml;

/// A shape on a link.
#[derive(Clone, Debug, PartialEq)]
pub struct Visual {
    /// The link's frame L.
    pub frame: FrameId,
    /// The link's name.
    pub link: String,
    /// Pose of the shape V on its link.
    pub X_LV: Isometry3<f64>,
    /// The shape.
    pub shape: Shape,
    /// Red, green, blue and opacity, 0 to 1, if the file gives any.
    pub colour: Option<[f64; 4]>,
}

/// A shape about its own origin, lengths in m.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Shape {
    /// Lengths of the edges.
    Box(Vector3<f64>),
    /// Its radius.
    Sphere(f64),
    /// Around z.
    Cylinder {
        /// Its radius.
        radius: f64,
        /// Its length.
        length: f64,
    },
    /// Around z; two half spheres close it.
    Capsule {
        /// Its radius.
        radius: f64,
        /// Without the half spheres.
        length: f64,
    },
    /// From a file.
    Mesh {
        /// Where the file is.
        file: PathBuf,
        /// Factors of the file's coordinates.
        scale: Vector3<f64>,
    },
}

/// The visuals of the first URDF among a robot's sources, and in words those that cannot be drawn. A robot that comes
/// from no URDF has none.
pub fn visuals(robot: &RobotModel) -> (Vec<Visual>, Vec<String>) {
    let (mut visuals, mut left_out) = (Vec::new(), Vec::new());
    for source in &robot.sources {
        // What the loader forgives has visuals too.
        let text = source.contents.strip_prefix('\u{feff}');
        let text = xml::forgiving(text.unwrap_or(&source.contents));
        let Ok(document) = xml::parse(&text) else {
            continue;
        };
        let root = document.root_element();
        if !root.has_tag_name("robot") {
            continue;
        }
        let urdf = Path::new(&source.name);
        let palette: HashMap<&str, [f64; 4]> = children(root, "material")
            .filter_map(|material| Some((material.attribute("name")?, rgba(material)?)))
            .collect();
        for link in children(root, "link") {
            let name = link.attribute("name").unwrap_or_default();
            let Some(frame) = robot.model.frame(name) else {
                continue;
            };
            for visual in children(link, "visual") {
                let geometry = child(visual, "geometry").and_then(|g| g.first_element_child());
                let shape = geometry.ok_or_else(|| "no geometry".to_owned());
                match shape.and_then(|geometry| read_shape(geometry, urdf)) {
                    Ok(shape) => visuals.push(Visual {
                        frame,
                        link: name.to_owned(),
                        X_LV: origin(visual),
                        shape,
                        colour: colour(visual, &palette),
                    }),
                    Err(what) => {
                        left_out.push(format!("a visual of link `{name}` is left out: {what}"));
                    }
                }
            }
        }
        break;
    }
    (visuals, left_out)
}

fn children<'a, 'i>(
    node: Node<'a, 'i>,
    name: &'static str,
) -> impl Iterator<Item = Node<'a, 'i>> + use<'a, 'i> {
    node.children().filter(move |c| c.has_tag_name(name))
}

fn child<'a, 'i>(node: Node<'a, 'i>, name: &'static str) -> Option<Node<'a, 'i>> {
    children(node, name).next()
}

fn numbers<const N: usize>(node: Node<'_, '_>, attribute: &str) -> Option<[f64; N]> {
    let text = node.attribute(attribute)?;
    let words = text.split_whitespace();
    let values: Vec<f64> = words.map_while(|x| x.parse().ok()).collect();
    let values: [f64; N] = values.try_into().ok()?;
    values.iter().all(|x| x.is_finite()).then_some(values)
}

fn origin(node: Node<'_, '_>) -> Isometry3<f64> {
    let origin = child(node, "origin");
    let of = |name| {
        let given = origin.and_then(|o| numbers::<3>(o, name));
        given.unwrap_or_default()
    };
    let ([x, y, z], [roll, pitch, yaw]) = (of("xyz"), of("rpy"));
    let rotation = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
    Isometry3::from_parts(Vector3::new(x, y, z).into(), rotation)
}

fn rgba(material: Node<'_, '_>) -> Option<[f64; 4]> {
    child(material, "color").and_then(|c| numbers(c, "rgba"))
}

fn colour(visual: Node<'_, '_>, palette: &HashMap<&str, [f64; 4]>) -> Option<[f64; 4]> {
    let material = child(visual, "material")?;
    rgba(material).or_else(|| palette.get(material.attribute("name")?).copied())
}

fn read_shape(geometry: Node<'_, '_>, urdf: &Path) -> Result<Shape, String> {
    let number = |name: &str| {
        let given = numbers::<1>(geometry, name).map(|[x]| x);
        given
            .filter(|x| *x > 0.0)
            .ok_or_else(|| format!("its `{name}` is no positive number"))
    };
    match geometry.tag_name().name() {
        "box" => {
            let size = numbers::<3>(geometry, "size").filter(|s| s.iter().all(|x| *x > 0.0));
            let size = size.ok_or("its `size` is not three positive numbers")?;
            Ok(Shape::Box(size.into()))
        }
        "sphere" => Ok(Shape::Sphere(number("radius")?)),
        kind @ ("cylinder" | "capsule") => {
            let (radius, length) = (number("radius")?, number("length")?);
            Ok(match kind {
                "cylinder" => Shape::Cylinder { radius, length },
                _ => Shape::Capsule { radius, length },
            })
        }
        "mesh" => {
            let reference = geometry.attribute("filename");
            let reference = reference.ok_or("a mesh without a file")?;
            let file = mesh_file(reference, urdf);
            let file = file.ok_or_else(|| format!("there is no file {reference}"))?;
            let scale = numbers::<3>(geometry, "scale").unwrap_or([1.0; 3]);
            let scale = scale.into();
            Ok(Shape::Mesh { file, scale })
        }
        other => Err(format!("<{other}> is no known shape")),
    }
}

/// Where a mesh is: beside the URDF, or, for `package://name/…`, under a folder above it that has or is the package.
fn mesh_file(reference: &str, urdf: &Path) -> Option<PathBuf> {
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
