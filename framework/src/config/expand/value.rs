//! Values that no file has.

use std::borrow::Cow;

use toml::{
    Spanned,
    de::{DeString, DeValue},
};

use super::{Span, key_at};
use crate::config::table::Section;

/// A string at a place.
pub(super) fn text<'t>(words: impl Into<Cow<'t, str>>, span: &Span) -> Spanned<DeValue<'t>> {
    Spanned::new(span.clone(), DeValue::String(words.into()))
}

/// A value from its text, with a place of its own.
pub(super) fn parsed<'t>(text: &'t str, span: &Span) -> Option<Spanned<DeValue<'t>>> {
    let value = DeValue::parse(text).ok()?.into_inner();
    Some(placed(value, span))
}

/// Everything in a value at one place.
fn placed<'t>(mut value: DeValue<'t>, span: &Span) -> Spanned<DeValue<'t>> {
    let place = |value: &mut Spanned<DeValue<'t>>| {
        let inner = std::mem::replace(value.get_mut(), DeValue::Boolean(false));
        *value = placed(inner, span);
    };
    match &mut value {
        DeValue::Array(elements) => elements.iter_mut().for_each(place),
        DeValue::Table(keys) => keys.iter_mut().for_each(|(_, value)| place(value)),
        _ => {}
    }
    Spanned::new(span.clone(), value)
}

/// The numbers of a value that is one, or a list of them.
pub(super) fn numbers(value: &DeValue<'_>) -> Option<Vec<f64>> {
    match value {
        DeValue::Array(elements) => elements
            .iter()
            .map(|element| number(element.get_ref()))
            .collect(),
        one => Some(vec![number(one)?]),
    }
}

/// A number, whole or not.
pub(in crate::config) fn number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        // Digits may be grouped.
        DeValue::Float(x) => x.as_str().replace('_', "").parse().ok(),
        DeValue::Integer(x) => {
            let digits = x.as_str().replace('_', "");
            i64::from_str_radix(&digits, x.radix())
                .ok()
                .map(|x| x as f64)
        }
        _ => None,
    }
}

/// A value as a file says it, on one line.
pub(super) fn written(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(words) => toml::Value::String(words.to_string()).to_string(),
        DeValue::Integer(x) => x.to_string(),
        DeValue::Float(x) => x.to_string(),
        DeValue::Boolean(is) => is.to_string(),
        DeValue::Datetime(date) => date.to_string(),
        DeValue::Array(elements) => {
            let elements: Vec<_> = elements.iter().map(|e| written(e.get_ref())).collect();
            format!("[{}]", elements.join(", "))
        }
        DeValue::Table(keys) => {
            let pairs: Vec<_> = keys
                .iter()
                .map(|(key, value)| format!("{} = {}", key.get_ref(), written(value.get_ref())))
                .collect();
            format!("{{ {} }}", pairs.join(", "))
        }
    }
}

/// Puts a key into a table.
pub(super) fn put<'t>(section: &mut Section<'t>, key: &'static str, value: Spanned<DeValue<'t>>) {
    let key = Spanned::new(key_at(&value.span()), DeString::Borrowed(key));
    section.keys.insert(key, value);
}

/// The string of a key, if it is one.
pub(in super::super) fn string<'a>(section: &'a Section<'_>, key: &str) -> Option<&'a str> {
    section.keys.get(key)?.get_ref().as_str()
}
