//! Reads one table: refuses unknown keys, asks for missing ones, and finds every bad value.
//!
//! Serde stops at the first error. What is unknown or missing is read off the JSON Schema instead, and bad
//! values are found by a loop: deserialise, note the error, take out the key it points at, again.

use serde_json::Value;
use toml::{
    Spanned,
    de::{DeArray, DeTable, DeValue, ValueDeserializer},
};

use super::{
    ConfigErrorKind as Kind, in_words,
    report::{At, Report, Span, Step},
};
use crate::{
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
        Spanned::new(self.span.clone(), DeValue::Table(self.keys.clone())).into()
    }
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
    let mut damaged = inspection.damaged;
    let mut original = None;
    loop {
        let error = match load(section.to_deserializer()) {
            Ok(value) => return (report.len() == before).then_some(value),
            Err(error) => error,
        };
        // Elements of lists are counted as the file has them.
        let original: &(DeTable<'_>, usize) =
            original.get_or_insert_with(|| (section.keys.clone(), values(&section.keys)));
        let (written, size) = original;
        // What is about the table as a whole is about none of its keys, also of those that have no place of their own.
        let inner = error.span().filter(|span| *span != section.span);
        let located = |keys: &DeTable<'_>| {
            let path = inner.as_ref().and_then(|span| locate(keys, span));
            path.unwrap_or_default()
        };
        let path = located(written);
        // A table that lost a key complains about that: said already.
        if !damaged.contains(&path) {
            let span = error.span().unwrap_or_else(|| section.span.clone());
            let message = in_words(error.message());
            report.add(Kind::Value, Some(span), &at.then(&path), message);
        }
        let here = located(&section.keys);
        let depth = remove(&mut section.keys, &here)?;
        damaged.push(path.get(..depth)?.to_vec());
        if !report.may_read_again(*size) {
            let message =
                "what else may be wrong here is not looked for; correct what is told first";
            report.add(Kind::Value, Some(section.span), at, message);
            return None;
        }
    }
}

/// How many values a table has, with all that is in them.
fn values(table: &DeTable<'_>) -> usize {
    table.values().map(values_in).sum()
}

fn values_in(value: &Spanned<DeValue<'_>>) -> usize {
    1 + match value.get_ref() {
        DeValue::Table(table) => values(table),
        DeValue::Array(elements) => elements.iter().map(values_in).sum(),
        _ => 0,
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

/// The innermost value, or the key, that contains a span.
fn locate(table: &DeTable<'_>, span: &Span) -> Option<Vec<Step>> {
    table.iter().find_map(|(key, value)| {
        let step = Step::Key(key.get_ref().to_string());
        if contains(&key.span(), span) && !contains(&value.span(), span) {
            return Some(vec![step]);
        }
        locate_in(value, span).map(|mut path| {
            path.insert(0, step);
            path
        })
    })
}

fn locate_in(value: &Spanned<DeValue<'_>>, span: &Span) -> Option<Vec<Step>> {
    let inner = match value.get_ref() {
        DeValue::Table(table) => locate(table, span),
        DeValue::Array(elements) => elements.iter().enumerate().find_map(|(index, element)| {
            locate_in(element, span).map(|mut path| {
                path.insert(0, Step::Index(index));
                path
            })
        }),
        _ => None,
    };
    inner.or_else(|| contains(&value.span(), span).then(Vec::new))
}

fn contains(outer: &Span, inner: &Span) -> bool {
    outer.start <= inner.start && inner.end <= outer.end
}

/// Takes out what a path leads to: an element of a list, else the last key of the path. Gives the number of steps to
/// what lost it.
fn remove(table: &mut DeTable<'_>, path: &[Step]) -> Option<usize> {
    let last = path.iter().rposition(|step| matches!(step, Step::Key(_)))?;
    let (parent, rest) = path.split_at(last);
    let (Step::Key(key), indices) = rest.split_first()? else {
        return None;
    };
    let parent = descend(table, parent)?;
    if let Some((Step::Index(index), lists)) = indices.split_last() {
        let mut list = parent.get_mut(key.as_str())?.get_mut();
        for step in lists {
            let (DeValue::Array(elements), Step::Index(index)) = (list, step) else {
                return None;
            };
            list = elements.get_mut(*index)?.get_mut();
        }
        let DeValue::Array(elements) = list else {
            return None;
        };
        let all = std::mem::replace(elements, DeArray::new());
        let others = all.into_iter().enumerate().filter(|(at, _)| at != index);
        *elements = others.map(|(_, element)| element).collect();
        return Some(path.len() - 1);
    }
    parent.remove(key.as_str())?;
    Some(last)
}

fn descend<'a, 't>(table: &'a mut DeTable<'t>, path: &[Step]) -> Option<&'a mut DeTable<'t>> {
    let Some((first, rest)) = path.split_first() else {
        return Some(table);
    };
    let Step::Key(key) = first else { return None };
    let mut value = table.get_mut(key.as_str())?.get_mut();
    let mut rest = rest;
    while let Some((Step::Index(index), deeper)) = rest.split_first() {
        let DeValue::Array(elements) = value else {
            return None;
        };
        value = elements.get_mut(*index)?.get_mut();
        rest = deeper;
    }
    match value {
        DeValue::Table(inner) => descend(inner, rest),
        _ => None,
    }
}
