//! What xacro would replace: a file has to be expanded before it is read.

use roxmltree::Node;

use crate::urdf::findings::{At, Findings};

/// What to do with it.
pub(super) const EXPAND: &str = "expand it first: xacro robot.urdf.xacro > robot.urdf";

/// Whether an element is one that xacro replaces.
pub(super) fn is_xacro(node: &Node<'_, '_>) -> bool {
    let tag = node.tag_name();
    // Where nothing declares the prefix, its colon is gone.
    node.is_element()
        && (tag.namespace().is_some_and(|n| n.contains("xacro"))
            || tag.name().starts_with("xacro_"))
}

/// Whether a text has what xacro would replace.
pub(super) fn is_unexpanded(text: &str) -> bool {
    text.contains("${") || text.contains("$(")
}

/// Refuses a name that has.
pub(super) fn refuse_name(
    node: Node<'_, '_>,
    element: &str,
    name: &str,
    findings: &mut Findings<'_>,
) {
    let offset = node.range().start;
    let what = format!("`{name}` is written for xacro; {EXPAND}");
    findings.refuse(At { offset, element }, what);
}

/// What is to be said of a text that is no number.
pub(super) fn hint(text: &str) -> String {
    if is_unexpanded(text) {
        format!("; it is written for xacro: {EXPAND}")
    } else {
        String::new()
    }
}
