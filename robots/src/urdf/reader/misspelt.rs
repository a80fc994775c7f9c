//! Elements and attributes that no URDF has, and that look like one that counts: left out without a word, a slip of a
//! letter would be another robot.

use std::fmt::Arguments;

use roxmltree::Node;
use wbqp::suggestion::did_you_mean;

use super::element::Reader;
use crate::urdf::findings::At;

/// An element, the elements that it may have, and its attributes.
type Known = (
    &'static str,
    &'static [&'static str],
    &'static [&'static str],
);

/// What stands in links and joints and is read. What is drawn, and what other programs have put in, is not looked at.
const KNOWN: [Known; 12] = [
    ("link", &["inertial", "visual", "collision"], &["name"]),
    (
        "joint",
        &[
            "origin",
            "parent",
            "child",
            "axis",
            "limit",
            "dynamics",
            "mimic",
            "safety_controller",
            "calibration",
        ],
        &["name", "type"],
    ),
    ("inertial", &["origin", "mass", "inertia"], &[]),
    ("origin", &[], &["xyz", "rpy", "quat_xyzw"]),
    ("axis", &[], &["xyz"]),
    ("parent", &[], &["link"]),
    ("child", &[], &["link"]),
    ("limit", &[], &["lower", "upper", "velocity", "effort"]),
    ("dynamics", &[], &["damping", "friction"]),
    ("mimic", &[], &["joint", "multiplier", "offset"]),
    ("mass", &[], &["value"]),
    ("inertia", &[], &["ixx", "ixy", "ixz", "iyy", "iyz", "izz"]),
];

/// Those of them that are not read, nor what stands beside links and joints: a slip there changes no robot.
const PASSED_OVER: [&str; 7] = [
    "visual",
    "collision",
    "safety_controller",
    "calibration",
    "material",
    "transmission",
    "gazebo",
];

/// A name with a longer or shorter end is another program's: `collision_checking` is no slip.
const ADDED: usize = 2;

impl Reader<'_, '_> {
    /// Looks through an element and what is read of it.
    pub(super) fn misspelt(&mut self, node: Node<'_, '_>) {
        let tag = node.tag_name();
        let Some((_, children, attributes)) = KNOWN.iter().find(|(name, ..)| *name == tag.name())
        else {
            return;
        };
        for attribute in node.attributes().filter(|key| key.namespace().is_none()) {
            let name = attribute.name();
            self.doubt_name(
                node,
                format_args!("<{}> has `{name}`", tag.name()),
                name,
                attributes,
            );
        }
        let own = |child: &Node<'_, '_>| {
            child.is_element() && child.tag_name().namespace() == tag.namespace()
        };
        for child in node.children().filter(own) {
            let name = child.tag_name().name();
            self.doubt_name(child, format_args!("it has <{name}>"), name, children);
            if children.contains(&name) {
                self.misspelt(child);
            }
        }
    }

    /// A name that is none of the known ones, and near to one.
    pub(super) fn doubt_name(
        &mut self,
        node: Node<'_, '_>,
        what: Arguments<'_>,
        name: &str,
        known: &[&str],
    ) {
        if known.contains(&name) {
            return;
        }
        // A capital letter is the commonest slip, and counts for none.
        let near = did_you_mean(&name.to_lowercase(), known)
            .filter(|near| near.len().abs_diff(name.len()) <= ADDED && !PASSED_OVER.contains(near));
        let Some(near) = near.filter(|_| self.findings.may_suggest()) else {
            return;
        };
        let at = At {
            offset: node.range().start,
            element: &self.element,
        };
        let found = format!("{what}, which no URDF has; did you mean `{near}`?");
        self.findings.leave_out(at, &found);
    }
}
