//! From the text of a scenario's file to what each of its cases has.

use std::{
    borrow::Cow,
    collections::{BTreeMap, HashMap},
    ops::Range,
    path::PathBuf,
    sync::Arc,
};

use schemars::JsonSchema;
use serde::{Deserialize, de::IgnoredAny};
use toml::{
    Spanned,
    de::{DeTable, DeValue, ValueDeserializer},
};
use wbqp::{config::Overrides, contact::Detector};

use super::{
    Event, Initial, ScenarioError, Variation,
    change::{self, Events, Members, Refusal, Whose},
    contents::{Contents, Listed},
    idle, names, outage,
    parts::{self, Sections},
    text::{CASE, Text},
};
use crate::{PlantConfig, SensorsConfig};

/// The names of cases.
fn names_of(keys: &[CaseKeys]) -> Vec<&str> {
    let names = keys.iter().map(|case| case.name.get_ref().as_str());
    names.collect()
}

/// A case as the file, its own changes and a variation make it.
#[derive(Clone, Debug)]
pub(super) struct CaseFile {
    pub(super) name: Spanned<String>,
    /// Whether it has changes of its own.
    pub(super) is_changed: bool,
    pub(super) set: Overrides,
    /// The same as that of other cases, where they differ in nothing that the file says.
    pub(super) contents: Arc<Contents>,
}

impl CaseFile {
    fn new(
        case: &CaseKeys,
        is_changed: bool,
        variation: &Variation,
        contents: Arc<Contents>,
    ) -> Self {
        let mut set = case.set.clone();
        set.append(variation.overrides());
        Self {
            name: case.name.clone(),
            is_changed,
            set,
            contents,
        }
    }
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
struct Parts<'t> {
    span: Range<usize>,
    /// Without the cases and without entries of lists.
    root: DeTable<'t>,
    members: Members<'t>,
    keys: Vec<CaseKeys>,
    /// Of each case.
    changes: Vec<Option<Change<'t>>>,
}

/// What the cases of a file have before each has its own.
pub(super) struct Cases<'t> {
    span: Range<usize>,
    /// Without the cases and without entries of lists.
    root: DeTable<'t>,
    members: Members<'t>,
    keys: Vec<CaseKeys>,
    /// Of each case.
    changes: Vec<Option<Change<'t>>>,
    /// A variation's.
    varied: Spanned<DeTable<'t>>,
}

impl Cases<'_> {
    /// Its name, with the place in the file.
    pub(super) fn name(&self, index: usize) -> Option<&Spanned<String>> {
        self.keys.get(index).map(|case| &case.name)
    }

    /// Where its tables stand.
    pub(super) fn span(&self) -> Range<usize> {
        self.span.clone()
    }

    /// The entries of its lists.
    pub(super) fn members(&self) -> &Members<'_> {
        &self.members
    }

    /// What a variation changes in all cases.
    pub(super) fn varied(&self) -> &DeTable<'_> {
        self.varied.get_ref()
    }

    /// Reads tables.
    pub(super) fn read(&self, root: DeTable<'_>) -> Result<Keys, toml::de::Error> {
        let root = Spanned::new(self.span.clone(), DeValue::Table(root));
        Keys::deserialize(ValueDeserializer::from(root))
    }

    /// The index of that name.
    pub(super) fn index(&self, name: &str) -> Option<usize> {
        let is_it = |case: &CaseKeys| case.name.get_ref() == name;
        self.keys.iter().position(is_it)
    }
}

/// What a case changes in the file.
enum Change<'t> {
    Read(Spanned<DeValue<'t>>),
    /// Stands in this part of the file.
    Part(Range<usize>),
}

/// Events that no case changes, by those that belong to some cases only.
type KnownEvents<'c> = HashMap<&'c [usize], Arc<Listed<Event>>>;

/// Events, walls and so on, together, that cases after the first have for themselves: each takes about 0.5 kB, and what
/// a small file can ask for has no end.
const MOST_ENTRIES: usize = 50_000;

