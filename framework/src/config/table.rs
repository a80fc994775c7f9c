//! Reads one table: refuses unknown keys, asks for missing ones, and finds every bad value.
//!
//! Serde stops at the first error. What is unknown or missing is read off the JSON Schema instead, and bad
//! values are found by reading what is [left](Rest) without them.

use serde_json::Value;
use toml::{
    Spanned,
    de::{DeTable, DeValue, ValueDeserializer},
};

use super::{
    ConfigErrorKind as Kind, in_words,
    report::{At, Report, Span, Step},
};
use crate::{
    input::Rest,
    plugin::{AnyConstraint, AnyFallbackLaw, AnyReference, AnyTask},
    qp::Solver,
    registry::{self, PluginKind, schema::Node},
    suggestion::{did_you_mean, hint, list, suggestion},
};
use wbqp_robot_model::Robot;

/// A table of the file: its header's span, or the whole inline table's, and the keys.
#[derive(Clone, Debug)]
pub(super) struct Section<'t> {
    pub(super) span: Span,
    pub(super) keys: DeTable<'t>,
}

impl<'t> Section<'t> {
    /// Without keys, at a place.
    pub(super) fn new(span: Span) -> Self {
        Self {
            span,
            keys: DeTable::new(),
        }
    }

    /// Takes out a key.
    pub(super) fn take(&mut self, key: &str) -> Option<Spanned<DeValue<'t>>> {
        self.keys.remove(key)
    }

    fn to_deserializer(&self) -> ValueDeserializer<'t> {
        deserializer(&self.span, &self.keys)
    }
}

fn deserializer<'t>(span: &Span, keys: &DeTable<'t>) -> ValueDeserializer<'t> {
    Spanned::new(span.clone(), DeValue::Table(keys.clone())).into()
}

/// Reads `type` and the keys of the plug-in it names. `entry_keys` are known as well: the caller took them.
pub(super) fn plugin<P: PluginKind + ?Sized>(
    mut section: Section<'_>,
    entry_keys: &[&str],
    at: &At,
    report: &mut Report<'_>,
) -> Option<Box<P>> {
    let Some(tag) = section.take("type") else {
        report.add(
            Kind::MissingKey,
            Some(section.span),
            at,
            "key `type` is missing",
        );
        return None;
    };
    let span = tag.span();
    let DeValue::String(tag) = tag.into_inner() else {
        report.add(Kind::Value, Some(span), at, "key `type` must be a string");
        return None;
    };
    let Some(plugin) = registry::find::<P>(&tag) else {
        let known: Vec<_> = P::plugins().iter().map(|plugin| plugin.tag).collect();
        let kind = P::NAME;
        let hint = if let Some(other) = kind_of(&tag) {
            format!("; it is a {other}{}", home_of(other))
        } else if known.is_empty() {
            format!("; no {kind} is linked: add `use my_plugins as _;`")
        } else {
            let hint = match hint(&tag, &known) {
                near if near.is_empty() => {
                    "; is its crate linked? `use my_plugins as _;`".to_owned()
                }
                near => near,
            };
            format!("{hint} (known: {})", list(&known))
        };
        report.add(
            Kind::UnknownType,
            Some(span),
            at,
            format!("unknown {kind} type `{tag}`{hint}"),
        );
        return None;
    };
    let mut known = vec!["type"];
    known.extend_from_slice(entry_keys);
    read(
        section,
        plugin.described().as_value(),
        &known,
        plugin.load,
        at,
        report,
    )
}

/// The kind of plug-in that has a tag, if there is one.
fn kind_of(tag: &str) -> Option<&'static str> {
    let mut kinds = [
        registry::find::<dyn AnyTask>(tag).map(|_| "task"),
        registry::find::<dyn AnyConstraint>(tag).map(|_| "constraint"),
        registry::find::<dyn AnyReference>(tag).map(|_| "reference"),
        registry::find::<dyn Robot>(tag).map(|_| "robot"),
        registry::find::<dyn Solver>(tag).map(|_| "solver"),
        registry::find::<dyn AnyFallbackLaw>(tag).map(|_| "fallback"),
    ]
    .into_iter()
    .flatten();
    kinds.next()
}

