//! From the text of a scenario's file to what each of its cases has.

use std::{collections::BTreeMap, ops::Range, path::PathBuf};

use schemars::JsonSchema;
use serde::{Deserialize, de::IgnoredAny};
use toml::{
    Spanned,
    de::{DeArray, DeTable, DeValue, ValueDeserializer},
};
use wbqp::{
    config::{Overrides, in_words},
    contact::Detector,
    input::{Enough, Mark, outline},
};

use super::{
    Event, Initial, ScenarioError, Variation,
    change::{self, Members, Refusal, Whose},
};
use crate::{PlantConfig, SensorsConfig};

/// A case as the file, its own changes and a variation make it.
#[derive(Clone, Debug)]
pub(super) struct CaseFile {
    pub(super) name: Spanned<String>,
    /// Whether it has changes of its own.
    pub(super) is_changed: bool,
    pub(super) set: Overrides,
    pub(super) keys: Keys,
}

/// A scenario: a controller, a plant, sensors, and what happens when.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Keys {
    /// The scenario's name, of letters, digits, `_`, `-` and, inside, `.`: it names the folder of its runs.
    #[schemars(with = "String")]
    pub(super) name: Spanned<String>,
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
    #[schemars(with = "String")]
    name: Spanned<String>,
    /// Values put into the controller's file before it is read.
    #[serde(default)]
    set: Overrides,
    /// Values put into this file before it is read.
    // Read where the tables of the file are.
    #[serde(default, rename = "change")]
    #[schemars(with = "BTreeMap<String, wbqp::serde_json::Value>")]
    _change: IgnoredAny,
}

/// A file, taken apart.
struct Cases<'t> {
    span: Range<usize>,
    /// Without the cases.
    root: DeTable<'t>,
    keys: Vec<CaseKeys>,
    /// Of each case.
    changes: Vec<Option<Change<'t>>>,
}

/// What a case changes in the file.
enum Change<'t> {
    Read(Spanned<DeValue<'t>>),
    /// Stands in this part of the file.
    Part(Range<usize>),
}

/// A case before its keys are read.
pub(super) struct CaseTables<'t> {
    index: usize,
    pub(super) name: Spanned<String>,
    is_changed: bool,
    set: Overrides,
    span: Range<usize>,
    /// With the case's changes and the variation's.
    pub(super) root: DeTable<'t>,
}

/// So many cases are read one by one.
const MANY: usize = 32;

