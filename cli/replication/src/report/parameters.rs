//! Gains and parameters of a run, from the files that its log has attached.

use std::collections::BTreeSet;

use anyhow::{Context, Result};
use maud::{Markup, html};
use serde::Deserialize;
use toml::{Table, Value};
use wbqp::config::{ControllerConfig, Overrides};
use wbqp_measures::log::Log;

use crate::experiment::Runs;

/// What decides a case.
struct CaseFiles {
    case: String,
    /// Name and text of the scenario's file.
    scenario: (String, String),
    /// Name and text of the controller's file.
    controller: (String, String),
    /// What the case changes in either, `key = value`.
    changes: Vec<String>,
    /// Values in effect, as a controller's file that says all of them would have them.
    values: Vec<Part>,
}

/// A table of a controller's file.
struct Part {
    /// Its kind and name.
    title: String,
    keys: Vec<(String, String)>,
}

/// Folded: values in effect case by case, and the files.
///
/// # Errors
/// If a log lacks them.
pub(super) fn section(runs: &Runs) -> Result<Markup> {
    let mut cases = Vec::new();
    for case in runs.cases() {
        let files = CaseFiles::read(case, &runs.header(case)?);
        cases.push(files.with_context(|| format!("parameters of case {case}"))?);
    }
    let scenarios: BTreeSet<_> = cases.iter().map(|c| &c.scenario).collect();
    let controllers: BTreeSet<_> = cases.iter().map(|c| &c.controller).collect();
    Ok(html! {
        details {
            summary { "Gains and parameters in effect, case by case" }
            @if cases.iter().any(|c| !c.changes.is_empty()) {
                p { "What the cases change:" }
                ul {
                    @for case in &cases {
                        li {
                            b { (case.case) } ": "
                            @if case.changes.is_empty() { "nothing; the files as they are" }
                            @for (i, change) in case.changes.iter().enumerate() {
                                @if i > 0 { ", " }
                                code { (change) }
                            }
                        }
                    }
                }
            }
            (table(&cases))
        }
        @for (name, text) in controllers {
            details { summary { "The controller's file, " code { (name) } } pre { (text) } }
        }
        @for (name, text) in scenarios {
            details {
                summary { "The scenario's file, with plant and sensors, " code { (name) } }
                pre { (text) }
            }
        }
    })
}

/// A column per case; one for all where they agree.
fn table(cases: &[CaseFiles]) -> Markup {
    // Cases may have keys that others lack.
    let mut parts: Vec<(&str, Vec<&str>)> = Vec::new();
    for part in cases.iter().flat_map(|c| &c.values) {
        let known = parts.iter().position(|(title, _)| *title == part.title);
        let index = known.unwrap_or_else(|| {
            parts.push((&part.title, Vec::new()));
            parts.len() - 1
        });
        for (key, _) in &part.keys {
            if !parts[index].1.contains(&key.as_str()) {
                parts[index].1.push(key);
            }
        }
    }
    html! {
        div.scroll {
            table.values {
                thead { tr { th { "key" } @for case in cases { th { (case.case) } } } }
                tbody {
                    @for (title, keys) in &parts {
                        tr.part { th colspan=(cases.len() + 1) { (title) } }
                        @for key in keys {
                            (line(cases, title, key))
                        }
                    }
                }
            }
        }
    }
}

fn line(cases: &[CaseFiles], title: &str, key: &str) -> Markup {
    let value = |case: &CaseFiles| {
        let part = case.values.iter().find(|part| part.title == title)?;
        let found = part.keys.iter().find(|(k, _)| k == key)?;
        Some(found.1.clone())
    };
    let values: Vec<Option<String>> = cases.iter().map(value).collect();
    let same = values.windows(2).all(|pair| pair[0] == pair[1]);
    let shown = |value: &Option<String>| value.clone().unwrap_or_else(|| "–".to_owned());
    html! {
        tr {
            td { (key) }
            @if same {
                td colspan=(cases.len()) { (values.first().map(shown).unwrap_or_default()) }
            } @else {
                @for value in &values { td.differs { (shown(value)) } }
            }
        }
    }
}

impl CaseFiles {
    fn read(case: &str, log: &Log) -> Result<Self> {
        let named = |key: &str| {
            let mut files = log.attached_texts();
            let found = files.find_map(|(name, text)| {
                let table = text.parse::<Table>().ok()?;
                table.contains_key(key).then_some((name, text, table))
            });
            found.with_context(|| format!("the log has no file with `{key}`"))
        };
        let (scenario_name, scenario, tables) = named("case")?;
        let (controller_name, controller, _) = named("task")?;
        let own = tables
            .get("case")
            .and_then(Value::as_array)
            .and_then(|all| {
                let is_own = |c: &&Value| c.get("name").and_then(Value::as_str) == Some(case);
                all.iter().find(is_own)?.as_table()
            })
            .cloned()
            .unwrap_or_default();
        let overrides = match own.get("set") {
            Some(set) => Overrides::deserialize(set.clone())?,
            None => Overrides::default(),
        };
        let config = ControllerConfig::from_str_with(controller, controller_name, "", &overrides)?;
        let mut changes = Vec::new();
        for key in ["change", "set"] {
            if let Some(Value::Table(table)) = own.get(key) {
                flatten(table, &format!("{key}."), &mut changes);
            }
        }
        Ok(Self {
            case: case.to_owned(),
            scenario: (scenario_name.to_owned(), scenario.to_owned()),
            controller: (controller_name.to_owned(), controller.to_owned()),
            changes,
            values: parts(&config.to_toml()?.parse()?),
        })
    }
}

fn flatten(table: &Table, path: &str, lines: &mut Vec<String>) {
    for (key, value) in table {
        match value {
            Value::Table(inner) if !inner.contains_key("type") => {
                flatten(inner, &format!("{path}{key}."), lines);
            }
            value => lines.push(format!("{path}{key} = {value}")),
        }
    }
}

/// The tables of a controller's file in the order in which people write them.
fn parts(file: &Table) -> Vec<Part> {
    let mut parts = Vec::new();
    for kind in ["controller", "robot", "solver", "measurement"] {
        if let Some(Value::Table(table)) = file.get(kind) {
            parts.push(part(kind.to_owned(), table, &[]));
        }
    }
    for kind in ["contact", "task", "constraint"] {
        let entries = file.get(kind).and_then(Value::as_array);
        for table in entries.into_iter().flatten().filter_map(Value::as_table) {
            let text = |key: &str| table.get(key).and_then(Value::as_str).unwrap_or_default();
            let title = match text("type") {
                "" => format!("{kind} {}", text("name")),
                tag if tag == text("name") => format!("{kind} {tag}"),
                tag => format!("{kind} {} ({tag})", text("name")),
            };
            parts.push(part(title, table, &["name", "type"]));
        }
    }
    parts
}

/// As in a file, but small numbers without their zeros.
fn in_words(value: &Value) -> String {
    match value {
        Value::Float(x) if *x != 0.0 && x.abs() < 1e-3 => format!("{x:e}"),
        value => value.to_string(),
    }
}

/// The weight first, as in Table I.
fn part(title: String, table: &Table, without: &[&str]) -> Part {
    let shown = table
        .iter()
        .filter(|(key, _)| !without.contains(&key.as_str()));
    let mut keys: Vec<(String, String)> = shown
        .map(|(key, value)| (key.clone(), in_words(value)))
        .collect();
    keys.sort_by_key(|(key, _)| key != "weight");
    Part { title, keys }
}