/// Where a kind of plug-in is named.
fn home_of(kind: &str) -> String {
    match kind {
        "task" | "constraint" => format!(": list it as `[[{kind}]]`"),
        "reference" => ": name it in a task, `reference = { type = \"…\", … }`".to_owned(),
        other => format!(": name it in `[{other}]`"),
    }
}

/// Reads a table whose keys a schema describes; nothing if anything is wrong with it.
pub(super) fn read<'t, T>(
    mut section: Section<'t>,
    schema: &Value,
    other_keys: &[&str],
    load: impl Fn(ValueDeserializer<'t>) -> Result<T, toml::de::Error>,
    at: &At,
    report: &mut Report<'_>,
) -> Option<T> {
    let before = report.len();
    let mut inspection = Inspection {
        at,
        report,
        damaged: Vec::new(),
    };
    let Section { span, keys } = &mut section;
    inspection.table(Node::root(schema), span, keys, other_keys, &mut Vec::new());
    let damaged = inspection.damaged;
    let mut error = match load(section.to_deserializer()) {
        Ok(value) => return (report.len() == before).then_some(value),
        Err(error) => error,
    };
    let Section { span: whole, keys } = section;
    let mut rest = Rest::new(whole.clone(), keys, damaged);
    let size = rest.values();
    loop {
        if let Some(path) = rest.path_of(&error) {
            let span = error.span().unwrap_or_else(|| whole.clone());
            let message = in_words(error.message());
            report.add(Kind::Value, Some(span), &at.then(&path), message);
        }
        if !rest.take_out(&error) {
            return None;
        }
        if !report.may_read_again(size) {
            let message =
                "what else may be wrong here is not looked for; correct what is told first";
            report.add(Kind::Value, Some(whole), at, message);
            return None;
        }
        error = load(deserializer(&whole, rest.left())).err()?;
    }
}

/// Deserialises one value, reporting under its key.
pub(super) fn value<T: serde::de::DeserializeOwned>(
    value: Spanned<DeValue<'_>>,
    at: &At,
    report: &mut Report<'_>,
) -> Option<T> {
    let span = value.span();
    match T::deserialize(ValueDeserializer::from(value)) {
        Ok(value) => Some(value),
        Err(error) => {
            let span = error.span().unwrap_or(span);
            report.add(Kind::Value, Some(span), at, in_words(error.message()));
            None
        }
    }
}

/// Compares a table with its schema. Takes out what it reports, and remembers which tables lost a key.
struct Inspection<'a, 'r> {
    at: &'a At,
    report: &'a mut Report<'r>,
    damaged: Vec<Vec<Step>>,
}

impl Inspection<'_, '_> {
    fn table(
        &mut self,
        node: Node<'_>,
        span: &Span,
        table: &mut DeTable<'_>,
        other_keys: &[&str],
        path: &mut Vec<Step>,
    ) {
        let at = self.at.then(path);
        if let Some(keys) = node.keys() {
            let unknown: Vec<_> = table
                .keys()
                .filter(|key| !keys.known.contains(&&**key.get_ref()))
                .cloned()
                .collect();
            // A missing key that is there with a slip in it is told once.
            let mut meant = Vec::new();
            for key in unknown {
                let name: &str = key.get_ref();
                let mut known = keys.known.clone();
                known.extend_from_slice(other_keys);
                known.sort_unstable();
                let hint = if let Some(table) = inner_table(node, name) {
                    format!("; it belongs into `{table}`: `{table}.{name} = …`")
                } else {
                    // Of two letters every name is next to every other.
                    meant.extend(did_you_mean(name, &known).filter(|key| key.len() > 2));
                    suggestion(name, &known)
                };
                let message = format!("unknown key `{name}`{hint}");
                self.report
                    .add(Kind::UnknownKey, Some(key.span()), &at, message);
                table.remove(name);
            }
            for key in keys.required {
                if !table.contains_key(key) {
                    if !meant.contains(&key) {
                        let meaning = node.meaning(key).map(|what| format!(": {what}"));
                        let meaning = meaning.unwrap_or_default();
                        self.report.add(
                            Kind::MissingKey,
                            Some(span.clone()),
                            &at,
                            format!("key `{key}` is missing{meaning}"),
                        );
                    }
                    self.damaged.push(path.clone());
                }
            }
        }
        let mut faulty = Vec::new();
        for (key, value) in table.iter_mut() {
            let name: &str = key.get_ref();
            let Some(node) = node.property(name) else {
                continue;
            };
            path.push(Step::Key(name.to_owned()));
            if !self.value(node, value, path) {
                faulty.push(name.to_owned());
            }
            path.pop();
        }
        for key in faulty {
            table.remove(key.as_str());
            self.damaged.push(path.clone());
        }
    }

