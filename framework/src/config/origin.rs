//! Where in the file something is that only the robot showed to be wrong.
//!
//! Plug-ins are bound long after the text was read. If one is refused, the text is read once more, and the entry and
//! its key are looked up in it: nothing has to be kept for the case that all is well.

use std::collections::HashMap;

use toml::{
    Spanned,
    de::{DeTable, DeValue},
};

use super::{
    ConfigError, ConfigErrorKind as Kind, ConfigErrors, Overrides,
    document::{Directory, Document},
    expand::{self, Reading, Texts},
    overrides::OverrideText,
    report::{At, Path, Report, Span, Step},
    table::Section,
};
use crate::{
    controller::{Misfit, MisfitKind},
    error::BindError,
    input::nearest,
    settings::Target,
};
use wbqp_robot_model::{RobotError, SourceFile, SourceLocation};

/// Where a configuration comes from.
#[derive(Debug)]
pub(crate) struct Origin {
    source: Option<SourceFile>,
    overrides: Overrides,
}

impl Origin {
    pub(crate) fn new(source: Option<SourceFile>, overrides: Overrides) -> Self {
        Self { source, overrides }
    }

    /// The errors of what does not fit, in the order of the file if there is one.
    pub(crate) fn errors(&self, misfits: Vec<Misfit>) -> ConfigErrors {
        let Some(source) = &self.source else {
            return ConfigErrors::new(misfits.into_iter().map(without_place).collect());
        };
        self.with_document(source, |document, report| {
            let directory = document.directory();
            for misfit in &misfits {
                let section = document.target(&misfit.target, &directory).ok();
                let at = At::subject(&misfit.subject);
                report_as(
                    kind_of(misfit),
                    &misfit.error,
                    section.as_deref(),
                    &at,
                    report,
                );
            }
        })
    }

    /// Where in `[robot]` the cause of each error is: the option, or the name of the file. The text is read once for
    /// all of them.
    pub(crate) fn robot_places(&self, errors: &[RobotError]) -> Vec<Option<SourceLocation>> {
        let mut places = Vec::with_capacity(errors.len());
        if let Some(source) = &self.source {
            self.with_document(source, |document, report| {
                let Ok(section) = document.target(&Target::Robot, &Directory::default()) else {
                    return;
                };
                // Thousands of errors of one file have one place.
                let mut found: HashMap<Cause<'_>, SourceLocation> = HashMap::new();
                for error in errors {
                    let place = found.entry(Cause::of(error)).or_insert_with_key(|cause| {
                        let path = find(&section.keys, &|key, value| cause.is_it(key, value));
                        report.place(&span_of(section, &path.unwrap_or_default()))
                    });
                    places.push(Some(place.clone()));
                }
            });
        }
        places.resize(errors.len(), None);
        places
    }

    fn with_document(
        &self,
        source: &SourceFile,
        add: impl FnOnce(&mut Document<'_>, &mut Report<'_>),
    ) -> ConfigErrors {
        let text = &source.contents;
        let appendix = OverrideText::new(&self.overrides, text.len());
        let applied = || appendix.applied(&self.overrides);
        // The text was accepted before.
        let mut ignored = Report::new(&source.name, text, applied());
        let texts = Texts::default();
        let (mut document, _) = expand::read(
            text,
            Reading::File,
            &self.overrides,
            &appendix,
            &texts,
            &mut ignored,
        );
        let mut report = Report::new(&source.name, text, applied());
        add(&mut document, &mut report);
        report
            .finish()
            .err()
            .unwrap_or_else(|| ConfigErrors::new(Vec::new()))
    }
}

