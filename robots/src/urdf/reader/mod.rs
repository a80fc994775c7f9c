//! From the text of a URDF file to what it says.
//!
//! Everything of one file is found at once. What is not about dynamics (geometry, materials, transmissions, plug-ins)
//! is not looked at in liberal mode; in strict mode urdf-rs reads the whole file as well, and must be able to.
#![allow(non_snake_case)]

mod element;
mod limit;
mod misspelt;
mod units;
mod xacro;

use roxmltree::{Document, Node};
use wbqp::{
    model::Inertia,
    nalgebra::{Isometry3, Matrix3, Quaternion, Translation3, Unit, UnitQuaternion, Vector3},
    suggestion::suggestion,
};

use super::{
    description::{Description, Inertial, Joint, Kind, Limit, Link, Mimic},
    findings::{At, Findings, Irregularity, Quantity},
    planar,
};
use crate::{direction::direction, size::SMALLEST_MASS, xml::DEEPEST};
use element::Reader;
use xacro::{EXPAND, is_xacro};

/// What a robot has of which other programs read more than this one: no slips of `link` and `joint`.
const PARTS: &[&str] = &["link", "joint", "material", "transmission", "gazebo"];
/// What joints are; strict mode has the first four.
const TYPES: [&str; 6] = [
    "revolute",
    "continuous",
    "prismatic",
    "fixed",
    "planar",
    "floating",
];
/// Reads links and joints; what is wrong goes to `findings`. Nothing if there is no robot.
pub(super) fn read(document: &Document<'_>, findings: &mut Findings<'_>) -> Option<Description> {
    let root = document.root_element();
    if root.tag_name().name() != "robot" {
        let found = root.tag_name().name();
        findings.refuse_file(
            root.range().start,
            format!("is not a URDF: the outermost element is <{found}>, not <robot>"),
        );
        return None;
    }
    let robot_name = robot_name(root, findings);
    if let Some(deep) = too_deep(document) {
        findings.refuse_file(
            deep,
            format!("elements are nested more than {DEEPEST} deep"),
        );
        return None;
    }
    let mut description = Description {
        name: robot_name,
        offset: root.range().start,
        links: Vec::new(),
        joints: Vec::new(),
    };
    if let Some(macros) = root.descendants().skip(1).find(is_xacro) {
        let at = At {
            offset: macros.range().start,
            element: "<xacro>",
        };
        findings.refuse(at, format!("this is a xacro file; {EXPAND}"));
        return None;
    }
    let mut between = Vec::new();
    let is_own = |node: &Node<'_, '_>| {
        node.is_element() && node.tag_name().namespace() == root.tag_name().namespace()
    };
    for node in root.children().filter(is_own) {
        match node.tag_name().name() {
            "link" => description.links.extend(link(node, findings)),
            "joint" => match joint(node, findings) {
                Some(planar) if planar.kind == Kind::Planar => {
                    let (joints, links) = planar::parts(&planar);
                    description.joints.extend(joints);
                    between.extend(links);
                }
                other => description.joints.extend(other),
            },
            tag => {
                let element = "<robot>".to_owned();
                let mut robot = Reader { element, findings };
                robot.doubt_name(node, format_args!("it has <{tag}>"), tag, PARTS);
            }
        }
    }
    description.links.extend(between);
    units::doubt_lengths(&description, findings);
    Some(description)
}

fn robot_name(root: Node<'_, '_>, findings: &mut Findings<'_>) -> String {
    match root.attribute("name") {
        Some(name) if xacro::is_unexpanded(name) => {
            xacro::refuse_name(root, "<robot>", name, findings);
            name.to_owned()
        }
        Some(name) if !name.trim().is_empty() => name.to_owned(),
        _ => {
            let file = std::path::Path::new(findings.source.file);
            let stem = file.file_stem().unwrap_or_default().to_string_lossy();
            let name = if stem.is_empty() {
                "robot".into()
            } else {
                stem
            };
            let at = At {
                offset: root.range().start,
                element: "<robot>",
            };
            findings.repair(
                at,
                Irregularity::note("has no name", format!("called `{name}`, like the file"))
                    .refused_as("has no name"),
            );
            name.into_owned()
        }
    }
}

/// A place where elements are nested too deep: readers recurse, and depth costs stack.
fn too_deep(document: &Document<'_>) -> Option<usize> {
    let mut depths: Vec<usize> = Vec::new();
    for node in document.descendants() {
        let parent = node.parent().and_then(|p| depths.get(p.id().get_usize()));
        let depth = parent.map_or(0, |d| d + 1);
        if depth > DEEPEST {
            return Some(node.range().start);
        }
        depths.push(depth);
    }
    None
}

