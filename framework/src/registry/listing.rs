//! The linked plug-ins in words: what each is, its equations, its parameters.
//!
//! Everything comes from the plug-in's rustdoc and its derived JSON Schema. The first paragraph is the summary;
//! any other that begins with a code span with `=`, `≤` or `≥` in it is an equation. Units are
//! `#[schemars(extend("x-unit" = "…"))]` on the fields, `"x-weight"` on the type is the weight of an entry without one,
//! and `"x-critical" = "kp"` on a damping says that it is critical for that stiffness unless a file says it.

use std::fmt;

use schemars::Schema;
use serde_json::Value;

use super::{
    PluginKind,
    schema::{CRITICAL, Node, WEIGHT},
};
use crate::{
    plugin::{AnyConstraint, AnyFallbackLaw, AnyReference, AnyTask},
    qp::Solver,
};
use wbqp_robot_model::Robot;

/// A plug-in in words.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PluginInfo {
    /// `task`, `constraint`, `reference`, `robot`, `solver` or `fallback`.
    pub kind: &'static str,
    /// What `type` must be.
    pub tag: &'static str,
    /// Crate, file and line of the registration.
    pub origin: &'static str,
    /// The whole description, Markdown.
    pub description: String,
    /// The weight of an entry that does not say one: a number, or a list with one per row.
    pub weight: Option<Value>,
    /// Its keys, sorted, those of nested tables behind the table.
    pub parameters: Vec<Key>,
}

/// A key of a plug-in.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Key {
    /// The key; `options.base` in a table, `points[].at` in a list of tables.
    pub key: String,
    /// What the value must be, in words.
    pub expected: String,
    /// Its unit; of numbers without one, nothing.
    pub unit: Option<String>,
    /// The value if the key is absent; nothing if the description says what happens then.
    pub default: Option<Value>,
    /// Whether the key must be there.
    pub is_required: bool,
    /// What it means, Markdown.
    pub description: String,
}

/// All plug-ins, linked or added, with their parameters: tasks, constraints, references, robots, solvers, fallback
/// laws; each kind sorted by tag.
///
/// ```
/// let mut all = wbqp::registry().into_iter();
/// let solver = all.find(|p| p.kind == "solver" && p.tag == "active_set").expect("comes with the framework");
/// let tolerance = solver.parameters.iter().find(|p| p.key == "tolerance").expect("it has one");
/// assert_eq!(tolerance.expected, "number");
/// assert!(!tolerance.is_required && tolerance.default.is_some());
/// ```
pub fn list() -> Vec<PluginInfo> {
    let mut plugins = Vec::new();
    of_kind::<dyn AnyTask>(&mut plugins);
    of_kind::<dyn AnyConstraint>(&mut plugins);
    of_kind::<dyn AnyReference>(&mut plugins);
    of_kind::<dyn Robot>(&mut plugins);
    of_kind::<dyn Solver>(&mut plugins);
    of_kind::<dyn AnyFallbackLaw>(&mut plugins);
    plugins
}

impl PluginInfo {
    /// The first paragraph of the description.
    pub fn summary(&self) -> &str {
        self.paragraphs().next().unwrap_or_default()
    }

    /// The equations: paragraphs that begin with a code span with a relation in it, but for the summary.
    pub fn equations(&self) -> impl Iterator<Item = &str> {
        self.paragraphs().skip(1).filter(|paragraph| {
            let code = paragraph
                .strip_prefix('`')
                .and_then(|rest| rest.split('`').next());
            code.is_some_and(|code| code.contains(['=', '≤', '≥']))
        })
    }

    fn paragraphs(&self) -> impl Iterator<Item = &str> {
        self.description.split("\n\n").map(str::trim)
    }
}

/// One line, then one per parameter.
impl fmt::Display for PluginInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            kind, tag, origin, ..
        } = self;
        writeln!(f, "{kind} {tag} ({origin}): {}", one_line(self.summary()))?;
        if let Some(weight) = &self.weight {
            writeln!(f, "  weight: default {weight}")?;
        }
        for parameter in &self.parameters {
            let Key { key, expected, .. } = parameter;
            let unit = parameter.unit.as_deref().unwrap_or("-");
            let default = match (&parameter.default, parameter.is_required) {
                (_, true) => "required".to_owned(),
                (Some(default), _) => format!("default {default}"),
                (None, _) => "optional".to_owned(),
            };
            let about = one_line(&parameter.description);
            writeln!(f, "  {key}: {expected} [{unit}], {default}: {about}")?;
        }
        Ok(())
    }
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn of_kind<P: PluginKind + ?Sized>(all: &mut Vec<PluginInfo>) {
    all.extend(P::plugins().iter().map(|plugin| {
        let schema: &Schema = plugin.described();
        let root = schema.as_value();
        let mut parameters = Vec::new();
        collect(Node::root(root), "", &mut parameters);
        PluginInfo {
            kind: P::NAME,
            tag: plugin.tag,
            origin: plugin.origin,
            description: description(root),
            weight: root.get(WEIGHT).cloned(),
            parameters,
        }
    }));
}

