//! Whether links and joints form one tree, and the tree seen from its base.
#![allow(non_snake_case)]

use std::collections::HashMap;

use wbqp::{nalgebra::Isometry3, suggestion::suggestion};

use super::{
    description::{Description, Joint, Kind},
    findings::{At, Findings},
};

/// The tree by index into the description.
pub(super) struct Tree {
    /// The base.
    pub(super) root: usize,
    /// What the file's joints make the base.
    pub(super) own_root: usize,
    /// Where a floating joint has the base in the world, if it says.
    pub(super) X_WR: Option<Isometry3<f64>>,
    /// Per link, the joints that lead away from the base, in the file's order.
    pub(super) edges: Vec<Vec<Edge>>,
}

/// A joint as one comes to it from the base.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Edge {
    pub(super) joint: usize,
    /// The link that it leads to.
    pub(super) link: usize,
    /// Whether that is the joint's parent.
    pub(super) is_reversed: bool,
}

/// Which link a joint hangs on and which it carries.
struct Ends {
    parent: usize,
    child: usize,
}

/// Finds the tree; duplicate and unknown names, links with two parents, several roots and cycles go to `findings`.
/// `root` is another link that is to be the base.
pub(super) fn find(
    description: &Description,
    root: Option<&str>,
    findings: &mut Findings<'_>,
) -> Option<Tree> {
    let Description { links, joints, .. } = description;
    if links.is_empty() {
        findings.refuse_file(description.offset, "the robot has no links");
        return None;
    }
    let by_name = unique_names(description, findings)?;
    let ends = ends(description, &by_name, findings)?;
    let mut carried_by: Vec<Option<&Joint>> = vec![None; links.len()];
    for (joint, ends) in joints.iter().zip(&ends) {
        let slot = &mut carried_by[ends.child];
        if let Some(other) = slot {
            findings.refuse(
                At {
                    offset: joint.offset,
                    element: &joint.label(),
                },
                format!(
                    "link `{}` is already the child of joint `{}`; closed chains are not supported",
                    joint.child, other.name
                ),
            );
            return None;
        }
        *slot = Some(joint);
    }
    let roots: Vec<usize> = (0..links.len())
        .filter(|&i| carried_by[i].is_none())
        .collect();
    let own_root = match roots.as_slice() {
        [root] => *root,
        [] => {
            cycle(description, 0, findings);
            return None;
        }
        [_, second, ..] => {
            let names: Vec<&str> = roots.iter().map(|&i| links[i].name.as_str()).collect();
            findings.refuse(
                At {
                    offset: links[*second].offset,
                    element: "tree",
                },
                format!(
                    "several links are not the child of any joint: `{}`; a robot has one root, join the others to it",
                    names.join("`, `")
                ),
            );
            return None;
        }
    };
    let root = match root {
        None => own_root,
        Some(name) => {
            let Some(&link) = by_name.get(name) else {
                let known: Vec<&str> = links.iter().map(|l| l.name.as_str()).collect();
                let robot = &description.name;
                let hint = suggestion(name, &known);
                findings.refuse_as(crate::options::refuse(
                    "root",
                    format!("robot `{robot}` has no link `{name}`{hint}"),
                ));
                return None;
            };
            link
        }
    };
    let (edges, reached) = outwards(root, links.len(), &ends);
    if let Some(link) = reached.iter().position(|&r| !r) {
        cycle(description, link, findings);
        return None;
    }
    let mut tree = Tree {
        root,
        own_root,
        X_WR: None,
        edges,
    };
    tree.take_floating_joint(description);
    Some(tree)
}

