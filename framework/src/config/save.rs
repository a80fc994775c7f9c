//! From a [`ControllerConfig`] to the text of a file.

use std::{fmt::Display, ops::Range};

use serde::{Serialize, ser::Error as _};
use toml::{
    de::DeTable,
    ser::{Error, ValueSerializer},
};

use super::{ControllerConfig, defaults};
use crate::{
    plugin::{Entry, Hardness, PerRow},
    settings::MeasurementLimits,
};

impl ControllerConfig {
    /// The text of a file that loads as this configuration. Keys that have the framework's defaults are left
    /// out of entries; comments and the order of keys of a file that it came from are not kept.
    ///
    /// # Errors
    /// If a plug-in has a value that TOML cannot express.
    pub fn to_toml(&self) -> Result<String, Error> {
        let mut text = String::new();
        section(&mut text, "[controller]", "controller", &self.settings)?;
        section(&mut text, "[robot]", "robot", &self.robot)?;
        section(&mut text, "[solver]", "solver", &self.solver)?;
        if keys_of("fallback", &self.fallback)? != keys_of("fallback", &defaults::fallback())? {
            section(&mut text, "[fallback]", "fallback", &self.fallback)?;
        }
        if self.measurement != MeasurementLimits::default() {
            section(&mut text, "[measurement]", "measurement", &self.measurement)?;
        }
        for contact in &self.contacts {
            let subject = format!("contact `{}`", contact.name);
            section(&mut text, "[[contact]]", &subject, contact)?;
        }
        for task in &self.tasks {
            entry(&mut text, "task", Hardness::Soft, task, &task.plugin)?;
        }
        for constraint in &self.constraints {
            let plugin = &constraint.plugin;
            entry(&mut text, "constraint", Hardness::Hard, constraint, plugin)?;
        }
        Ok(text)
    }
}

fn header(text: &mut String, header: &str) {
    if !text.is_empty() {
        text.push('\n');
    }
    text.push_str(header);
    text.push('\n');
}

fn section<T: Serialize>(
    text: &mut String,
    title: &str,
    subject: &str,
    value: &T,
) -> Result<(), Error> {
    header(text, title);
    for (key, value) in keys_of(subject, value)? {
        text.push_str(&format!("{key} = {value}\n"));
    }
    Ok(())
}

/// The framework's keys of an entry, without those that have their default.
#[derive(Serialize)]
struct EntryKeys<'a> {
    weight: Option<&'a PerRow>,
    active: Option<bool>,
    transition: Option<f64>,
    hardness: Option<Hardness>,
}

fn entry<P: ?Sized>(
    text: &mut String,
    kind: &str,
    default_hardness: Hardness,
    entry: &Entry<P>,
    plugin: &impl Serialize,
) -> Result<(), Error> {
    let subject = format!("{kind} `{}`", entry.name);
    let unweighted = entry.hardness == Hardness::Hard && entry.weight == PerRow::Uniform(1.0);
    let own = EntryKeys {
        weight: (!unweighted).then_some(&entry.weight),
        active: (!entry.active).then_some(false),
        transition: (entry.transition != 0.0).then_some(entry.transition),
        hardness: (entry.hardness != default_hardness).then_some(entry.hardness),
    };
    header(text, &format!("[[{kind}]]"));
    let name = inline(&subject, &entry.name)?;
    let (tag, plugin): (Vec<_>, Vec<_>) = keys_of(&subject, plugin)?
        .into_iter()
        .partition(|(key, _)| key == "type");
    let keys = [("name".to_owned(), name)]
        .into_iter()
        .chain(tag)
        .chain(keys_of(&subject, &own)?)
        .chain(plugin);
    for (key, value) in keys {
        text.push_str(&format!("{key} = {value}\n"));
    }
    Ok(())
}

fn inline(subject: &str, value: &impl Serialize) -> Result<String, Error> {
    let mut text = String::new();
    match value.serialize(ValueSerializer::new(&mut text)) {
        Ok(_) => Ok(text),
        Err(error) => Err(failure(subject, error.to_string())),
    }
}

fn failure(subject: &str, reason: impl Display) -> Error {
    Error::custom(format!("{subject}: cannot be written as TOML: {reason}"))
}

/// The keys of a table with their values as text, in the order in which they are serialised.
///
/// TOML's serialiser writes either nested tables under headers of their own or everything on one line. A
/// line per key is in between: the one line is parsed, and cut where its keys and values are.
fn keys_of(subject: &str, value: &impl Serialize) -> Result<Vec<(String, String)>, Error> {
    let line = format!("t = {}", inline(subject, value)?);
    let parsed = DeTable::parse(&line).map_err(|error| failure(subject, error.message()))?;
    let Some(table) = parsed
        .get_ref()
        .get("t")
        .and_then(|table| table.get_ref().as_table())
    else {
        return Err(failure(subject, "it is not a table"));
    };
    let mut keys: Vec<_> = table
        .iter()
        .map(|(key, value)| (key.span(), value.span()))
        .collect();
    keys.sort_by_key(|(key, _)| key.start);
    let cut = |span: Range<usize>| line.get(span).unwrap_or_default().to_owned();
    Ok(keys
        .into_iter()
        .map(|(key, value)| (cut(key), cut(value)))
        .collect())
}
