//! What a URDF file really contains, and where.
//!
//! urdf-rs fills in zeros for elements that are missing and skips words that are not numbers. This pass
//! over the XML makes sure that everything the model needs is there, so that no default is ever taken by
//! accident, and keeps the position of each element for later messages.

use roxmltree::{Document, Node};
use wbqp::robot::RobotError;

use crate::source::Source;

/// Largest magnitude of a length, mass or inertia, SI. Beyond it products overflow; no robot is near it.
const LARGEST: f64 = 1e9;

/// Deepest nesting of elements. URDF itself needs six.
const DEEPEST: usize = 64;

/// The links and joints of a file, in its order.
pub(super) struct Outline {
    pub(super) links: Vec<Link>,
    pub(super) joints: Vec<Joint>,
}

/// Where a link is.
pub(super) struct Link {
    pub(super) name: String,
    /// Byte offset of the element.
    pub(super) offset: usize,
    /// Byte offset of `<inertial>`, if there is one.
    pub(super) inertial: Option<usize>,
}

/// Where a joint is and which links it names.
pub(super) struct Joint {
    pub(super) name: String,
    /// Byte offset of the element.
    pub(super) offset: usize,
    pub(super) parent: String,
    pub(super) child: String,
    pub(super) fixed: bool,
}

impl Link {
    /// As messages call it.
    pub(super) fn label(&self) -> String {
        format!("link `{}`", self.name)
    }
}

impl Joint {
    /// As messages call it.
    pub(super) fn label(&self) -> String {
        format!("joint `{}`", self.name)
    }
}

/// Reads the outline and refuses what is missing or is not a number.
pub(super) fn check(source: &Source<'_>) -> Result<Outline, RobotError> {
    let document = Document::parse(source.text).map_err(|e| {
        let at = e.pos();
        RobotError::Syntax {
            place: wbqp::robot::Place::at(source.file, at.row as usize, at.col as usize),
            what: format!("malformed XML: {}", without_position(&e.to_string())),
        }
    })?;
    let root = document.root_element();
    if root.tag_name().name() != "robot" {
        return Err(RobotError::Syntax {
            place: source.place(offset(root)),
            what: format!(
                "is not a URDF: the outermost element is <{}>, not <robot>",
                root.tag_name().name()
            ),
        });
    }
    name(source, root, "<robot>")?;
    nesting(source, &document)?;
    let mut outline = Outline {
        links: Vec::new(),
        joints: Vec::new(),
    };
    for node in root.children().filter(Node::is_element) {
        if node
            .tag_name()
            .namespace()
            .is_some_and(|n| n.contains("xacro"))
        {
            return source.refuse(
                offset(node),
                "<xacro>",
                "this is a xacro file; expand it first: xacro robot.urdf.xacro > robot.urdf",
            );
        }
        match node.tag_name().name() {
            "link" => outline.links.push(link(source, node)?),
            "joint" => outline.joints.push(joint(source, node)?),
            _ => {}
        }
    }
    Ok(outline)
}

/// urdf-rs recurses into elements: depth costs stack.
fn nesting(source: &Source<'_>, document: &Document<'_>) -> Result<(), RobotError> {
    let mut depths: Vec<usize> = Vec::new();
    for node in document.descendants() {
        let parent = node.parent().and_then(|p| depths.get(p.id().get_usize()));
        let depth = parent.map_or(0, |d| d + 1);
        if depth > DEEPEST {
            return Err(RobotError::Syntax {
                place: source.place(offset(node)),
                what: format!("elements are nested more than {DEEPEST} deep"),
            });
        }
        depths.push(depth);
    }
    Ok(())
}

fn link(source: &Source<'_>, node: Node<'_, '_>) -> Result<Link, RobotError> {
    let name = name(source, node, "<link>")?;
    let element = format!("link `{name}`");
    let at = Reader { source, element };
    let inertial = at.child(node, "inertial")?;
    if let Some(inertial) = inertial {
        at.origin(inertial)?;
        let mass = at.required(inertial, "mass")?;
        let value = at.number(mass, "value")?;
        if value <= 0.0 {
            return at.refuse(
                mass,
                format!("mass is {value} kg, must be positive; a link that is a frame only needs no <inertial>"),
            );
        }
        at.bounded(mass, "value", value)?;
        let inertia = at.required(inertial, "inertia")?;
        for key in ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"] {
            let value = at.number(inertia, key)?;
            at.bounded(inertia, key, value)?;
        }
    }
    Ok(Link {
        name,
        offset: offset(node),
        inertial: inertial.map(offset),
    })
}

