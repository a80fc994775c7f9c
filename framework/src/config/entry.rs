//! Reads a task or constraint: the framework's keys, and the plug-in among them.

use std::collections::HashMap;

use serde::{Deserialize, de::DeserializeOwned};
use toml::{
    Spanned,
    de::{DeValue, ValueDeserializer},
};

use super::{
    ConfigErrorKind as Kind, expand,
    plausible::WEIGHTS,
    report::{At, Report, Span, Step},
    table::{self, Section},
};
use crate::{
    one_line::{CONTROL, one_line},
    plugin::{Entry, Hardness, PerRow},
    registry::{self, PluginKind},
};
use wbqp_robot_model::SourceLocation;

/// Reads a task or constraint.
pub(super) fn read<P: PluginKind + ?Sized>(
    index: usize,
    mut section: Section<'_>,
    default_hardness: Hardness,
    names: &mut Names,
    report: &mut Report<'_>,
) -> Option<Entry<P>> {
    let at = At::subject(subject(P::NAME, Some(index), &section));
    let header = section.span.clone();
    let remedy = expand::remedy(&section);
    // Of a type that is not known it is not known either what it can do without.
    let is_known = match expand::value::string(&section, "type") {
        Some(tag) => registry::find::<P>(tag).is_some(),
        None => true,
    };
    let mut take = |key: &str| section.take(key);

    // Without a type, of which the plug-in tells, there is no name either.
    let name: Option<String> = take("name").and_then(|name| {
        names.check(P::NAME, &name, remedy, &at, report);
        table::value(name, &at.key("name"), report)
    });
    let hardness = match take("hardness") {
        Some(value) => hardness(value, &at.key("hardness"), report),
        None => Some(default_hardness),
    };
    let weight = match take("weight") {
        Some(value) => weight(value, &at, report),
        None if hardness.is_none_or(|hardness| hardness == Hardness::Hard) => {
            Some(PerRow::Uniform(1.0))
        }
        None => {
            if is_known {
                let message = match hardness {
                    Some(Hardness::Exact(_)) => {
                        "key `weight` is missing, the price w of `w s² + λ s`: `weight = 1.0`, for example"
                    }
                    _ => {
                        "key `weight` is missing, the price of residual²: `weight = 1.0`, for example"
                    }
                };
                report.add(Kind::MissingKey, Some(header), &at, message);
            }
            None
        }
    };
    let active = optional(take("active"), true, &at.key("active"), report);
    let transition = match take("transition") {
        Some(value) => {
            let at = at.key("transition");
            let span = value.span();
            table::value(value, &at, report)
                .filter(|seconds| not_negative(*seconds, &span, &at, report))
        }
        None => Some(0.0),
    };
    if let Some(level) = take("level") {
        let message = "key `level` is reserved for lexicographic levels, not supported yet";
        report.add(Kind::Reserved, Some(level.span()), &at, message);
    }
    let plugin = table::plugin::<P>(section, &SHOWN_ENTRY_KEYS, &at, report);
    Some(Entry {
        name: name?,
        weight: weight?,
        active: active?,
        transition: transition?,
        hardness: hardness?,
        plugin: plugin?,
    })
}

/// The entry keys that a message lists: `level` cannot be used.
const SHOWN_ENTRY_KEYS: [&str; 5] = ["active", "hardness", "name", "transition", "weight"];

fn optional<T: DeserializeOwned>(
    value: Option<Spanned<DeValue<'_>>>,
    default: T,
    at: &At,
    report: &mut Report<'_>,
) -> Option<T> {
    match value {
        Some(value) => table::value(value, at, report),
        None => Some(default),
    }
}

fn hardness(value: Spanned<DeValue<'_>>, at: &At, report: &mut Report<'_>) -> Option<Hardness> {
    let span = value.span();
    match Hardness::deserialize(ValueDeserializer::from(value)) {
        Ok(Hardness::Exact(price)) if !price.is_finite() || price <= 0.0 => {
            let message = format!("exact: must be finite and positive, is {price}");
            report.add(Kind::Value, Some(span), at, message);
            None
        }
        Ok(Hardness::Exact(price)) if !WEIGHTS.contains(&price) => {
            let [least, most] = [WEIGHTS.start(), WEIGHTS.end()];
            let message = format!("exact: is {price:e}, must be between {least:e} and {most:e}");
            report.add(Kind::Value, Some(span), at, message);
            None
        }
        Ok(hardness) => Some(hardness),
        Err(error) => {
            let span = error.span().unwrap_or(span);
            let message = "must be \"hard\", \"soft\" or { exact = λ } with a number λ";
            report.add(Kind::Value, Some(span), at, message);
            None
        }
    }
}

fn weight(value: Spanned<DeValue<'_>>, at: &At, report: &mut Report<'_>) -> Option<PerRow> {
    let at = at.key("weight");
    let span = value.span();
    let rows: Option<Vec<Span>> = match value.get_ref() {
        DeValue::Array(rows) => Some(rows.iter().map(Spanned::span).collect()),
        _ => None,
    };
    let weight: PerRow = table::value(value, &at, report)?;
    let mut valid = true;
    for (row, value) in weight.values().iter().enumerate() {
        match rows.as_ref().and_then(|rows| rows.get(row)) {
            Some(span) => {
                valid &= not_negative(*value, span, &at.then(&[Step::Index(row)]), report);
            }
            None => valid &= not_negative(*value, &span, &at, report),
        }
    }
    valid.then_some(weight)
}

fn not_negative(value: f64, span: &Span, at: &At, report: &mut Report<'_>) -> bool {
    let valid = value.is_finite() && value >= 0.0;
    if !valid {
        let message = format!("must be finite and not negative, is {value}");
        report.add(Kind::Value, Some(span.clone()), at, message);
    }
    valid
}

/// ``task[0] `arm` (posture)``, as far as the file says.
pub(super) fn subject(kind: &str, index: Option<usize>, section: &Section<'_>) -> String {
    let text = |key| {
        section
            .keys
            .get(key)
            .and_then(|value| value.get_ref().as_str())
    };
    let mut subject = kind.to_owned();
    if let Some(index) = index {
        subject.push_str(&format!("[{index}]"));
        if let Some(name) = text("name") {
            subject.push_str(&format!(" `{}`", one_line(name)));
        }
    }
    if let Some(tag) = text("type") {
        subject.push_str(&format!(" ({})", one_line(tag)));
    }
    subject
}

/// The names given so far, with their places.
#[derive(Default)]
pub(super) struct Names(HashMap<String, SourceLocation>);

impl Names {
    pub(super) fn check(
        &mut self,
        kind: &str,
        value: &Spanned<DeValue<'_>>,
        remedy: &str,
        at: &At,
        report: &mut Report<'_>,
    ) {
        let Some(name) = value.get_ref().as_str() else {
            return;
        };
        let span = value.span();
        if name.is_empty() {
            report.add(
                Kind::Value,
                Some(span),
                &at.key("name"),
                "must not be empty",
            );
            return;
        }
        if name.contains(char::is_control) {
            report.add(Kind::Value, Some(span), &at.key("name"), CONTROL);
            return;
        }
        if let Some(first) = self.0.get(name) {
            let others = match kind {
                "contact" => "contact",
                _ => "task or constraint",
            };
            let message = format!("name `{name}` is taken by the {others} at {first}{remedy}");
            report.add(Kind::Duplicate, Some(span), at, message);
        } else {
            let place = report.place(&span);
            self.0.insert(name.to_owned(), place);
        }
    }
}
