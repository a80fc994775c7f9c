//! Values that replace those of a file, one by one: what a scenario's case changes.

use std::{borrow::Cow, collections::BTreeMap};

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Deserialize, Serialize};
use toml::{
    Spanned, Table, Value,
    de::{DeTable, DeValue},
};

use super::{
    ConfigErrorKind as Kind,
    document::Document,
    report::{At, Report, Span},
    table::Section,
};
use crate::{plugin::ENTRY_KEYS, settings::Target, suggestion::suggestion};

/// One replaced value.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Override {
    /// Which table.
    target: Target,
    /// Which of its keys; the plug-in's or the framework's, but not `name`.
    key: String,
    /// The new value; a table replaces the whole old table.
    value: Value,
}

impl Override {
    fn subject(&self) -> String {
        format!("override {}.`{}`", self.target, self.key)
    }
}

/// Values that are put into a file's tables before they are read: existing keys are replaced, others added.
///
/// An override of `type` with another plug-in's tag replaces the plug-in: its keys in the file no longer
/// count, those that are overridden as well do.
///
/// Deserialises from, and serialises to, a table in the shape of the file with names as keys:
/// ```
/// use wbqp::{config::Overrides, settings::Target, toml};
///
/// let from_text: Overrides = toml::from_str("controller.rate = 500\ntask.force.feedback = 'off'")?;
/// let from_code = Overrides::new()
///     .with(Target::Controller, "rate", 500)
///     .with(Target::Task("force".into()), "feedback", "off");
/// assert_eq!(from_text, from_code);
/// # Ok::<(), toml::de::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "Tables", into = "Tables")]
pub struct Overrides {
    list: Vec<Override>,
}

impl Overrides {
    /// None.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds one.
    #[must_use]
    pub fn with(mut self, target: Target, key: &str, value: impl Into<Value>) -> Self {
        self.push(target, key, value);
        self
    }

    /// Adds one; of two for the same key the later counts.
    pub fn push(&mut self, target: Target, key: &str, value: impl Into<Value>) {
        self.list.push(Override {
            target,
            key: key.to_owned(),
            value: value.into(),
        });
    }

    /// Adds those of another list behind its own.
    pub fn append(&mut self, other: &Self) {
        self.list.extend_from_slice(&other.list);
    }

    /// All, in the order in which they were added.
    pub(super) fn iter(&self) -> impl Iterator<Item = &Override> {
        self.list.iter()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }
}

impl JsonSchema for Overrides {
    fn schema_name() -> Cow<'static, str> {
        "Overrides".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        Tables::json_schema(generator)
    }
}

/// Keys with values of any type.
type AnyTable = BTreeMap<String, serde_json::Value>;

/// Values put into the controller's file, in its shape, with names as keys.
#[derive(Clone, Serialize, Deserialize, JsonSchema)]
#[serde(
    deny_unknown_fields,
    expecting = "tables of values, like task.<name>.<key> = …"
)]
struct Tables {
    #[serde(default, skip_serializing_if = "Table::is_empty")]
    #[schemars(with = "AnyTable")]
    controller: Table,
    #[serde(default, skip_serializing_if = "Table::is_empty")]
    #[schemars(with = "AnyTable")]
    robot: Table,
    #[serde(default, skip_serializing_if = "Table::is_empty")]
    #[schemars(with = "AnyTable")]
    solver: Table,
    #[serde(default, skip_serializing_if = "Table::is_empty")]
    #[schemars(with = "AnyTable")]
    fallback: Table,
    #[serde(default, skip_serializing_if = "Table::is_empty")]
    #[schemars(with = "AnyTable")]
    measurement: Table,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    #[schemars(with = "BTreeMap<String, AnyTable>")]
    contact: BTreeMap<String, Table>,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    #[schemars(with = "BTreeMap<String, AnyTable>")]
    task: BTreeMap<String, Table>,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    #[schemars(with = "BTreeMap<String, AnyTable>")]
    constraint: BTreeMap<String, Table>,
}

impl From<Tables> for Overrides {
    fn from(tables: Tables) -> Self {
        let mut overrides = Self::new();
        let mut push = |target: &Target, table: Table| {
            for (key, value) in table {
                overrides.push(target.clone(), &key, value);
            }
        };
        push(&Target::Controller, tables.controller);
        push(&Target::Robot, tables.robot);
        push(&Target::Solver, tables.solver);
        push(&Target::Fallback, tables.fallback);
        push(&Target::Measurement, tables.measurement);
        for (name, table) in tables.contact {
            push(&Target::Contact(name), table);
        }
        for (name, table) in tables.task {
            push(&Target::Task(name), table);
        }
        for (name, table) in tables.constraint {
            push(&Target::Constraint(name), table);
        }
        overrides
    }
}

