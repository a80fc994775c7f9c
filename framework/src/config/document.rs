//! The tables of a controller's file, before anything in them is read.

use std::collections::HashMap;

use toml::{
    Spanned,
    de::{DeTable, DeValue},
};

use super::{
    ConfigErrorKind as Kind, defaults,
    report::{At, Report, Span},
    table::Section,
};
use crate::{settings::Target, suggestion::suggestion};

/// Syntax errors that are shown with their line, which may be long: few are told.
const SHOWN: usize = 100;

const TABLES: [&str; 5] = ["controller", "robot", "solver", "fallback", "measurement"];
const REQUIRED: [&str; 2] = ["controller", "robot"];
const LISTS: [&str; 3] = ["contact", "task", "constraint"];

/// The file, taken apart.
#[derive(Default)]
pub(super) struct Document<'t> {
    pub(super) controller: Option<Section<'t>>,
    pub(super) robot: Option<Section<'t>>,
    pub(super) solver: Option<Section<'t>>,
    pub(super) fallback: Option<Section<'t>>,
    pub(super) measurement: Option<Section<'t>>,
    pub(super) contacts: Vec<Section<'t>>,
    pub(super) tasks: Vec<Section<'t>>,
    pub(super) constraints: Vec<Section<'t>>,
    /// Whether something in it was said in short: then the type of what goes without saying has to be linked.
    pub(super) is_short: bool,
}

/// Where entries are in their lists.
#[derive(Debug, Default)]
pub(super) struct Directory {
    contacts: HashMap<String, usize>,
    tasks: HashMap<String, usize>,
    constraints: HashMap<String, usize>,
}

impl<'t> Document<'t> {
    /// Parses a file, reporting every syntax error and every table that does not belong there.
    pub(super) fn parse(source: &'t str, report: &mut Report<'_>) -> Self {
        let (root, errors) = DeTable::parse_recoverable(source);
        let repeated_tables = if errors.is_empty() {
            Vec::new()
        } else {
            repeated_tables(source)
        };
        for (index, error) in errors.into_iter().enumerate() {
            let mut span = error.span().unwrap_or(source.len()..source.len());
            let said = error.message();
            let repeated = of_repeated(&repeated_tables, span.start)
                .filter(|(_, name)| has_key(&root, name, source.get(span.clone())));
            let message = if let Some((start, name)) = repeated {
                span = start..start + name.len();
                format!("syntax: `[{name}]` is there twice; write `[[{name}]]`, for each of them")
            } else if index < SHOWN {
                format!("syntax: {said}{}", excerpt(source, span.start))
            } else {
                format!("syntax: {said}")
            };
            report.add(Kind::Syntax, Some(span), &At::default(), message);
        }
        let at = At::subject("top level");
        let mut document = Self::default();
        let mut starts = Vec::new();
        let is_there = |name: &&str| root.get_ref().contains_key(*name);
        let missing: Vec<&str> = REQUIRED
            .into_iter()
            .filter(|name| !is_there(name))
            .collect();
        for (key, value) in root.into_inner() {
            let name: &str = key.get_ref();
            let span = value.span();
            match name {
                "controller" => document.controller = table(name, value, &at, report),
                "robot" => document.robot = table(name, value, &at, report),
                "solver" => document.solver = table(name, value, &at, report),
                "fallback" => document.fallback = table(name, value, &at, report),
                "measurement" => document.measurement = table(name, value, &at, report),
                "contact" => document.contacts = list(name, value, &at, report),
                "task" => document.tasks = list(name, value, &at, report),
                "constraint" => document.constraints = list(name, value, &at, report),
                _ => {
                    let mut known = [&TABLES[..], &LISTS].concat();
                    known.sort_unstable();
                    let hint = suggestion(name, &known);
                    let message = format!("unknown key `{name}`{hint}");
                    report.add(Kind::UnknownKey, Some(key.span()), &at, message);
                }
            }
            starts.push(span.start);
        }
        for name in missing {
            let message = format!("table `[{name}]` is missing");
            report.add(Kind::MissingKey, None, &at, message);
        }
        starts.extend(document.sections().map(|section| section.span.start));
        report.set_sections(starts);
        document
    }

