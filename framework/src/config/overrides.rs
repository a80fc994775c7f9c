//! Values that replace those of a file, one by one: what a scenario's case changes.

use std::{borrow::Cow, collections::BTreeMap, fmt};

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Deserialize, Serialize, Serializer};
use toml::{
    Spanned, Table, Value,
    de::{DeTable, DeValue},
};

use super::{
    ConfigError, ConfigErrorKind as Kind,
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

    /// The keys that lead to it, as [`key_path`] reads them.
    fn path(&self) -> String {
        let (kind, name) = self.target.parts();
        let keys = [Some(kind), name, Some(&self.key)];
        let keys = keys.into_iter().flatten().map(|key| {
            let bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
            if !key.is_empty() && key.chars().all(bare) {
                key.to_owned()
            } else {
                Value::from(key).to_string()
            }
        });
        keys.collect::<Vec<_>>().join(".")
    }
}

/// Values that are put into a file's tables before they are read: existing keys are replaced, others added.
///
/// An override of `type` with another plug-in's tag replaces the plug-in: its keys in the file no longer
/// count, those that are overridden as well do.
///
/// Deserialises from, and serialises to, a table in the shape of the file with names as keys:
/// ```
/// use wbqp::{config::Overrides, toml};
///
/// let from_text: Overrides = toml::from_str("controller.rate = 500\ntask.force.feedback = 'off'")?;
/// let from_code = Overrides::new()
///     .with("controller.rate", 500)
///     .with("task.force.feedback", "off");
/// assert_eq!(from_text, from_code);
/// # Ok::<(), toml::de::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(from = "Tables")]
pub struct Overrides {
    list: Vec<Override>,
    /// Those with a path that no file has: an error of whatever they are applied to.
    refused: Vec<Refused>,
}

/// An override whose path leads nowhere.
#[derive(Clone, Debug, PartialEq)]
struct Refused {
    path: String,
    message: String,
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "override {}: {}", self.path, self.message)
    }
}

impl Overrides {
    /// The tables of a controller's file, where every path begins.
    pub const TABLES: [&str; 8] = [
        "controller",
        "robot",
        "solver",
        "fallback",
        "measurement",
        "contact",
        "task",
        "constraint",
    ];

    /// None.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds one, named by a [path](key_path) such as `controller.rate`, `task.force.feedback` or
    /// `contact."left foot".friction`; of two for the same key the later counts. A path that is none, or of a table
    /// that no file has, is an error of the configuration that the overrides are applied to.
    #[must_use]
    pub fn with(mut self, path: &str, value: impl Into<Value>) -> Self {
        match of_path(path, value.into()) {
            Ok(one) => self.append(&one),
            Err(message) => self.refused.push(Refused {
                path: path.to_owned(),
                message,
            }),
        }
        self
    }

    /// Adds those of another list behind its own.
    pub fn append(&mut self, other: &Self) {
        self.list.extend_from_slice(&other.list);
        self.refused.extend_from_slice(&other.refused);
    }

    /// The path and the value of the one that an error is about, if it is about one of these; of two for the same key
    /// the later, which counts.
    pub fn of_error(&self, error: &ConfigError) -> Option<(String, &Value)> {
        let is_it = |each: &&Override| {
            let rest = error.subject.strip_prefix(&each.subject());
            // The error may be of something inside the value.
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
        };
        let found = self.list.iter().rev().find(is_it)?;
        Some((found.path(), &found.value))
    }

    /// All, in the order in which they were added.
    pub(super) fn iter(&self) -> impl Iterator<Item = &Override> {
        self.list.iter()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty() && self.refused.is_empty()
    }
}

/// The keys of a dotted path, each a bare word or quoted, as TOML has them; nothing if the text is none.
///
/// ```
/// use wbqp::config::key_path;
///
/// let keys = |path| key_path(path).unwrap_or_default();
/// assert_eq!(keys("task.force.feedback"), ["task", "force", "feedback"]);
/// assert_eq!(keys("task.'left arm'.kp"), ["task", "left arm", "kp"]);
/// assert_eq!(key_path("task.left arm.kp"), None);
/// assert_eq!(key_path("controller.rate = 500 #"), None);
/// ```
pub fn key_path(path: &str) -> Option<Vec<String>> {
    if path.contains('\n') {
        return None;
    }
    let line = format!("{path} = 0");
    let mut table = DeTable::parse(&line).ok()?.into_inner();
    let mut keys = Vec::new();
    loop {
        let (key, value) = table.into_iter().next()?;
        keys.push(key.into_inner().into_owned());
        let begin = value.span().start;
        match value.into_inner() {
            DeValue::Table(inner) => table = inner,
            // Elsewhere the path has a value of its own, and the rest is a comment.
            _ => return (begin + 1 == line.len()).then_some(keys),
        }
    }
}

/// What a path and a value say in a file; or what is wrong with the path.
fn of_path(path: &str, value: Value) -> Result<Overrides, String> {
    let keys = key_path(path).ok_or(
        "is no path of keys, such as `task.force.feedback`; a name with other characters than letters, digits, `_` \
         and `-` is quoted",
    )?;
    if let Some(first) = keys.first()
        && !Overrides::TABLES.contains(&first.as_str())
    {
        let hint = suggestion(first, &Overrides::TABLES);
        return Err(format!("a controller's file has no table `{first}`{hint}"));
    }
    let in_table = |value: Value, key: String| Table::from_iter([(key, value)]).into();
    let file = keys.into_iter().rev().fold(value, in_table);
    Overrides::deserialize(file).map_err(|error| error.message().to_owned())
}

impl Serialize for Overrides {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.refused.first() {
            Some(refused) => Err(serde::ser::Error::custom(refused)),
            None => Tables::from(self.list.clone()).serialize(serializer),
        }
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
                let target = target.clone();
                overrides.list.push(Override { target, key, value });
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

impl From<Vec<Override>> for Tables {
    fn from(overrides: Vec<Override>) -> Self {
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
        for Override { target, key, value } in overrides {
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
        for Refused { path, message } in &overrides.refused {
            let at = At::subject(format!("override {path}"));
            report.add(Kind::Override, None, &at, message.as_str());
        }
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