fn link(node: Node<'_, '_>, findings: &mut Findings<'_>) -> Option<Link> {
    let name = name(node, "<link>", findings)?;
    let mut reader = Reader {
        element: format!("link `{name}`"),
        findings,
    };
    reader.misspelt(node);
    let inertial = reader.child(node, "inertial");
    Some(Link {
        name,
        offset: node.range().start,
        inertial: inertial.and_then(|inertial| reader.inertial(inertial)),
        is_between: false,
    })
}

fn joint(node: Node<'_, '_>, findings: &mut Findings<'_>) -> Option<Joint> {
    let name = name(node, "<joint>", findings)?;
    let mut reader = Reader {
        element: format!("joint `{name}`"),
        findings,
    };
    reader.misspelt(node);
    let kind = reader.kind(node);
    let mimic = reader.mimic(node, kind?);
    let X_PJ = reader.origin(node);
    let [parent, child] = ["parent", "child"].map(|tag| {
        let node = reader.required(node, tag)?;
        reader.text(node, "link").map(str::to_owned)
    });
    let kind = kind?;
    let axis = match kind {
        Kind::Fixed | Kind::Floating => Some(Vector3::x_axis()),
        _ => reader.axis(node),
    };
    let moves = !matches!(kind, Kind::Fixed | Kind::Floating);
    let (limit, [damping, friction]) = if moves {
        (reader.limit(node, kind), reader.dynamics(node))
    } else {
        (Limit::default(), [0.0; 2])
    };
    Some(Joint {
        name,
        offset: node.range().start,
        kind,
        parent: parent?,
        child: child?,
        X_PJ: X_PJ?,
        axis: axis?,
        limit,
        damping,
        friction,
        mimic,
        part_of: None,
    })
}

impl Reader<'_, '_> {
    /// `<origin>`; the identity if there is none.
    fn origin(&mut self, node: Node<'_, '_>) -> Option<Isometry3<f64>> {
        let Some(origin) = self.child(node, "origin") else {
            return Some(Isometry3::identity());
        };
        let mut part = |key: &str| {
            if origin.has_attribute(key) {
                self.three(origin, key)
            } else {
                Some([0.0; 3])
            }
        };
        let (xyz, rpy) = (part("xyz"), part("rpy"));
        let rotation = if origin.has_attribute("quat_xyzw") {
            self.quaternion(origin)?
        } else {
            // URDF's rpy are about fixed axes: x first, then y, then z.
            let [roll, pitch, yaw] = rpy?;
            self.doubt_rpy(origin, [roll, pitch, yaw]);
            UnitQuaternion::from_euler_angles(roll, pitch, yaw)
        };
        let [x, y, z] = xyz?;
        Some(Isometry3::from_parts(Translation3::new(x, y, z), rotation))
    }

