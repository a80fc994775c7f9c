//! Whether links and joints form one tree.

use std::collections::HashMap;

use wbqp::{robot::RobotError, suggestion::suggestion};

use super::syntax::{Joint, Outline};
use crate::source::Source;

/// The tree by index into the outline.
pub(super) struct Tree {
    /// The link that no joint carries.
    pub(super) root: usize,
    /// Per link, the joints on it in the file's order.
    pub(super) children: Vec<Vec<usize>>,
    /// Per joint, the link it carries.
    pub(super) child: Vec<usize>,
}

/// Refuses duplicate and unknown names, links with two parents, several roots and cycles.
pub(super) fn check(source: &Source<'_>, outline: &Outline) -> Result<Tree, RobotError> {
    let Outline { links, joints } = outline;
    if links.is_empty() {
        return Err(RobotError::Syntax {
            place: source.place(0),
            what: "the robot has no links".into(),
        });
    }
    let mut by_name: HashMap<&str, usize> = HashMap::new();
    for (i, link) in links.iter().enumerate() {
        if let Some(&first) = by_name.get(link.name.as_str()) {
            let line = links.get(first).map(|l| source.place(l.offset));
            return source.refuse(link.offset, &link.label(), twice(line));
        }
        by_name.insert(&link.name, i);
    }
    let mut seen: HashMap<&str, &Joint> = HashMap::new();
    for joint in joints {
        if let Some(first) = seen.insert(&joint.name, joint) {
            let line = Some(source.place(first.offset));
            return source.refuse(joint.offset, &joint.label(), twice(line));
        }
    }

    let mut carried_by: Vec<Option<&Joint>> = vec![None; links.len()];
    let mut children: Vec<Vec<usize>> = vec![Vec::new(); links.len()];
    let mut child = Vec::with_capacity(joints.len());
    let find = |joint: &Joint, role: &str, name: &str| {
        by_name.get(name).copied().ok_or_else(|| {
            let known: Vec<&str> = links.iter().map(|l| l.name.as_str()).collect();
            let hint = suggestion(name, &known);
            let what = format!("{role} link `{name}` does not exist{hint}");
            source.error(joint.offset, &joint.label(), what)
        })
    };
    for (j, joint) in joints.iter().enumerate() {
        let parent = find(joint, "parent", &joint.parent)?;
        let carried = find(joint, "child", &joint.child)?;
        if parent == carried {
            return source.refuse(
                joint.offset,
                &joint.label(),
                format!("has link `{}` as parent and as child", joint.parent),
            );
        }
        if let Some(slot) = carried_by.get_mut(carried) {
            if let Some(other) = slot {
                return source.refuse(
                    joint.offset,
                    &joint.label(),
                    format!(
                        "link `{}` is already the child of joint `{}`; closed chains are not supported",
                        joint.child, other.name
                    ),
                );
            }
            *slot = Some(joint);
        }
        if let Some(list) = children.get_mut(parent) {
            list.push(j);
        }
        child.push(carried);
    }

    let roots: Vec<usize> = (0..links.len())
        .filter(|&i| matches!(carried_by.get(i), Some(None)))
        .collect();
    let root = match roots.as_slice() {
        [root] => *root,
        [] => return cycle(source, outline, 0),
        [_, second, ..] => {
            let names: Vec<&str> = roots
                .iter()
                .filter_map(|&i| links.get(i))
                .map(|l| l.name.as_str())
                .collect();
            let second = links.get(*second).map_or(0, |l| l.offset);
            return source.refuse(
                second,
                "tree",
                format!(
                    "several links are not the child of any joint: `{}`; a robot has one root, join the others to it",
                    names.join("`, `")
                ),
            );
        }
    };
    let tree = Tree {
        root,
        children,
        child,
    };
    match unreachable(&tree, links.len()) {
        Some(link) => cycle(source, outline, link),
        None => Ok(tree),
    }
}

fn twice(first: Option<wbqp::robot::Place>) -> String {
    let first = first.map_or(String::new(), |p| format!(" (first at {p})"));
    format!("is defined twice{first}; give each a name of its own")
}

fn cycle<T>(source: &Source<'_>, outline: &Outline, link: usize) -> Result<T, RobotError> {
    match outline.links.get(link) {
        Some(link) => source.refuse(
            link.offset,
            &link.label(),
            "is part of, or hangs on, a cycle of joints; a robot is a tree with one root",
        ),
        None => source.refuse(0, "tree", "has a cycle of joints"),
    }
}

/// A link that the root does not carry. With one parent each, it is on a cycle or below one.
fn unreachable(tree: &Tree, links: usize) -> Option<usize> {
    let mut reached = vec![false; links];
    let mut stack = vec![tree.root];
    while let Some(link) = stack.pop() {
        if let Some(flag) = reached.get_mut(link) {
            *flag = true;
        }
        let joints = tree.children.get(link).into_iter().flatten();
        stack.extend(joints.filter_map(|&j| tree.child.get(j).copied()));
    }
    reached.iter().position(|&r| !r)
}