    /// Contacts alone, from a text of this program's own.
    pub(super) fn contacts(source: &'t str, report: &mut Report<'_>) -> Self {
        let (mut root, _) = DeTable::parse_recoverable(source);
        let contacts = root.get_mut().remove("contact");
        let at = At::default();
        Self {
            contacts: contacts.map_or_else(Vec::new, |value| list("contact", value, &at, report)),
            ..Self::default()
        }
    }

    fn sections(&self) -> impl Iterator<Item = &Section<'t>> {
        let tables = [&self.controller, &self.robot, &self.solver, &self.fallback];
        (tables.into_iter().chain([&self.measurement]))
            .flatten()
            .chain(&self.contacts)
            .chain(&self.tasks)
            .chain(&self.constraints)
    }

    /// Where the entries of the lists are, by name.
    pub(super) fn directory(&self) -> Directory {
        Directory {
            contacts: positions(&self.contacts),
            tasks: positions(&self.tasks),
            constraints: positions(&self.constraints),
        }
    }

    /// The table that an override goes to, or the names there are. The directory is this document's.
    pub(super) fn target(
        &mut self,
        target: &Target,
        directory: &Directory,
    ) -> Result<&mut Section<'t>, Vec<&str>> {
        match target {
            Target::Controller => self.controller.as_mut().ok_or_else(Vec::new),
            Target::Robot => self.robot.as_mut().ok_or_else(Vec::new),
            Target::Solver => {
                let section = || of_type(defaults::solver().typetag_name());
                Ok(self.solver.get_or_insert_with(section))
            }
            Target::Fallback => {
                let section = || of_type(defaults::fallback().typetag_name());
                Ok(self.fallback.get_or_insert_with(section))
            }
            Target::Measurement => Ok(self.measurement.get_or_insert_with(no_keys)),
            Target::Contact(name) => named(&mut self.contacts, &directory.contacts, name),
            Target::Task(name) => named(&mut self.tasks, &directory.tasks, name),
            Target::Constraint(name) => named(&mut self.constraints, &directory.constraints, name),
        }
    }
}

/// Where a table begins; with its name, if it is an entry of a list, written like a table, and not the first: its keys
/// are taken for those of the first.
type Header = (usize, Option<&'static str>);

fn repeated_tables(source: &str) -> Vec<Header> {
    let header = |line: &str| {
        let (name, _) = line.trim_start().strip_prefix('[')?.split_once(']')?;
        LISTS.into_iter().find(|list| *list == name.trim())
    };
    let mut start = 0;
    let mut seen = Vec::new();
    let mut tables = Vec::new();
    for line in source.split_inclusive('\n') {
        if line.trim_start().starts_with('[') {
            let name = header(line);
            tables.push((start, name.filter(|name| seen.contains(name))));
            seen.extend(name.filter(|name| !seen.contains(name)));
        }
        start += line.len();
    }
    tables
}

/// The table of an offset, if its list is written like a table.
fn of_repeated(tables: &[Header], offset: usize) -> Option<(usize, &'static str)> {
    let index = tables.partition_point(|(start, _)| *start <= offset);
    let &(start, name) = tables.get(index.checked_sub(1)?)?;
    Some((start, name?))
}

/// Whether what is given again, in a second table of the name, is the table itself or one of its keys.
fn has_key(root: &Spanned<DeTable<'_>>, table: &str, key: Option<&str>) -> bool {
    if key == Some(table) {
        return true;
    }
    let table = root
        .get_ref()
        .get(table)
        .and_then(|t| t.get_ref().as_table());
    table
        .zip(key)
        .is_some_and(|(table, key)| table.contains_key(key))
}

/// The line of an offset, to be seen beside what is wrong with it.
fn excerpt(source: &str, offset: usize) -> String {
    const LONGEST: usize = 60;
    let before = source.get(..offset).unwrap_or(source);
    let start = before.rfind('\n').map_or(0, |newline| newline + 1);
    let line = source.get(start..).unwrap_or_default();
    let line = line.lines().next().unwrap_or_default().trim();
    match line.char_indices().nth(LONGEST) {
        _ if line.is_empty() => String::new(),
        Some((end, _)) => format!(", in `{}…`", line.get(..end).unwrap_or_default()),
        None => format!(", in `{line}`"),
    }
}

/// What a file without `[solver]` or `[fallback]` stands for.
fn of_type<'t>(tag: &'static str) -> Section<'t> {
    let mut keys = DeTable::new();
    keys.insert(
        Spanned::new(0..0, "type".into()),
        Spanned::new(0..0, DeValue::String(tag.into())),
    );
    Section { span: 0..0, keys }
}