impl Tree {
    /// A root that only carries the whole robot on a floating joint is the world.
    fn take_floating_joint(&mut self, description: &Description) {
        let has_mass = description.links[self.root]
            .inertial
            .is_some_and(|i| i.inertia.mass > 0.0);
        if has_mass {
            return;
        }
        let [edge] = self.edges[self.root][..] else {
            return;
        };
        let joint = &description.joints[edge.joint];
        if joint.kind == Kind::Floating && !edge.is_reversed {
            if self.own_root == self.root {
                self.own_root = edge.link;
            }
            self.root = edge.link;
            self.X_WR = Some(joint.X_PJ).filter(|pose| *pose != Isometry3::identity());
        }
    }
}

fn unique_names<'d>(
    description: &'d Description,
    findings: &mut Findings<'_>,
) -> Option<HashMap<&'d str, usize>> {
    let mut by_name: HashMap<&str, usize> = HashMap::new();
    let mut unique = true;
    let mut refuse = |offset: usize, label: String, first: usize| {
        let place = findings.source.place(first);
        findings.refuse(
            At {
                offset,
                element: &label,
            },
            format!("is defined twice (first at {place}); give each a name of its own"),
        );
        unique = false;
    };
    for (i, link) in description.links.iter().enumerate() {
        match by_name.get(link.name.as_str()) {
            Some(&first) => refuse(link.offset, link.label(), description.links[first].offset),
            None => {
                by_name.insert(&link.name, i);
            }
        }
    }
    let mut seen: HashMap<&str, &Joint> = HashMap::new();
    for joint in &description.joints {
        match seen.get(joint.name.as_str()) {
            Some(first) => refuse(joint.offset, joint.label(), first.offset),
            None => {
                seen.insert(&joint.name, joint);
            }
        }
    }
    unique.then_some(by_name)
}

fn ends(
    description: &Description,
    by_name: &HashMap<&str, usize>,
    findings: &mut Findings<'_>,
) -> Option<Vec<Ends>> {
    let mut ends = Vec::with_capacity(description.joints.len());
    let mut known: Vec<&str> = Vec::new();
    for joint in &description.joints {
        let label = joint.label();
        let at = At {
            offset: joint.offset,
            element: &label,
        };
        let mut find = |role: &str, name: &str| {
            let found = by_name.get(name).copied();
            if found.is_none() {
                if known.is_empty() {
                    known = description.links.iter().map(|l| l.name.as_str()).collect();
                }
                let hint = if findings.may_suggest() {
                    suggestion(name, &known)
                } else {
                    String::new()
                };
                findings.refuse(at, format!("{role} link `{name}` does not exist{hint}"));
            }
            found
        };
        let found = (find("parent", &joint.parent), find("child", &joint.child));
        let (Some(parent), Some(child)) = found else {
            continue;
        };
        if parent == child {
            findings.refuse(
                at,
                format!("has link `{}` as parent and as child", joint.parent),
            );
            continue;
        }
        ends.push(Ends { parent, child });
    }
    (ends.len() == description.joints.len()).then_some(ends)
}

/// The joints that lead away from a link, per link, and which links they come to.
fn outwards(root: usize, links: usize, ends: &[Ends]) -> (Vec<Vec<Edge>>, Vec<bool>) {
    let mut at: Vec<Vec<Edge>> = vec![Vec::new(); links];
    for (joint, &Ends { parent, child }) in ends.iter().enumerate() {
        at[parent].push(Edge {
            joint,
            link: child,
            is_reversed: false,
        });
        at[child].push(Edge {
            joint,
            link: parent,
            is_reversed: true,
        });
    }
    let mut reached = vec![false; links];
    let mut stack = vec![root];
    reached[root] = true;
    while let Some(link) = stack.pop() {
        at[link].retain(|edge| !reached[edge.link]);
        for edge in &at[link] {
            reached[edge.link] = true;
            stack.push(edge.link);
        }
    }
    (at, reached)
}

fn cycle(description: &Description, link: usize, findings: &mut Findings<'_>) {
    let link = &description.links[link];
    let at = At {
        offset: link.offset,
        element: &link.label(),
    };
    findings.refuse(
        at,
        "is part of, or hangs on, a cycle of joints; a robot is a tree with one root",
    );
}
