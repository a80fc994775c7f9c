//! The parts of one element: children, attributes, numbers.

use roxmltree::Node;

use super::xacro;
use crate::{
    size::LARGEST_NUMBER,
    urdf::findings::{At, Findings, Irregularity},
};

/// Reads the parts of one link or joint and names it in what it finds.
pub(super) struct Reader<'r, 'a> {
    pub(super) element: String,
    pub(super) findings: &'r mut Findings<'a>,
}

impl Reader<'_, '_> {
    pub(super) fn refuse(&mut self, node: Node<'_, '_>, what: impl Into<String>) {
        let at = At {
            offset: node.range().start,
            element: &self.element,
        };
        self.findings.refuse(at, what);
    }

    pub(super) fn repair(&mut self, node: Node<'_, '_>, irregularity: Irregularity) {
        let at = At {
            offset: node.range().start,
            element: &self.element,
        };
        self.findings.repair(at, irregularity);
    }

    /// The only child of that name, if any; the first of several. One of another namespace is another thing.
    pub(super) fn child<'n, 'i>(&mut self, node: Node<'n, 'i>, tag: &str) -> Option<Node<'n, 'i>> {
        let mut found = node
            .children()
            .filter(|c| c.is_element() && c.tag_name().name() == tag)
            .filter(|c| c.tag_name().namespace() == node.tag_name().namespace());
        let first = found.next();
        if let Some(second) = found.next() {
            self.repair(
                second,
                Irregularity::warning(format!("<{tag}> is given twice"), "the first counts")
                    .refused_as(format!("<{tag}> is given twice; keep one")),
            );
        }
        first
    }

    pub(super) fn required<'n, 'i>(
        &mut self,
        node: Node<'n, 'i>,
        tag: &str,
    ) -> Option<Node<'n, 'i>> {
        let child = self.child(node, tag);
        if child.is_none() {
            self.refuse(node, format!("<{tag}> is missing"));
        }
        child
    }

    pub(super) fn text<'n>(&mut self, node: Node<'n, '_>, key: &str) -> Option<&'n str> {
        let text = node.attribute(key);
        if text.is_none() {
            let tag = node.tag_name().name();
            self.refuse(node, format!("<{tag}> has no attribute `{key}`"));
        }
        text
    }

    /// A number that is not NaN; infinite is allowed.
    pub(super) fn number(&mut self, node: Node<'_, '_>, key: &str) -> Option<f64> {
        let text = self.text(node, key)?;
        match text.trim().parse::<f64>() {
            Ok(value) if !value.is_nan() => Some(value),
            _ => {
                let tag = node.tag_name().name();
                let hint = xacro::hint(text);
                self.refuse(
                    node,
                    format!("<{tag}> {key}=\"{text}\" is not a number{hint}"),
                );
                None
            }
        }
    }

    pub(super) fn bounded(&mut self, node: Node<'_, '_>, key: &str, value: f64) -> Option<f64> {
        if value.abs() <= LARGEST_NUMBER {
            return Some(value);
        }
        let tag = node.tag_name().name();
        self.refuse(
            node,
            format!("<{tag}> {key} is {value:e}: must be at most {LARGEST_NUMBER:e} (SI units)"),
        );
        None
    }

    /// Some numbers of reasonable size.
    pub(super) fn numbers<const N: usize>(
        &mut self,
        node: Node<'_, '_>,
        key: &str,
        count: &str,
    ) -> Option<[f64; N]> {
        let text = self.text(node, key)?;
        let numbers: Result<Vec<f64>, _> = text.split_whitespace().map(str::parse).collect();
        let numbers = numbers.ok().and_then(|n| <[f64; N]>::try_from(n).ok());
        if let Some(numbers) = numbers.filter(|n| !n.iter().any(|x| x.is_nan())) {
            for value in numbers {
                self.bounded(node, key, value)?;
            }
            return Some(numbers);
        }
        let tag = node.tag_name().name();
        self.refuse(
            node,
            format!(
                "<{tag}> {key}=\"{text}\" is not {count} numbers separated by spaces{}",
                xacro::hint(text)
            ),
        );
        None
    }

    pub(super) fn three(&mut self, node: Node<'_, '_>, key: &str) -> Option<[f64; 3]> {
        self.numbers(node, key, "three")
    }
}