fn collect(table: Node<'_>, prefix: &str, all: &mut Vec<Key>) {
    let required = table.value().get("required").and_then(Value::as_array);
    for (key, about) in table.properties().into_iter().flatten() {
        let node = table.at(about);
        let path = format!("{prefix}{key}");
        all.push(Key {
            expected: expected(node),
            unit: about
                .get("x-unit")
                .and_then(Value::as_str)
                .map(str::to_owned),
            default: about
                .get("default")
                .filter(|value| !value.is_null())
                .cloned(),
            // A damping without a value is critical.
            is_required: required.is_some_and(|keys| keys.iter().any(|k| k == key))
                && about.get(CRITICAL).is_none(),
            description: description(about),
            key: path.clone(),
        });
        if let Some(element) = node.element() {
            collect(element, &format!("{path}[]."), all);
        } else if node.plugin().is_none() {
            collect(node, &format!("{path}."), all);
        }
    }
}

/// The description without the links of rustdoc.
fn description(about: &Value) -> String {
    let text = about.get("description").and_then(Value::as_str);
    unlinked(text.unwrap_or_default())
}

/// `` [`Name`] ``, `` [`Name`](path) `` and `[words](crate::path)` lose their brackets: those are links of rustdoc.
fn unlinked(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some((before, link)) = rest.split_once('[') {
        out.push_str(before);
        let Some((label, after)) = link.split_once(']') else {
            return out + "[" + link;
        };
        let target = after
            .strip_prefix('(')
            .and_then(|after| after.split_once(')'));
        let is_code = label.len() > 1 && label.starts_with('`') && label.ends_with('`');
        match target {
            Some((path, after)) if is_code || path.contains("::") => {
                out.push_str(label);
                rest = after;
            }
            None if is_code => {
                out.push_str(label);
                rest = after;
            }
            _ => {
                out.push('[');
                rest = link;
            }
        }
    }
    out + rest
}

/// What a value must be, in words.
fn expected(node: Node<'_>) -> String {
    let here = node.value();
    if let Some(kind) = node.plugin() {
        return format!("{kind}: a table with `type`");
    }
    if let Some(one) = here.get("const") {
        return format!("`{one}`");
    }
    if let Some(values) = here.get("enum").and_then(Value::as_array) {
        return alternatives(values.iter().map(|value| format!("`{value}`")));
    }
    for key in ["oneOf", "anyOf"] {
        if let Some(branches) = here.get(key).and_then(Value::as_array) {
            let words = branches.iter().map(|branch| expected(node.at(branch)));
            return alternatives(words.filter(|word| word != "null"));
        }
    }
    let kinds: Vec<&str> = match here.get("type") {
        Some(Value::String(kind)) => vec![kind],
        Some(Value::Array(kinds)) => kinds.iter().filter_map(Value::as_str).collect(),
        _ => return "anything".to_owned(),
    };
    let words = kinds.into_iter().filter(|kind| *kind != "null");
    alternatives(words.map(|kind| {
        match kind {
            "array" => list_of(node),
            "object" => match here
                .get("additionalProperties")
                .filter(|more| more.is_object())
            {
                Some(more) => format!("table of {} by name", plural(&expected(node.at(more)))),
                None => "table".to_owned(),
            },
            "number" | "integer" => kind.to_owned() + &range(here),
            other => other.to_owned(),
        }
    }))
}

fn list_of(node: Node<'_>) -> String {
    let element = node.element().map_or("anything".to_owned(), expected);
    let count = |key: &str| node.value().get(key).and_then(Value::as_u64);
    match (count("minItems"), count("maxItems")) {
        (Some(least), Some(most)) if least == most => {
            format!("list of {least} {}", plural(&element))
        }
        _ => format!("list of {}", plural(&element)),
    }
}

fn plural(word: &str) -> String {
    match word {
        "number" | "integer" | "string" | "table" => format!("{word}s"),
        other => other.to_owned(),
    }
}

fn alternatives(words: impl Iterator<Item = String>) -> String {
    let words: Vec<String> = words.collect();
    match words.as_slice() {
        [first @ .., last] if !first.is_empty() => format!("{} or {last}", first.join(", ")),
        _ => words.concat(),
    }
}

/// Limits that the field declares; zero below says only that it is unsigned.
fn range(here: &Value) -> String {
    let limit = |key: &str| here.get(key).and_then(Value::as_f64);
    match (limit("minimum"), limit("maximum")) {
        (Some(least), Some(most)) => format!(", {least} to {most}"),
        (None, Some(most)) => format!(", at most {most}"),
        (Some(least), None) if least != 0.0 => format!(", at least {least}"),
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_become_code() {
        assert_eq!(
            unlinked("see [`A`](crate::A), [`B`], [b](crate::B), [c](d), `[x, y]` and [`"),
            "see `A`, `B`, b, [c](d), `[x, y]` and [`"
        );
    }

    #[cfg(feature = "clarabel")]
    #[test]
    fn solvers_of_the_framework_are_listed_with_their_parameters() {
        let mut all = list().into_iter();
        let clarabel = all
            .find(|plugin| plugin.tag == "clarabel")
            .expect("is linked");
        assert!(clarabel.origin.starts_with("wbqp "), "{}", clarabel.origin);
        assert!(
            clarabel
                .parameters
                .iter()
                .all(|p| !p.description.is_empty())
        );
        let text = clarabel.to_string();
        assert!(
            text.contains("\n  max_iterations: integer [-], default 200: "),
            "{text}"
        );
        assert!(crate::registry::duplicates().is_empty());
    }
}
