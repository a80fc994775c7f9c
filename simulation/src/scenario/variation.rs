//! Values of a run that differ from its scenario's: what a sweep varies.

use serde::{Deserialize, Serialize};
use toml::{Table, Value};
use wbqp::{
    config::{ConfigError, Overrides, key_path},
    robot::SourceFile,
};

use super::ScenarioError;

/// Changes on top of every case, in the form that a case has: `change` for the scenario, `set` for the controller.
///
/// ```
/// use wbqp_sim::Variation;
///
/// let from_text = Variation::from_toml(
///     "change.plant.mismatch.mass_scale = 1.05\nset.task.base_orientation.kp = 60.0",
/// )?;
/// let from_code = Variation::new()
///     .change("plant.mismatch.mass_scale", 1.05)
///     .set("task.base_orientation.kp", 60.0);
/// assert_eq!(from_text, from_code);
/// # Ok::<(), wbqp_sim::ScenarioError>(())
/// ```
/// [`Scenario::varied`](super::Scenario::varied) applies and checks it. A named part of the scenario that some cases
/// do not have is changed in the others.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Variation {
    /// In the shape of the scenario's file, with names for the entries of lists.
    #[serde(skip_serializing_if = "Table::is_empty")]
    change: Table,
    #[serde(skip_serializing_if = "Overrides::is_empty")]
    set: Overrides,
    /// What errors call it, if not a variation.
    #[serde(skip)]
    option: Option<&'static str>,
}

impl Variation {
    /// Changes nothing.
    pub fn new() -> Self {
        Self::default()
    }

    /// Reads keys `change.…` and `set.…` as in a `[[case]]`.
    ///
    /// # Errors
    /// [`ScenarioError::Syntax`] with line and column.
    pub fn from_toml(text: &str) -> Result<Self, ScenarioError> {
        toml::from_str(text).map_err(|error| super::text::syntax(&error, NAME, text))
    }

    /// Changes a value of the scenario, named by a [path](key_path) such as `plant.wall.NAME.friction`. Of two for the
    /// same path the later counts. What is no path is refused as a key that the scenario's file does not have.
    pub fn change(mut self, path: &str, value: impl Into<Value>) -> Self {
        let keys = key_path(path).unwrap_or_else(|| vec![path.to_owned()]);
        let mut keys = keys.into_iter().peekable();
        let mut table = &mut self.change;
        while let Some(key) = keys.next() {
            if keys.peek().is_none() {
                table.insert(key, value.into());
                break;
            }
            let inner = table
                .entry(key)
                .or_insert_with(|| Value::Table(Table::new()));
            if !inner.is_table() {
                *inner = Value::Table(Table::new());
            }
            match inner {
                Value::Table(inner) => table = inner,
                _ => break,
            }
        }
        self
    }

    /// Changes a value of the controller, as [`Overrides::with`].
    pub fn set(mut self, path: &str, value: impl Into<Value>) -> Self {
        self.set = self.set.with(path, value);
        self
    }

    /// The same from a command line, where this option is given for each value: `--set`, whose keys of the controller
    /// have nothing before them. What is wrong with a value is told as the option.
    pub fn given_by(mut self, option: &'static str) -> Self {
        self.option = Some(option);
        self
    }

    /// This one, then another.
    pub fn then(mut self, other: &Self) -> Self {
        self.option = other.option.or(self.option);
        merge(&mut self.change, &other.change);
        self.set.append(&other.set);
        self
    }

    /// Whether it changes nothing.
    pub fn is_empty(&self) -> bool {
        self.change.is_empty() && self.set.is_empty()
    }

    /// As a text that [`Variation::from_toml`] reads.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).unwrap_or_default()
    }

    pub(super) fn overrides(&self) -> &Overrides {
        &self.set
    }

    /// What errors call a line of [`Variation::changes`].
    pub(super) fn display(&self, line: &str) -> String {
        match (self.option, line.split_once(" = ")) {
            (Some(option), Some((key, value))) => format!("{option} change.{key}={value}"),
            _ => format!("variation `{line}`"),
        }
    }

    /// The option that gave what an error of the controller is about, if it is one that it was given by.
    pub(super) fn option_of(&self, error: &ConfigError) -> Option<String> {
        let option = self.option?;
        let (key, value) = self.set.of_error(error)?;
        Some(format!("{option} {key}={value}"))
    }

    /// Whether an option of a command line gave it.
    pub(super) fn is_option(&self) -> bool {
        self.option.is_some()
    }

    /// The changes of the scenario as TOML, a line per value, with its whole path.
    pub(super) fn changes(&self) -> String {
        let mut lines = String::new();
        write_lines(&self.change, "", &mut lines);
        lines
    }

    /// What a log keeps of it; nothing if it changes nothing.
    pub(crate) fn source(&self) -> Option<SourceFile> {
        (!self.is_empty()).then(|| SourceFile {
            name: NAME.to_owned(),
            contents: self.to_toml(),
        })
    }
}

/// What errors and logs call it.
const NAME: &str = "variation.toml";

fn write_lines(table: &Table, path: &str, lines: &mut String) {
    for (key, value) in table {
        let bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        let path = if !key.is_empty() && key.chars().all(bare) {
            format!("{path}{key}")
        } else {
            format!("{path}{}", Value::from(key.as_str()))
        };
        match value {
            Value::Table(inner) if !inner.contains_key("type") => {
                write_lines(inner, &format!("{path}."), lines);
            }
            value => lines.push_str(&format!("{path} = {value}\n")),
        }
    }
}

fn merge(into: &mut Table, from: &Table) {
    for (key, value) in from {
        match (into.get_mut(key), value) {
            (Some(Value::Table(old)), Value::Table(new)) if !new.contains_key("type") => {
                merge(old, new);
            }
            _ => {
                into.insert(key.clone(), value.clone());
            }
        }
    }
}
