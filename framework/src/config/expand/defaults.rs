//! Weights and gains that a file does not say, as plug-ins declare them in their schema.
//!
//! | extension | at | meaning |
//! |---|---|---|
//! | `x-weight` | the plug-in | the weight of an entry without one: a number, or a list with one per row |
//! | `x-critical` | a key | the key of a stiffness: without a value this damping is critical, `2 √stiffness` per axis |

use serde_json::Value as Json;

use super::{List, Notes, Span, Texts, value};
use crate::{
    config::{document::Document, table::Section},
    plugin::{AnyConstraint, AnyTask},
    registry::{
        self, PluginKind,
        schema::{CRITICAL, Node, WEIGHT},
    },
};

/// A value to be put in.
struct Missing {
    list: List,
    index: usize,
    key: String,
    text: String,
    span: Span,
    why: Option<String>,
}

/// Puts weights and gains in.
pub(in crate::config) fn fill<'t>(
    document: &mut Document<'t>,
    texts: &'t Texts,
    notes: &mut Notes,
) {
    let mut missing = Vec::new();
    of_all::<dyn AnyTask>(List::Task, &document.tasks, &mut missing);
    of_all::<dyn AnyConstraint>(List::Constraint, &document.constraints, &mut missing);
    let written = missing.iter().map(|one| one.text.clone()).collect();
    let written = texts.defaults.get_or_init(|| written);
    for (one, text) in missing.into_iter().zip(written) {
        let sections = match one.list {
            List::Task => &mut document.tasks,
            _ => &mut document.constraints,
        };
        let (Some(section), Some(value)) =
            (sections.get_mut(one.index), value::parsed(text, &one.span))
        else {
            continue;
        };
        let key = toml::Spanned::new(super::key_at(&one.span), one.key.clone().into());
        section.keys.insert(key, value);
        if let Some(why) = one.why {
            notes.add(one.list, one.index, one.key, why);
        }
    }
}

fn of_all<P: PluginKind + ?Sized>(
    list: List,
    sections: &[Section<'_>],
    missing: &mut Vec<Missing>,
) {
    let is_soft_unless_said = list == List::Task;
    for (index, section) in sections.iter().enumerate() {
        let Some(tag) = value::string(section, "type") else {
            continue;
        };
        let Some(plugin) = registry::find::<P>(tag) else {
            continue;
        };
        let schema = plugin.described();
        let node = Node::root(schema.as_value());
        // In the header: an error of the table as a whole is not one of this value.
        let start = section.span.start;
        let place = start..section.span.end.min(start + 1);
        let mut add = |key: &str, text: String, why: Option<String>| {
            missing.push(Missing {
                list,
                index,
                key: key.to_owned(),
                text,
                span: place.clone(),
                why,
            });
        };
        let is_hard = match section.keys.get("hardness") {
            Some(hardness) => hardness.get_ref().as_str() == Some("hard"),
            None => !is_soft_unless_said,
        };
        if let Some(weight) = node.value().get(WEIGHT)
            && !is_hard
            && !section.keys.contains_key("weight")
        {
            let why = format!("default weight of `{tag}`");
            add("weight", weight.to_string(), Some(why));
        }
        for (key, about) in node.properties().into_iter().flatten() {
            let Some(stiffness) = about.get(CRITICAL).and_then(Json::as_str) else {
                continue;
            };
            if section.keys.contains_key(key.as_str()) {
                continue;
            }
            match critical(section, node, stiffness) {
                Some(damping) => {
                    let why = format!("critically damped: 2 sqrt({stiffness})");
                    add(key, damping, Some(why));
                }
                // What is wrong with the stiffness is said of the stiffness.
                None => add(key, "0.0".to_owned(), None),
            }
        }
    }
}

/// `2 √k` of a number or a list.
fn critical(section: &Section<'_>, node: Node<'_>, stiffness: &str) -> Option<String> {
    let damping = |k: &f64| format!("{:?}", 2.0 * k.max(0.0).sqrt());
    let Some(given) = section.keys.get(stiffness) else {
        let default = node
            .properties()?
            .get(stiffness)?
            .get("default")?
            .as_f64()?;
        return Some(damping(&default));
    };
    let numbers = value::numbers(given.get_ref())?;
    if !numbers.iter().all(|k| k.is_finite()) {
        return None;
    }
    let dampings: Vec<String> = numbers.iter().map(damping).collect();
    Some(if given.get_ref().is_array() {
        format!("[{}]", dampings.join(", "))
    } else {
        dampings.concat()
    })
}
