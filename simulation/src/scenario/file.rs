//! From the text of a scenario's file to what each of its cases has.

use std::{collections::BTreeMap, path::PathBuf};

use schemars::JsonSchema;
use serde::{Deserialize, de::IgnoredAny};
use toml::{
    Spanned,
    de::{DeTable, DeValue, ValueDeserializer},
};
use wbqp::{config::Overrides, contact::Detector};

use super::{
    Event, Initial, ScenarioError, Variation,
    change::{self, Refusal, Whose},
};
use crate::{PlantConfig, SensorsConfig};

/// A case as the file, its own changes and a variation make it.
#[derive(Clone, Debug)]
pub(super) struct CaseFile {
    pub(super) name: String,
    /// Whether it has changes of its own.
    pub(super) is_changed: bool,
    pub(super) set: Overrides,
    pub(super) keys: Keys,
}

/// A scenario: a controller, a plant, sensors, and what happens when.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Keys {
    /// The scenario's name.
    pub(super) name: String,
    /// The controller's file; relative paths count from this file's folder.
    pub(super) controller: PathBuf,
    /// Simulated time, s, above 0.
    #[schemars(extend("x-unit" = "s"))]
    pub(super) duration: f64,
    /// Where the robot starts, at rest.
    #[serde(default)]
    pub(super) initial: Initial,
    /// The simulated world.
    #[serde(default)]
    pub(super) plant: PlantConfig,
    /// What the controller measures.
    #[serde(default)]
    pub(super) sensors: SensorsConfig,
    /// Contacts switched by measured force.
    #[serde(default, rename = "detector")]
    #[schemars(with = "Vec<Detector>")]
    pub(super) detectors: Vec<Spanned<Detector>>,
    /// What changes at a given time.
    #[serde(default, rename = "event")]
    #[schemars(with = "Vec<Event>")]
    pub(super) events: Vec<Spanned<Event>>,
    /// Variants, at least one.
    // Read before.
    #[serde(default, rename = "case")]
    #[schemars(with = "Vec<CaseKeys>")]
    _cases: IgnoredAny,
}

/// A variant of the scenario.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct CaseKeys {
    /// Unique, of letters, digits, `_` and `-`: it names the log.
    name: String,
    /// Values put into the controller's file before it is read.
    #[serde(default)]
    set: Overrides,
    /// Values put into this file before it is read.
    // Read where the tables of the file are.
    #[serde(default, rename = "change")]
    #[schemars(with = "BTreeMap<String, wbqp::serde_json::Value>")]
    _change: IgnoredAny,
}

/// The text of a file, and behind its end a variation's changes: what is read from them has spans that no part of the
/// file has.
pub(super) struct Text<'a> {
    name: &'a str,
    file: &'a str,
    changes: String,
}

impl<'a> Text<'a> {
    pub(super) fn new(name: &'a str, text: &'a str, variation: &Variation) -> Self {
        let changes = " ".repeat(text.len() + 1) + &variation.changes();
        Self {
            name,
            file: text,
            changes,
        }
    }

    /// `file:line:column`; for what is wrong with a variation, the value.
    pub(super) fn place(&self, offset: usize) -> String {
        if offset <= self.file.len() {
            return place(self.name, self.file, offset);
        }
        let lines = self.changes.get(self.file.len() + 1..).unwrap_or_default();
        let mut start = self.file.len() + 1;
        let line = lines.lines().find(|line| {
            start += line.len() + 1;
            start > offset
        });
        format!("{}: variation `{}`", self.name, line.unwrap_or_default())
    }

    fn error(&self, error: &toml::de::Error) -> ScenarioError {
        ScenarioError::Syntax {
            place: self.place(error.span().map_or(0, |span| span.start)),
            message: error.message().to_owned(),
        }
    }

    fn refusal(&self, refusal: Refusal) -> ScenarioError {
        ScenarioError::Syntax {
            place: self.place(refusal.span.start),
            message: refusal.message,
        }
    }

    /// Reads every case.
    pub(super) fn cases(&self, variation: &Variation) -> Result<Vec<CaseFile>, ScenarioError> {
        let root = DeTable::parse(self.file).map_err(|e| self.error(&e))?;
        let varied = DeTable::parse(&self.changes).map_err(|e| self.error(&e))?;
        let (span, mut root) = (root.span(), root.into_inner());
        let mut tables = Vec::new();
        // Taken out: each case has a copy of the rest.
        if let Some(cases) = root.remove("case") {
            let span = cases.span();
            let DeValue::Array(cases) = cases.into_inner() else {
                let message = "`case` must be a list of tables, each `[[case]]`".to_owned();
                return Err(self.refusal(Refusal { span, message }));
            };
            tables.extend(cases);
        }
        let mut cases = Vec::new();
        for table in &tables {
            let keys = CaseKeys::deserialize(ValueDeserializer::from(table.clone()));
            cases.push(keys.map_err(|e| self.error(&e))?);
        }
        let names: Vec<&str> = cases.iter().map(|case| case.name.as_str()).collect();
        let mut read = Vec::new();
        // A file without cases is read as well: what is wrong with its keys comes first.
        if tables.is_empty() {
            change::select(&mut root, "", &names).map_err(|e| self.refusal(e))?;
            self.keys(span, root)?;
            return Ok(read);
        }
        for (case, table) in cases.iter().zip(&tables) {
            let mut root = root.clone();
            let left_out =
                change::select(&mut root, &case.name, &names).map_err(|e| self.refusal(e))?;
            let own = table.get_ref().as_table().and_then(|t| t.get("change"));
            if let Some(own) = own {
                let DeValue::Table(changes) = own.get_ref() else {
                    let found = own.get_ref().type_str();
                    let message = format!("`change` must be a table, found {found}");
                    let span = own.span();
                    return Err(self.refusal(Refusal { span, message }));
                };
                change::apply(&mut root, changes, Whose::Case).map_err(|e| self.refusal(e))?;
            }
            change::apply(&mut root, varied.get_ref(), Whose::Variation(&left_out))
                .map_err(|e| self.refusal(e))?;
            let mut set = case.set.clone();
            for each in variation.overrides() {
                set.push(each.target.clone(), &each.key, each.value.clone());
            }
            read.push(CaseFile {
                name: case.name.clone(),
                is_changed: own.is_some(),
                set,
                keys: self.keys(span.clone(), root)?,
            });
        }
        Ok(read)
    }

    fn keys(&self, span: std::ops::Range<usize>, root: DeTable<'_>) -> Result<Keys, ScenarioError> {
        let root = Spanned::new(span, DeValue::Table(root));
        Keys::deserialize(ValueDeserializer::from(root)).map_err(|e| self.error(&e))
    }
}

/// What is wrong with a text that stands alone.
pub(super) fn syntax(error: &toml::de::Error, name: &str, text: &str) -> ScenarioError {
    ScenarioError::Syntax {
        place: place(name, text, error.span().map_or(0, |span| span.start)),
        message: error.message().to_owned(),
    }
}

/// `file:line:column`, columns in characters.
fn place(name: &str, text: &str, offset: usize) -> String {
    let before = text.get(..offset.min(text.len())).unwrap_or(text);
    let line = before.matches('\n').count() + 1;
    let column = before.chars().rev().take_while(|&c| c != '\n').count() + 1;
    format!("{name}:{line}:{column}")
}