fn joint(source: &Source<'_>, node: Node<'_, '_>) -> Result<Joint, RobotError> {
    let name = name(source, node, "<joint>")?;
    let element = format!("joint `{name}`");
    let at = Reader { source, element };
    let kind = at.text(node, "type")?;
    match kind {
        "revolute" | "continuous" | "prismatic" | "fixed" => {}
        "floating" | "planar" | "spherical" => {
            return at.refuse(
                node,
                format!(
                    "type `{kind}` is not supported; use revolute, continuous, prismatic and fixed joints \
                     (a floating base needs no joint)"
                ),
            );
        }
        _ => {
            return at.refuse(
                node,
                format!("unknown type `{kind}`; known: revolute, continuous, prismatic, fixed"),
            );
        }
    }
    if let Some(mimic) = at.child(node, "mimic")? {
        return at.refuse(mimic, "mimic is not supported yet");
    }
    at.origin(node)?;
    let [parent, child] = ["parent", "child"].map(|tag| {
        let node = at.required(node, tag)?;
        at.text(node, "link").map(str::to_owned)
    });
    let fixed = kind == "fixed";
    if !fixed {
        if let Some(axis) = at.child(node, "axis")? {
            let xyz = at.three(axis, "xyz")?;
            if xyz == [0.0; 3] {
                return at.refuse(axis, "axis is 0 0 0: it has no direction");
            }
        }
        at.limits(node, kind)?;
        if let Some(dynamics) = at.child(node, "dynamics")? {
            for key in ["damping", "friction"] {
                if dynamics.has_attribute(key) {
                    let value = at.number(dynamics, key)?;
                    if !value.is_finite() || value < 0.0 {
                        return at.refuse(
                            dynamics,
                            format!("{key} is {value}, must be finite and not negative"),
                        );
                    }
                }
            }
        }
    }
    Ok(Joint {
        name,
        offset: offset(node),
        parent: parent?,
        child: child?,
        fixed,
    })
}

/// Reads the parts of one link or joint and names it in errors.
struct Reader<'a> {
    source: &'a Source<'a>,
    element: String,
}