    /// False if the value cannot be used at all.
    fn value(
        &mut self,
        node: Node<'_>,
        value: &mut Spanned<DeValue<'_>>,
        path: &mut Vec<Step>,
    ) -> bool {
        let span = value.span();
        if let Some(kind) = node.plugin() {
            return self.plugin(kind, span, value.get_ref(), path);
        }
        match value.get_mut() {
            DeValue::Table(table) => {
                self.table(node, &span, table, &[], path);
                true
            }
            DeValue::Array(elements) => {
                // Serde would take a list for the keys of a table in their order, and stop at the last place of a list
                // of fixed length.
                let wrong = if node.is_table() {
                    Some("must be a table, is a list".to_owned())
                } else {
                    let most = node.most_elements().filter(|most| elements.len() > *most);
                    most.map(|most| format!("has {} values, must have {most}", elements.len()))
                };
                if let Some(wrong) = wrong {
                    let at = self.at.then(path);
                    self.report.add(Kind::Value, Some(span), &at, wrong);
                    return false;
                }
                let Some(node) = node.element() else {
                    return true;
                };
                let mut usable = true;
                for (index, element) in elements.iter_mut().enumerate() {
                    path.push(Step::Index(index));
                    usable &= self.value(node, element, path);
                    path.pop();
                }
                usable
            }
            _ => true,
        }
    }

    /// Loads a nested plug-in through its registry, for its errors alone: typetag loses their places.
    fn plugin(&mut self, kind: &str, span: Span, value: &DeValue<'_>, path: &[Step]) -> bool {
        let at = self.at.then(path);
        let DeValue::Table(keys) = value else {
            let message = format!("must be a table: {{ type = \"…\", … }} names a {kind}");
            self.report.add(Kind::Value, Some(span), &at, message);
            return false;
        };
        let section = Section {
            span,
            keys: keys.clone(),
        };
        let report = &mut *self.report;
        match kind {
            "task" => plugin::<dyn AnyTask>(section, &[], &at, report).is_some(),
            "constraint" => plugin::<dyn AnyConstraint>(section, &[], &at, report).is_some(),
            "reference" => plugin::<dyn AnyReference>(section, &[], &at, report).is_some(),
            "robot" => plugin::<dyn Robot>(section, &[], &at, report).is_some(),
            "solver" => plugin::<dyn Solver>(section, &[], &at, report).is_some(),
            "fallback" => plugin::<dyn AnyFallbackLaw>(section, &[], &at, report).is_some(),
            _ => true,
        }
    }
}

/// The table of a table that has a key.
fn inner_table<'s>(node: Node<'s>, key: &str) -> Option<&'s str> {
    let mut properties = node.properties()?.iter();
    properties.find_map(|(table, about)| {
        let inner = node.at(about);
        let is_there = inner.plugin().is_none() && inner.keys()?.known.contains(&key);
        is_there.then_some(table.as_str())
    })
}
