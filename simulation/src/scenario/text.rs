//! The text of a scenario's file with what is changed in it, and how errors call its places.

use std::sync::OnceLock;

use wbqp::config::{ConfigErrors, in_words};

use super::{
    ScenarioError, Variation,
    change::{LISTS, Refusal},
    parts::Sections,
};

/// The text of a file, and behind its end a variation's changes: what is read from them has spans that no part of the
/// file has.
pub(super) struct Text<'a> {
    name: &'a str,
    file: &'a str,
    variation: &'a Variation,
    pub(super) changes: String,
    /// Where entries stand that are parsed one by one; nothing if all is parsed at once.
    pub(super) sections: Option<Sections>,
    /// Of the cases, once somebody asks.
    pub(super) longest: OnceLock<f64>,
}

/// The lists whose entries may be parsed one by one: those that have members, and the cases.
fn paths() -> Vec<&'static [&'static str]> {
    LISTS.iter().map(|list| list.path).chain([CASE]).collect()
}

pub(super) const CASE: &[&str] = &["case"];

impl<'a> Text<'a> {
    pub(super) fn new(name: &'a str, text: &'a str, variation: &'a Variation) -> Self {
        let changes = " ".repeat(text.len() + 1) + &variation.changes();
        Self {
            name,
            file: text,
            variation,
            changes,
            sections: Sections::of(text, &paths()),
            longest: OnceLock::new(),
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
        let place = self.variation.display(line.unwrap_or_default());
        if self.variation.is_option() {
            place
        } else {
            format!("{}: {place}", self.name)
        }
    }

    /// Where the name of a case is.
    pub(super) fn place_of_case(&self, name: &str) -> Option<String> {
        let cases = self.opened().ok()?;
        let name = cases.name(cases.index(name)?)?;
        Some(self.place(name.span().start))
    }

    /// The options that gave what is wrong with a controller, if nothing else is.
    pub(super) fn option_of(&self, errors: &ConfigErrors) -> Option<String> {
        let options = errors.iter().map(|error| self.variation.option_of(error));
        let mut options: Vec<String> = options.collect::<Option<_>>()?;
        options.dedup();
        Some(options.join("`, `"))
    }

    pub(super) fn error(&self, error: &toml::de::Error) -> ScenarioError {
        let message = in_words(error.message());
        let key = error.span().and_then(|span| self.key_of_value(&span));
        ScenarioError::Syntax {
            place: self.place(error.span().map_or(0, |span| span.start)),
            message: match key {
                Some(key) => format!("{key}: {message}"),
                None => message,
            },
        }
    }

    /// The file's text.
    pub(super) fn file(&self) -> &str {
        self.file
    }

    pub(super) fn refusal(&self, refusal: Refusal) -> ScenarioError {
        ScenarioError::Syntax {
            place: self.place(refusal.span.start),
            message: refusal.message,
        }
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
pub(super) fn place(name: &str, text: &str, offset: usize) -> String {
    let before = text.get(..offset.min(text.len())).unwrap_or(text);
    let line = before.matches('\n').count() + 1;
    let column = before.chars().rev().take_while(|&c| c != '\n').count() + 1;
    format!("{name}:{line}:{column}")
}