impl Text<'_> {
    /// The file, all of it parsed at once.
    fn as_a_whole(&self) -> Result<Parts<'_>, ScenarioError> {
        let root = DeTable::parse(self.file()).map_err(|e| self.error(&e))?;
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
        for key in ["initial", "plant", "sensors"] {
            if let Some((key, DeValue::Array(_))) = root
                .get_key_value(key)
                .map(|(key, value)| (key, value.get_ref()))
            {
                let (span, key) = (key.span(), key.get_ref());
                let message = format!(
                    "`{key}` is there once: write `[{key}]`, with one bracket on each side"
                );
                return Err(self.refusal(Refusal { span, message }));
            }
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
        // Before what refers to cases: a name that is there twice leaves another one out.
        names::check_cases(self, keys.iter().map(|case| &case.name))?;
        let members = Members::take(self.file(), &mut root, &[], &names_of(&keys));
        Ok(Parts {
            span,
            root,
            members: members.map_err(|e| self.refusal(e))?,
            keys,
            changes,
        })
    }

    /// The same, parsed entry by entry. Nothing if the entries are few, or if anything is wrong with them: the whole
    /// says what.
    fn in_parts(&self) -> Option<Parts<'_>> {
        let Sections { rest, parts } = self.sections.as_ref()?;
        let root = DeTable::parse(rest).ok()?;
        let (span, mut root) = (root.span(), root.into_inner());
        let (cases, lists) = parts.split_last()?;
        if root.contains_key("case") {
            return None;
        }
        let (mut keys, mut changes) = (Vec::new(), Vec::new());
        for part in cases {
            let mut case = parts::parsed(self.file(), part, CASE)?;
            if let DeValue::Table(case) = case.get_mut() {
                let has_change = case.remove("change").is_some();
                changes.push(has_change.then(|| Change::Part(part.clone())));
            }
            keys.push(CaseKeys::deserialize(ValueDeserializer::from(case)).ok()?);
        }
        names::check_cases(self, keys.iter().map(|case| &case.name)).ok()?;
        let members = Members::take(self.file(), &mut root, lists, &names_of(&keys)).ok()?;
        Some(Parts {
            span,
            root,
            members,
            keys,
            changes,
        })
    }

    /// Reads every case.
    pub(super) fn cases(&self, variation: &Variation) -> Result<Vec<CaseFile>, ScenarioError> {
        let cases = self.opened()?;
        idle::check_disturbances(self, &cases)?;
        if cases.keys.is_empty() {
            // Read as well: what is wrong with its keys comes before that it has no case.
            let tables = || {
                let mut root = cases.root.clone();
                cases.members.put(&mut root, "", Events::Put);
                root
            };
            let read = cases.read(tables());
            read.map_err(|e| self.mistakes(e, &cases, tables()))?;
        }
        let mut known: HashMap<_, Arc<Contents>> = HashMap::new();
        let mut events = KnownEvents::new();
        let mut read = Vec::new();
        let mut entries = 0;
        for (index, case) in cases.keys.iter().enumerate() {
            let is_changed = cases.changes.get(index).is_some_and(Option::is_some);
            let own = cases.members.own(case.name.get_ref());
            let same = known.get(&own).filter(|_| !is_changed);
            let contents = if let Some(same) = same {
                same.clone()
            } else {
                let (contents, own_events) = self.contents(&cases, index, &mut events)?;
                // What the file itself has is bounded by its size.
                if !read.is_empty() {
                    entries += contents.entries() + own_events;
                }
                if entries > MOST_ENTRIES {
                    return Err(ScenarioError::Value {
                        place: self.place(case.name.span().start),
                        what: format!(
                            "case[{index}]: up to this one, the cases after the first have more than {MOST_ENTRIES} \
                             events, walls, disturbances and so on of their own: make files of fewer cases"
                        ),
                    });
                }
                let contents = Arc::new(contents);
                if !is_changed {
                    known.insert(own, contents.clone());
                }
                contents
            };
            read.push(CaseFile::new(case, is_changed, variation, contents));
        }
        Ok(read)
    }

    /// Reads the case of a name, with its place among all.
    pub(super) fn case(
        &self,
        variation: &Variation,
        name: &str,
    ) -> Result<Option<(usize, CaseFile)>, ScenarioError> {
        let cases = self.opened()?;
        let Some(index) = cases.index(name) else {
            return Ok(None);
        };
        let (contents, _) = self.contents(&cases, index, &mut KnownEvents::new())?;
        let is_changed = cases.changes.get(index).is_some_and(Option::is_some);
        let case = cases.keys.get(index);
        let case = case.map(|case| CaseFile::new(case, is_changed, variation, Arc::new(contents)));
        Ok(case.map(|case| (index, case)))
    }

    /// The file with a variation.
    pub(super) fn opened(&self) -> Result<Cases<'_>, ScenarioError> {
        let varied = DeTable::parse(&self.changes).map_err(|e| self.error(&e))?;
        let Parts {
            span,
            root,
            members,
            keys,
            changes,
        } = match self.in_parts() {
            Some(parts) => parts,
            None => self.as_a_whole()?,
        };
        Ok(Cases {
            span,
            root,
            members,
            keys,
            changes,
            varied,
        })
    }

    /// What the file says of a case, and how many events are there for it alone.
    fn contents<'c>(
        &self,
        cases: &'c Cases<'_>,
        index: usize,
        known: &mut KnownEvents<'c>,
    ) -> Result<(Contents, usize), ScenarioError> {
        let (tables, events) = self.tables(cases, index)?;
        let wrong = |error| self.all_wrong(cases, index, error);
        let mut keys = cases.read(tables).map_err(wrong)?;
        if events == Events::Put {
            let own = std::mem::take(&mut keys.events);
            let count = own.len();
            return Ok((Contents::new(keys, Arc::new(own.into())), count));
        }
        let name = cases.name(index).map_or("", |name| name.get_ref().as_str());
        let key = cases.members.own_events(name);
        if let Some(events) = known.get(key) {
            return Ok((Contents::new(keys, events.clone()), 0));
        }
        let entries = cases.members.events(name);
        let mut events = Vec::with_capacity(entries.len());
        for entry in entries.flatten() {
            let event = Spanned::deserialize(ValueDeserializer::from(entry));
            events.push(event.map_err(wrong)?);
        }
        let count = events.len();
        let events = Arc::new(Listed::from(events));
        known.insert(key, events.clone());
        Ok((Contents::new(keys, events), count))
    }

    /// The tables of a case, with its changes and the variation's: with the events if these change any of them.
    pub(super) fn tables<'s>(
        &'s self,
        cases: &'s Cases<'s>,
        index: usize,
    ) -> Result<(DeTable<'s>, Events), ScenarioError> {
        let name = cases.name(index).map_or("", |name| name.get_ref().as_str());
        let own = self.changes_of(cases, index);
        let own = match own.as_ref().map(|own| (own, own.get_ref())) {
            None => None,
            Some((_, DeValue::Table(changes))) => Some(changes),
            Some((own, other)) => {
                let message = format!("`change` must be a table, found {}", other.type_str());
                let span = own.span();
                return Err(self.refusal(Refusal { span, message }));
            }
        };
        let varied = cases.varied.get_ref();
        let mut changes = own.into_iter().chain([varied]);
        let events = if changes.any(|changes| changes.contains_key("event")) {
            Events::Put
        } else {
            Events::LeftOut
        };
        let mut root = cases.root.clone();
        cases.members.put(&mut root, name, events);
        if let Some(own) = own
            && let Err(refusal) = change::apply(&mut root, own, Whose::Case)
        {
            let meant = outage::misspelt(&root, own);
            return Err(self.refusal(meant.unwrap_or(refusal)));
        }
        let whose = Whose::Variation {
            members: &cases.members,
            case: name,
        };
        if let Err(refusal) = change::apply(&mut root, varied, whose) {
            let meant = outage::misspelt(&root, varied);
            return Err(self.refusal(meant.unwrap_or(refusal)));
        }
        Ok((root, events))
    }

    /// What a case changes, as the file has it.
    fn changes_of<'s>(
        &'s self,
        cases: &'s Cases<'s>,
        index: usize,
    ) -> Option<Cow<'s, Spanned<DeValue<'s>>>> {
        match cases.changes.get(index)?.as_ref()? {
            Change::Read(own) => Some(Cow::Borrowed(own)),
            Change::Part(part) => match parts::parsed(self.file(), part, CASE)?.into_inner() {
                DeValue::Table(mut case) => case.remove("change").map(Cow::Owned),
                _ => None,
            },
        }
    }

    /// Calls something with the changes of every case that has some.
    pub(super) fn each_change<'s>(
        &'s self,
        cases: &'s Cases<'s>,
        mut call: impl FnMut(&DeTable<'_>),
    ) {
        for index in 0..cases.keys.len() {
            let own = self.changes_of(cases, index);
            if let Some(own) = own.as_ref().and_then(|own| own.get_ref().as_table()) {
                call(own);
            }
        }
    }

    /// The longest that the file, by itself or by the changes of any case, lets a run take, s.
    pub(super) fn longest(&self) -> f64 {
        *self.longest.get_or_init(|| {
            let Ok(cases) = self.opened() else {
                return 0.0;
            };
            let own = |table: &DeTable<'_>| number(table.get("duration")?.get_ref());
            let mut longest = own(&cases.root).unwrap_or(0.0);
            self.each_change(&cases, |change| {
                longest = longest.max(own(change).unwrap_or(0.0));
            });
            longest
        })
    }
}

/// A number of a file.
fn number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Float(number) => number.as_str().parse().ok(),
        DeValue::Integer(number) => number.as_str().parse().ok(),
        _ => None,
    }
}
