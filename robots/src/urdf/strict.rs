//! What strict mode demands of a file as a whole: that urdf-rs reads it, and that each link is a rigid body.

use wbqp::{
    model::{Base, ModelError},
    robot::RobotError,
};

use super::{
    description::{Description, Kind},
    findings::{At, Findings},
    tree::Tree,
};
use crate::{options::Options, source::Source};

/// Looks at the file the way its format's reader does, then at its links.
pub(super) fn check(
    source: &Source<'_>,
    description: &Description,
    tree: &Tree,
    options: &Options,
    findings: &mut Findings<'_>,
) -> Result<(), RobotError> {
    let refuse = |what: String| RobotError::Syntax {
        place: source.place(0),
        what,
    };
    let robot = urdf_rs::read_from_string(source.text)
        .map_err(|e| refuse(format!("is not a URDF: {e}")))?;
    // Two readers have read the text: refuse it if they do not see the same links and joints.
    let links = robot.links.iter().map(|l| &l.name);
    let joints = robot.joints.iter().map(|j| &j.name);
    if !links.eq(description.links.iter().map(|l| &l.name))
        || !joints.eq(description.joints.iter().map(|j| &j.name))
    {
        return Err(refuse(
            "links and joints cannot be told apart: is it well-formed XML without entities of its own?".into(),
        ));
    }
    if Base::from(options.base) == Base::Floating {
        root_has_mass(description, tree, findings);
    }
    let mut stack = vec![tree.root];
    while let Some(index) = stack.pop() {
        let link = &description.links[index];
        if let Some(inertial) = link.inertial {
            validate(link, inertial, findings);
        }
        for edge in tree.edges[index].iter().rev() {
            stack.push(edge.link);
            let joint = &description.joints[edge.joint];
            let child = &description.links[edge.link];
            if joint.kind != Kind::Fixed && child.inertial.is_none() {
                findings.refuse(
                    At {
                        offset: child.offset,
                        element: &child.label(),
                    },
                    format!(
                        "moves on joint `{}` but has no <inertial>; give it its mass and inertia",
                        joint.name
                    ),
                );
            }
        }
    }
    Ok(())
}

fn validate(
    link: &super::description::Link,
    inertial: super::description::Inertial,
    findings: &mut Findings<'_>,
) {
    let at = At {
        offset: inertial.offset,
        element: &link.label(),
    };
    match inertial.inertia.validate(&link.name) {
        Ok(()) => {}
        Err(ModelError::Inertia { what, .. }) => {
            findings.refuse(at, format!("inertia {what}; no rigid body is like this"));
        }
        Err(other) => findings.refuse(at, other.to_string()),
    }
}

/// A floating root needs mass: its own, or that of the only link, fixed to it, that it carries.
fn root_has_mass(description: &Description, tree: &Tree, findings: &mut Findings<'_>) {
    let mut index = tree.root;
    while description.links[index].inertial.is_none() {
        let only = match tree.edges[index][..] {
            [edge] if description.joints[edge.joint].kind == Kind::Fixed => Some(edge.link),
            _ => None,
        };
        let Some(only) = only else {
            let link = &description.links[index];
            findings.refuse(
                At {
                    offset: link.offset,
                    element: &link.label(),
                },
                "is the floating base but has no <inertial>; give it its mass and inertia, \
                 or load the robot with a fixed base",
            );
            return;
        };
        index = only;
    }
}