/// What in `[robot]` an error of the robot is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Cause<'e> {
    Option(&'e str),
    File(&'e str),
    Other,
}

impl<'e> Cause<'e> {
    fn of(error: &'e RobotError) -> Self {
        match error {
            RobotError::Option { option, .. } => Self::Option(option),
            RobotError::Read { file, .. } | RobotError::Model { file, .. } => Self::File(file),
            RobotError::Syntax { place, .. } | RobotError::Element { place, .. } => {
                Self::File(&place.file)
            }
            _ => Self::Other,
        }
    }

    /// Whether it is about a key, or about a key's value if that is a string.
    fn is_it(&self, key: &str, value: Option<&str>) -> bool {
        match self {
            Self::Option(option) => key == *option,
            Self::File(file) => is_end_of(file, value),
            Self::Other => false,
        }
    }
}

fn without_place(misfit: Misfit) -> ConfigError {
    let (path, what) = in_words(&misfit.error);
    let message = if path.is_empty() {
        what
    } else {
        format!("{}: {what}", Path(&path))
    };
    ConfigError {
        kind: kind_of(&misfit),
        place: None,
        subject: misfit.subject,
        message,
    }
}

/// Reports an error of an entry whose table is known, at the key that it names.
pub(super) fn report(
    error: &BindError,
    section: Option<&Section<'_>>,
    at: &At,
    report: &mut Report<'_>,
) {
    report_as(kind(error), error, section, at, report);
}

fn report_as(
    kind: Kind,
    error: &BindError,
    section: Option<&Section<'_>>,
    at: &At,
    report: &mut Report<'_>,
) {
    let (mut path, message) = in_words(error);
    let mut span = None;
    if let Some(section) = section {
        if let BindError::Unknown { name, .. } = error
            && let Some(found) = find(&section.keys, &|_, value| value == Some(name))
        {
            path = found;
        }
        span = Some(span_of(section, &path));
    }
    // An empty span is a table that the file does not have.
    let span = span.filter(|span| !span.is_empty());
    report.add(kind, span, &at.then(&path), message);
}

fn kind_of(misfit: &Misfit) -> Kind {
    match misfit.kind {
        MisfitKind::Parameter => kind(&misfit.error),
        MisfitKind::Hover => Kind::Hover,
    }
}

fn kind(error: &BindError) -> Kind {
    match error {
        BindError::Unknown { .. } => Kind::UnknownName,
        BindError::Length { .. } | BindError::Value { .. } => Kind::Value,
        BindError::Other(_) => Kind::Misfit,
    }
}

/// The key that an error is about, and what it says of it.
fn in_words(error: &BindError) -> (Vec<Step>, String) {
    match error {
        BindError::Length { key, got, expected } => {
            let entries = if *got == 1 { "entry" } else { "entries" };
            (
                steps(key),
                format!("has {got} {entries}, expected {expected}"),
            )
        }
        BindError::Value { key, problem } => (steps(key), problem.clone()),
        other => (Vec::new(), other.to_string()),
    }
}

/// `points[1].at` as steps.
fn steps(path: &str) -> Vec<Step> {
    let mut steps = Vec::new();
    for part in path.split('.') {
        let mut pieces = part.split('[');
        steps.extend(pieces.next().map(|key| Step::Key(key.to_owned())));
        for piece in pieces {
            let index = piece.strip_suffix(']').and_then(|index| index.parse().ok());
            steps.extend(index.map(Step::Index));
        }
    }
    steps
}

/// Where the value of a path is; the nearest thing around it that is written out.
fn span_of(section: &Section<'_>, path: &[Step]) -> Span {
    nearest(&section.keys, path).map_or_else(|| section.span.clone(), Spanned::span)
}

/// Whether a value is a path that ends a file's name.
fn is_end_of(file: &str, value: Option<&str>) -> bool {
    value.is_some_and(|value| !value.is_empty() && file.ends_with(value))
}

/// Whether a key with its value, if that is a string, is what is looked for.
type IsIt<'a> = &'a dyn Fn(&str, Option<&str>) -> bool;

/// The first key or element of a list that is looked for, beside the table's own name and type.
fn find(keys: &DeTable<'_>, is_it: IsIt<'_>) -> Option<Vec<Step>> {
    keys.iter()
        .filter(|(key, _)| !["name", "type"].contains(&&**key.get_ref()))
        .find_map(|(key, value)| {
            let key: &str = key.get_ref();
            find_in(Step::Key(key.to_owned()), key, value, is_it)
        })
}

fn find_in(
    step: Step,
    key: &str,
    value: &Spanned<DeValue<'_>>,
    is_it: IsIt<'_>,
) -> Option<Vec<Step>> {
    let value = value.get_ref();
    if is_it(key, value.as_str()) {
        return Some(vec![step]);
    }
    let mut path = match value {
        DeValue::Array(elements) => elements
            .iter()
            .enumerate()
            .find_map(|(index, element)| find_in(Step::Index(index), "", element, is_it)),
        DeValue::Table(keys) => find(keys, is_it),
        _ => None,
    }?;
    path.insert(0, step);
    Some(path)
}