/// What a file without `[measurement]` stands for.
fn no_keys<'t>() -> Section<'t> {
    Section {
        span: 0..0,
        keys: DeTable::new(),
    }
}

fn name_of<'a>(section: &'a Section<'_>) -> Option<&'a str> {
    section.keys.get("name")?.get_ref().as_str()
}

/// The first section of each name.
fn positions(sections: &[Section<'_>]) -> HashMap<String, usize> {
    let mut positions = HashMap::new();
    for (index, section) in sections.iter().enumerate() {
        if let Some(name) = name_of(section) {
            positions.entry(name.to_owned()).or_insert(index);
        }
    }
    positions
}

fn named<'a, 't>(
    sections: &'a mut [Section<'t>],
    positions: &HashMap<String, usize>,
    name: &str,
) -> Result<&'a mut Section<'t>, Vec<&'a str>> {
    match positions.get(name) {
        Some(&index) => sections.get_mut(index).ok_or_else(Vec::new),
        None => Err(sections.iter().filter_map(name_of).collect()),
    }
}

fn table<'t>(
    name: &str,
    value: Spanned<DeValue<'t>>,
    at: &At,
    report: &mut Report<'_>,
) -> Option<Section<'t>> {
    let span = value.span();
    match value.into_inner() {
        DeValue::Table(keys) => Some(Section { span, keys }),
        other => {
            let message = wrong_shape(name, &other, &format!("a table, `[{name}]`"));
            report.add(Kind::Value, Some(first(span, &other)), at, message);
            None
        }
    }
}

fn list<'t>(
    name: &str,
    value: Spanned<DeValue<'t>>,
    at: &At,
    report: &mut Report<'_>,
) -> Vec<Section<'t>> {
    let span = value.span();
    let expected = format!("a list of tables, each `[[{name}]]`");
    let elements = match value.into_inner() {
        DeValue::Array(elements) => elements,
        other => {
            let message = wrong_shape(name, &other, &expected);
            report.add(Kind::Value, Some(span), at, message);
            return Vec::new();
        }
    };
    let mut sections = Vec::new();
    for element in elements {
        let span = element.span();
        match element.into_inner() {
            DeValue::Table(keys) => sections.push(Section { span, keys }),
            other => {
                let message = wrong_shape(name, &other, &expected);
                report.add(Kind::Value, Some(span), at, message);
            }
        }
    }
    sections
}

fn wrong_shape(name: &str, found: &DeValue<'_>, expected: &str) -> String {
    let found = match found {
        DeValue::Array(elements) if elements.iter().all(|element| element.get_ref().is_table()) => {
            "list of tables"
        }
        other => other.type_str(),
    };
    format!("`{name}` must be {expected}, found {found}")
}

/// Where a value begins: a list of tables has no place of its own.
fn first(span: Span, value: &DeValue<'_>) -> Span {
    match value {
        DeValue::Array(elements) => elements.first().map_or(span, Spanned::span),
        _ => span,
    }
}