/// A table with the places that it has in the whole of which a part was parsed.
fn moved_table(table: DeTable<'_>, by: usize) -> DeTable<'_> {
    let mut moved = DeTable::new();
    for (key, value) in table {
        let key_span = key.span();
        let key = Spanned::new(key_span.start + by..key_span.end + by, key.into_inner());
        moved.insert(key, moved_value(value, by));
    }
    moved
}

fn moved_value(value: Spanned<DeValue<'_>>, by: usize) -> Spanned<DeValue<'_>> {
    let span = value.span();
    let value = match value.into_inner() {
        DeValue::Table(table) => DeValue::Table(moved_table(table, by)),
        DeValue::Array(elements) => {
            let mut moved = DeArray::new();
            for element in elements {
                moved.push(moved_value(element, by));
            }
            DeValue::Array(moved)
        }
        other => other,
    };
    Spanned::new(span.start + by..span.end + by, value)
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

    /// What errors call it.
    pub(super) fn name(&self) -> &str {
        self.name
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
            message: in_words(error.message()),
        }
    }

    fn refusal(&self, refusal: Refusal) -> ScenarioError {
        ScenarioError::Syntax {
            place: self.place(refusal.span.start),
            message: refusal.message,
        }
    }

    /// The file, all of it parsed at once.
    fn as_a_whole(&self) -> Result<Cases<'_>, ScenarioError> {
        let root = DeTable::parse(self.file).map_err(|e| self.error(&e))?;
        let (span, mut root) = (root.span(), root.into_inner());
        if let Some(controller) = root.get("controller")
            && controller.get_ref().is_table()
        {
            let span = controller.span();
            let message =
                "this is a controller's file; a scenario names one: `controller = \"FILE\"`"
                    .to_owned();
            return Err(self.refusal(Refusal { span, message }));
        }
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
        let (mut keys, mut changes) = (Vec::new(), Vec::new());
        for mut table in tables {
            changes.push(match table.get_mut() {
                DeValue::Table(keys) => keys.remove("change").map(Change::Read),
                _ => None,
            });
            let case = CaseKeys::deserialize(ValueDeserializer::from(table));
            keys.push(case.map_err(|e| self.error(&e))?);
        }
        Ok(Cases {
            span,
            root,
            keys,
            changes,
        })
    }

    /// The same, parsed case by case: a tree of thousands of cases takes a hundred times their text. Nothing if the
    /// cases are few, are not at the end of the file, or if anything is wrong with them: the whole says what.
    fn in_parts(&self) -> Option<Cases<'_>> {
        let mut starts = Vec::new();
        let is_mixed = outline(self.file, |start, mark| match mark {
            Mark::Header("case") => {
                // The bracket before it belongs to it.
                starts.push(start.saturating_sub(1));
                Enough::No
            }
            Mark::Header(name) if !starts.is_empty() && !name.starts_with("case.") => Enough::Yes,
            _ => Enough::No,
        });
        let first = *starts.first()?;
        if starts.len() < MANY || is_mixed == Enough::Yes {
            return None;
        }
        let root = DeTable::parse(self.file.get(..first)?).ok()?;
        let (span, root) = (root.span(), root.into_inner());
        if root.contains_key("case") {
            return None;
        }
        let ends = starts.iter().skip(1).copied().chain([self.file.len()]);
        let (mut keys, mut changes) = (Vec::new(), Vec::new());
        for (start, end) in starts.iter().copied().zip(ends) {
            let mut table = self.part(start..end)?;
            let has_change = table.remove("change").is_some();
            changes.push(has_change.then_some(Change::Part(start..end)));
            let table = Spanned::new(start..end, DeValue::Table(table));
            keys.push(CaseKeys::deserialize(ValueDeserializer::from(table)).ok()?);
        }
        Some(Cases {
            span,
            root,
            keys,
            changes,
        })
    }

    /// The table of a part of the file that has one case and nothing else.
    fn part(&self, part: Range<usize>) -> Option<DeTable<'_>> {
        let start = part.start;
        let parsed = DeTable::parse(self.file.get(part)?).ok()?;
        let mut root = parsed.into_inner();
        let DeValue::Array(tables) = root.remove("case")?.into_inner() else {
            return None;
        };
        let mut tables = tables.into_iter();
        match (tables.next()?.into_inner(), tables.next(), root.is_empty()) {
            (DeValue::Table(table), None, true) => Some(moved_table(table, start)),
            _ => None,
        }
    }

    /// Reads every case.
    pub(super) fn cases(&self, variation: &Variation) -> Result<Vec<CaseFile>, ScenarioError> {
        let cases = self.cases_that(variation, |_| true)?;
        Ok(cases.into_iter().map(|(_, case)| case).collect())
    }

    /// Reads the case of a name, with its place among all.
    pub(super) fn case(
        &self,
        variation: &Variation,
        name: &str,
    ) -> Result<Option<(usize, CaseFile)>, ScenarioError> {
        let cases = self.cases_that(variation, |case| case == name)?;
        Ok(cases.into_iter().next())
    }

    /// Reads those with certain names.
    fn cases_that(
        &self,
        variation: &Variation,
        is_wanted: impl Fn(&str) -> bool,
    ) -> Result<Vec<(usize, CaseFile)>, ScenarioError> {
        let mut read = Vec::new();
        self.tables_that(variation, is_wanted, |case| {
            let file = CaseFile {
                name: case.name,
                is_changed: case.is_changed,
                set: case.set,
                keys: self.keys(case.span, case.root)?,
            };
            read.push((case.index, file));
            Ok(())
        })?;
        Ok(read)
    }

    /// Gives those with certain names, one after the other: thousands of them do not have to be there at once.
    pub(super) fn tables_that<'s>(
        &'s self,
        variation: &Variation,
        is_wanted: impl Fn(&str) -> bool,
        mut take: impl FnMut(CaseTables<'s>) -> Result<(), ScenarioError>,
    ) -> Result<(), ScenarioError> {
        let varied = DeTable::parse(&self.changes).map_err(|e| self.error(&e))?;
        let Cases {
            span,
            mut root,
            keys: cases,
            changes,
        } = match self.in_parts() {
            Some(cases) => cases,
            None => self.as_a_whole()?,
        };
        let names: Vec<&str> = cases
            .iter()
            .map(|case| case.name.get_ref().as_str())
            .collect();
        // A file without cases is read as well: what is wrong with its keys comes first.
        let members = Members::take(&mut root, &names).map_err(|e| self.refusal(e))?;
        if cases.is_empty() {
            self.keys(span, root)?;
            return Ok(());
        }
        for (index, (case, own)) in cases.iter().zip(changes).enumerate() {
            if !is_wanted(case.name.get_ref()) {
                continue;
            }
            let own = own.and_then(|own| match own {
                Change::Read(own) => Some(own),
                Change::Part(part) => self.part(part)?.remove("change"),
            });
            let mut root = root.clone();
            let left_out = members.select(&mut root, case.name.get_ref());
            if let Some(own) = &own {
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
            set.append(variation.overrides());
            take(CaseTables {
                index,
                name: case.name.clone(),
                is_changed: own.is_some(),
                set,
                span: span.clone(),
                root,
            })?;
        }
        Ok(())
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
        message: in_words(error.message()),
    }
}

/// `file:line:column`, columns in characters.
fn place(name: &str, text: &str, offset: usize) -> String {
    let before = text.get(..offset.min(text.len())).unwrap_or(text);
    let line = before.matches('\n').count() + 1;
    let column = before.chars().rev().take_while(|&c| c != '\n').count() + 1;
    format!("{name}:{line}:{column}")
}