impl From<Overrides> for Tables {
    fn from(overrides: Overrides) -> Self {
        let mut tables = Self {
            controller: Table::new(),
            robot: Table::new(),
            solver: Table::new(),
            fallback: Table::new(),
            measurement: Table::new(),
            contact: BTreeMap::new(),
            task: BTreeMap::new(),
            constraint: BTreeMap::new(),
        };
        for Override { target, key, value } in overrides.list {
            let table = match target {
                Target::Controller => &mut tables.controller,
                Target::Robot => &mut tables.robot,
                Target::Solver => &mut tables.solver,
                Target::Fallback => &mut tables.fallback,
                Target::Measurement => &mut tables.measurement,
                Target::Contact(name) => tables.contact.entry(name).or_default(),
                Target::Task(name) => tables.task.entry(name).or_default(),
                Target::Constraint(name) => tables.constraint.entry(name).or_default(),
            };
            table.insert(key, value);
        }
        tables
    }
}

/// The text behind the end of the file that belongs to an override.
pub(super) struct Applied {
    pub(super) span: Span,
    pub(super) subject: String,
    pub(super) key: String,
}

/// The overrides' values as text, placed behind the end of the file: what is read from them has spans that
/// no part of the file has.
pub(super) struct OverrideText {
    text: String,
    applied: Vec<Span>,
}

impl OverrideText {
    pub(super) fn new(overrides: &Overrides, file_length: usize) -> Self {
        let mut text = " ".repeat(file_length + 1);
        let mut applied = Vec::new();
        for (index, each) in overrides.iter().enumerate() {
            let start = text.len();
            text.push_str(&format!("o{index} = {}\n", each.value));
            applied.push(start..text.len());
        }
        Self { text, applied }
    }

    pub(super) fn applied(&self, overrides: &Overrides) -> Vec<Applied> {
        self.applied
            .iter()
            .zip(overrides.iter())
            .map(|(span, each)| Applied {
                span: span.clone(),
                subject: each.subject(),
                key: each.key.clone(),
            })
            .collect()
    }

    /// Puts the values into the document. Gives back those for entries that it does not have: they may come.
    pub(super) fn apply<'t>(
        &'t self,
        overrides: &Overrides,
        document: &mut Document<'t>,
        report: &mut Report<'_>,
    ) -> Vec<Pending<'t>> {
        let mut pending = Vec::new();
        let mut values = match DeTable::parse(&self.text) {
            Ok(values) => values.into_inner(),
            Err(error) => {
                let at = At::subject("overrides");
                report.add(Kind::Override, None, &at, error.message());
                return pending;
            }
        };
        // A replaced plug-in first: it takes its keys with it.
        let mut order: Vec<_> = overrides.iter().enumerate().zip(&self.applied).collect();
        order.sort_by_key(|((_, each), _)| each.key != "type");
        let directory = document.directory();
        for ((index, each), span) in order {
            let Some(value) = values.remove(format!("o{index}").as_str()) else {
                continue;
            };
            let mut refuse = |message: String| {
                report.add(Kind::Override, Some(span.clone()), &At::default(), message);
            };
            let (kind, name) = each.target.parts();
            if each.key == "name" && name.is_some() {
                refuse("the name of an entry cannot be overridden".to_owned());
                continue;
            }
            match document.target(&each.target, &directory) {
                Ok(section) => replace(section, each, span, value),
                Err(_) if name.is_some() => pending.push(Pending {
                    index,
                    span: span.clone(),
                    value,
                }),
                Err(_) => refuse(format!("the file has no table `[{kind}]`")),
            }
        }
        pending
    }

    /// Puts the rest of the values into the document, whose entries are all there now.
    pub(super) fn apply_rest<'t>(
        rest: Vec<Pending<'t>>,
        overrides: &Overrides,
        document: &mut Document<'t>,
        report: &mut Report<'_>,
    ) {
        let directory = document.directory();
        for Pending { index, span, value } in rest {
            let Some(each) = overrides.list.get(index) else {
                continue;
            };
            match document.target(&each.target, &directory) {
                Ok(section) => replace(section, each, &span, value),
                Err(known) => {
                    let (kind, name) = each.target.parts();
                    let hint = suggestion(name.unwrap_or_default(), &known);
                    let message = format!("no {kind} has this name{hint}");
                    report.add(Kind::Override, Some(span), &At::default(), message);
                }
            }
        }
    }
}

/// An override of an entry that is not there yet.
pub(super) struct Pending<'t> {
    /// Among the overrides.
    index: usize,
    span: Span,
    value: Spanned<DeValue<'t>>,
}

fn replace<'t>(
    section: &mut Section<'t>,
    each: &Override,
    span: &Span,
    value: Spanned<DeValue<'t>>,
) {
    let old = section.take(&each.key);
    let is_other = |old: &Spanned<DeValue<'_>>| old.get_ref().as_str() != value.get_ref().as_str();
    if each.key == "type" && old.as_ref().is_some_and(is_other) {
        let plugin_keys: Vec<_> = section
            .keys
            .keys()
            .filter(|key| !ENTRY_KEYS.contains(&&**key.get_ref()))
            .cloned()
            .collect();
        for key in plugin_keys {
            section.take(key.get_ref());
        }
    }
    let key_span = span.start..span.start + 1;
    section
        .keys
        .insert(Spanned::new(key_span, each.key.clone().into()), value);
}