impl Reader<'_> {
    fn refuse<T>(&self, node: Node<'_, '_>, what: impl Into<String>) -> Result<T, RobotError> {
        self.source.refuse(offset(node), &self.element, what)
    }

    /// The only child of that name, if any.
    fn child<'n, 'i>(
        &self,
        node: Node<'n, 'i>,
        tag: &str,
    ) -> Result<Option<Node<'n, 'i>>, RobotError> {
        let mut found = node
            .children()
            .filter(|c| c.is_element() && c.tag_name().name() == tag);
        let first = found.next();
        match found.next() {
            Some(second) => self.refuse(second, format!("<{tag}> is given twice; keep one")),
            None => Ok(first),
        }
    }

    fn required<'n, 'i>(&self, node: Node<'n, 'i>, tag: &str) -> Result<Node<'n, 'i>, RobotError> {
        match self.child(node, tag)? {
            Some(child) => Ok(child),
            None => self.refuse(node, format!("<{tag}> is missing")),
        }
    }

    fn text<'n>(&self, node: Node<'n, '_>, key: &str) -> Result<&'n str, RobotError> {
        match node.attribute(key) {
            Some(text) => Ok(text),
            None => self.refuse(
                node,
                format!("<{}> has no attribute `{key}`", node.tag_name().name()),
            ),
        }
    }

    /// A number that is not NaN; infinite is allowed.
    fn number(&self, node: Node<'_, '_>, key: &str) -> Result<f64, RobotError> {
        let text = self.text(node, key)?;
        match text.trim().parse::<f64>() {
            Ok(value) if !value.is_nan() => Ok(value),
            _ => self.refuse(
                node,
                format!(
                    "<{}> {key}=\"{text}\" is not a number",
                    node.tag_name().name()
                ),
            ),
        }
    }

    fn bounded(&self, node: Node<'_, '_>, key: &str, value: f64) -> Result<(), RobotError> {
        if value.abs() <= LARGEST {
            return Ok(());
        }
        self.refuse(
            node,
            format!(
                "<{}> {key} is {value:e}: must be at most {LARGEST:e} (SI units)",
                node.tag_name().name()
            ),
        )
    }

    /// Three numbers of reasonable size.
    fn three(&self, node: Node<'_, '_>, key: &str) -> Result<[f64; 3], RobotError> {
        let text = self.text(node, key)?;
        let numbers: Result<Vec<f64>, _> = text.split_whitespace().map(str::parse).collect();
        let three = numbers.ok().and_then(|n| <[f64; 3]>::try_from(n).ok());
        match three {
            Some(three) if !three.iter().any(|x| x.is_nan()) => {
                for value in three {
                    self.bounded(node, key, value)?;
                }
                Ok(three)
            }
            _ => self.refuse(
                node,
                format!(
                    "<{}> {key}=\"{text}\" is not three numbers separated by spaces",
                    node.tag_name().name()
                ),
            ),
        }
    }

    fn origin(&self, node: Node<'_, '_>) -> Result<(), RobotError> {
        let Some(origin) = self.child(node, "origin")? else {
            return Ok(());
        };
        if origin.has_attribute("quat_xyzw") {
            return self.refuse(origin, "quat_xyzw is not supported yet; write it as rpy");
        }
        for key in ["xyz", "rpy"] {
            if origin.has_attribute(key) {
                self.three(origin, key)?;
            }
        }
        Ok(())
    }

    fn limits(&self, node: Node<'_, '_>, kind: &str) -> Result<(), RobotError> {
        let ranged = kind != "continuous";
        let keys = if ranged {
            "lower, upper, effort and velocity"
        } else {
            "effort and velocity"
        };
        let Some(limit) = self.child(node, "limit")? else {
            return self.refuse(
                node,
                format!("<limit> is missing; a {kind} joint needs {keys}"),
            );
        };
        for key in ["effort", "velocity"] {
            if !limit.has_attribute(key) {
                return self.refuse(
                    limit,
                    format!("<limit> has no `{key}`; a {kind} joint needs {keys}"),
                );
            }
        }
        let effort = self.number(limit, "effort")?;
        let velocity = self.number(limit, "velocity")?;
        if effort < 0.0 {
            return self.refuse(
                limit,
                format!("effort limit is {effort}, must not be negative"),
            );
        }
        if velocity <= 0.0 {
            return self.refuse(
                limit,
                format!("velocity limit is {velocity}, must be positive"),
            );
        }
        if ranged {
            for key in ["lower", "upper"] {
                if !limit.has_attribute(key) {
                    return self.refuse(
                        limit,
                        format!(
                            "<limit> has no `{key}`; a {kind} joint needs {keys} \
                             (a revolute joint that turns for ever is `continuous`)"
                        ),
                    );
                }
            }
            let lower = self.number(limit, "lower")?;
            let upper = self.number(limit, "upper")?;
            if lower == f64::INFINITY || upper == f64::NEG_INFINITY {
                return self.refuse(
                    limit,
                    format!("range {lower} to {upper} has no position in it"),
                );
            }
            if lower > upper {
                return self.refuse(
                    limit,
                    format!("lower limit {lower} is above upper limit {upper}"),
                );
            }
        }
        Ok(())
    }
}

fn name(source: &Source<'_>, node: Node<'_, '_>, element: &str) -> Result<String, RobotError> {
    match node.attribute("name") {
        Some(name) if !name.trim().is_empty() => Ok(name.to_owned()),
        _ => source.refuse(offset(node), element, "has no name"),
    }
}

fn offset(node: Node<'_, '_>) -> usize {
    node.range().start
}

/// roxmltree ends its messages with ` at 1:2`; ours begin with the place.
fn without_position(message: &str) -> &str {
    message.rsplit_once(" at ").map_or(message, |(what, at)| {
        let position = at.chars().all(|c| c.is_ascii_digit() || c == ':');
        if position { what } else { message }
    })
}