    /// `quat_xyzw`, of URDF 1.2.
    fn quaternion(&mut self, origin: Node<'_, '_>) -> Option<UnitQuaternion<f64>> {
        if self.findings.is_strict() {
            self.refuse(origin, "quat_xyzw is not supported yet; write it as rpy");
            return None;
        }
        let [x, y, z, w] = self.numbers(origin, "quat_xyzw", "four")?;
        let quaternion = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-6);
        if quaternion.is_none() {
            self.refuse(origin, "quat_xyzw is zero: it has no direction");
        }
        quaternion
    }

    fn inertial(&mut self, node: Node<'_, '_>) -> Option<Inertial> {
        let X_LC = self.origin(node);
        let mass = self.required(node, "mass").and_then(|element| {
            let mass = self.number(element, "value")?;
            if mass < 0.0 || (mass == 0.0 && self.findings.is_strict()) {
                self.refuse(
                    element,
                    format!("mass is {mass} kg, must be positive; a link that is a frame only needs no <inertial>"),
                );
                return None;
            }
            if mass > 0.0 && mass < SMALLEST_MASS {
                self.refuse(
                    element,
                    format!(
                        "mass is {mass:e} kg, must be at least {SMALLEST_MASS:e} kg; a link that is a frame only needs \
                         no <inertial>"
                    ),
                );
                return None;
            }
            self.bounded(element, "value", mass)
        });
        let inertia = self.required(node, "inertia");
        let keys = ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"];
        let parts = inertia.and_then(|inertia| {
            let parts = keys.map(|key| {
                let value = self.number(inertia, key)?;
                self.bounded(inertia, key, value)
            });
            let [
                Some(ixx),
                Some(ixy),
                Some(ixz),
                Some(iyy),
                Some(iyz),
                Some(izz),
            ] = parts
            else {
                return None;
            };
            Some([ixx, ixy, ixz, iyy, iyz, izz])
        });
        let (X_LC, mass, [ixx, ixy, ixz, iyy, iyz, izz]) = (X_LC?, mass?, parts?);
        let I_cm = Matrix3::new(
            ixx, ixy, ixz, //
            ixy, iyy, iyz, //
            ixz, iyz, izz,
        );
        if mass == 0.0 && I_cm.amax() > 0.0 {
            self.repair(
                node,
                Irregularity::warning(
                    format!(
                        "has rotational inertia (up to {:e} kg·m²) without mass",
                        I_cm.amax()
                    ),
                    "taken as it is",
                )
                .remedy("set the robot's option `inertia` for this link")
                .unless_given([Quantity::Inertia]),
            );
        }
        self.doubt_extent(node, mass, &I_cm);
        Some(Inertial {
            offset: node.range().start,
            inertia: Inertia::from_com(mass, Vector3::zeros(), I_cm).transformed(&X_LC),
        })
    }

    fn kind(&mut self, node: Node<'_, '_>) -> Option<Kind> {
        let text = self.text(node, "type")?;
        let kind = match text {
            "revolute" => Kind::Revolute,
            "continuous" => Kind::Continuous,
            "prismatic" => Kind::Prismatic,
            "fixed" => Kind::Fixed,
            "planar" if !self.findings.is_strict() => Kind::Planar,
            "floating" if !self.findings.is_strict() => Kind::Floating,
            "floating" | "planar" | "spherical" => {
                self.refuse(
                    node,
                    format!(
                        "type `{text}` is not supported; use revolute, continuous, prismatic and fixed joints \
                         (a floating base needs no joint)"
                    ),
                );
                return None;
            }
            _ => {
                let known: &[&str] = if self.findings.is_strict() {
                    &TYPES[..4]
                } else {
                    &TYPES
                };
                let meant = suggestion(&text.trim().to_lowercase(), known);
                self.refuse(node, format!("unknown type `{text}`{meant}"));
                return None;
            }
        };
        Some(kind)
    }

    fn axis(&mut self, node: Node<'_, '_>) -> Option<Unit<Vector3<f64>>> {
        let Some(element) = self.child(node, "axis") else {
            return Some(Vector3::x_axis());
        };
        let axis = Vector3::from(self.three(element, "xyz")?);
        if axis == Vector3::zeros() {
            self.refuse(element, "axis is 0 0 0: it has no direction");
            return None;
        }
        let unit = direction(axis);
        if unit.is_none() {
            self.refuse(node, "axis has no direction");
        }
        unit
    }

    fn dynamics(&mut self, node: Node<'_, '_>) -> [f64; 2] {
        let Some(dynamics) = self.child(node, "dynamics") else {
            return [0.0; 2];
        };
        let keys = [
            ("damping", Quantity::Damping),
            ("friction", Quantity::Friction),
        ];
        keys.map(|(key, quantity)| {
            if !dynamics.has_attribute(key) {
                return 0.0;
            }
            let value = self.number(dynamics, key).unwrap_or_default();
            if value.is_finite() && value >= 0.0 {
                return self.bounded(dynamics, key, value).unwrap_or_default();
            }
            self.repair(
                dynamics,
                Irregularity::warning(format!("{key} is {value}"), "taken as none")
                    .remedy(format!("set the robot's option `{key}` for this joint"))
                    .unless_given([quantity])
                    .refused_as(format!("{key} is {value}, must be finite and not negative")),
            );
            0.0
        })
    }

    fn mimic(&mut self, node: Node<'_, '_>, kind: Kind) -> Option<Mimic> {
        let mimic = self.child(node, "mimic")?;
        if self.findings.is_strict() {
            self.refuse(mimic, "mimic is not supported yet");
            return None;
        }
        if kind == Kind::Fixed {
            self.repair(
                mimic,
                Irregularity::note("a fixed joint has a <mimic>", "it stays fixed"),
            );
            return None;
        }
        let leader = self.text(mimic, "joint")?.to_owned();
        let mut factor = |key: &str, default: f64| {
            if !mimic.has_attribute(key) {
                return Some(default);
            }
            let value = self.number(mimic, key)?;
            self.bounded(mimic, key, value)
        };
        let (multiplier, offset) = (factor("multiplier", 1.0), factor("offset", 0.0));
        Some(Mimic {
            at: mimic.range().start,
            leader,
            multiplier: multiplier?,
            offset: offset?,
        })
    }
}

fn name(node: Node<'_, '_>, element: &str, findings: &mut Findings<'_>) -> Option<String> {
    match node.attribute("name") {
        Some(name) if xacro::is_unexpanded(name) => {
            xacro::refuse_name(node, element, name, findings);
            None
        }
        Some(name) if !name.trim().is_empty() => Some(name.to_owned()),
        _ => {
            let offset = node.range().start;
            findings.refuse(At { offset, element }, "has no name");
            None
        }
    }
}
