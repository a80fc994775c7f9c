//! Where in a scenario's file that stands which a check refuses: at the key that the message begins with.
//!
//! Looked for once something is wrong, so that a case has no places to carry along.

use std::ops::Range;

use toml::{
    Spanned,
    de::{DeTable, DeValue},
};
use wbqp::{
    config::{ConfigErrorKind, ConfigErrors},
    input::{Step, TablePath, locate, nearest},
};

use super::{ScenarioError, change::Events, text::Text};
use crate::PlantError;

impl Text<'_> {
    /// The key, with all that it is in, whose value is at a place of the file. Nothing for a table, whose own keys are
    /// what is wrong with it, for what is between values, and for a variation, whose places are its keys.
    pub(super) fn key_of_value(&self, span: &Range<usize>) -> Option<String> {
        let root = DeTable::parse(self.file()).ok()?;
        let path = locate(root.get_ref(), span)?;
        let value = nearest(root.get_ref(), &path)?;
        // A key alone, which is wrong itself, has its place before its value.
        let is_value = !value.get_ref().is_table() && value.span().start <= span.start;
        is_value.then(|| TablePath(&path).to_string())
    }

    /// Where the key of a case's event is that a message begins with, or else the event.
    pub(super) fn place_in_event(
        &self,
        case: &str,
        index: usize,
        event: &Range<usize>,
        message: &str,
    ) -> String {
        let found = self.opened().ok().and_then(|cases| {
            let (tables, events) = self.tables(&cases, cases.index(case)?).ok()?;
            match events {
                Events::Put => {
                    let mut path = vec![key("event"), Step::Index(index)];
                    path.extend(steps(message));
                    find(&tables, &path, message)
                }
                Events::LeftOut => {
                    let entry = cases.members().events(case).nth(index)??;
                    find_in(&entry, &steps(message), message)
                }
            }
        });
        self.place(found.map_or(event.start, |span| span.start))
    }

    /// The same error with the places that it can have.
    pub(super) fn located(&self, error: ScenarioError, case: &str) -> ScenarioError {
        let Ok(cases) = self.opened() else {
            return error;
        };
        let index = cases.index(case);
        let tables = index.map(|index| self.tables(&cases, index));
        let (Some(name), Some(Ok((tables, _)))) = (index.and_then(|i| cases.name(i)), tables)
        else {
            return error;
        };
        let place = |path: &[Step], about: &str| {
            let span = find(&tables, path, about);
            span.map_or_else(|| self.name().to_owned(), |span| self.place(span.start))
        };
        let whole = |file: String, source: &ConfigErrors| {
            let is_read = |kind| matches!(kind, ConfigErrorKind::Read);
            if source.iter().any(|error| is_read(error.kind)) {
                return place(&[key("controller")], "");
            }
            let start = name.span().start;
            if file == self.name() {
                self.place(start)
            } else {
                file
            }
        };
        let option = match &error {
            ScenarioError::Config { source, .. } | ScenarioError::Controller { source, .. } => {
                self.option_of(source)
            }
            _ => None,
        };
        match error {
            ScenarioError::Value { place: file, what } if file == self.name() => {
                ScenarioError::Value {
                    place: place(&steps(&what), &what),
                    what,
                }
            }
            ScenarioError::Plant {
                file,
                table,
                source,
                ..
            } => ScenarioError::Plant {
                file,
                table,
                places: match source.as_ref() {
                    PlantError::Config { problems } => {
                        let place = |problem: &String| {
                            let mut path = vec![key(table)];
                            path.extend(steps(problem));
                            place(&path, "")
                        };
                        problems.iter().map(place).collect()
                    }
                    PlantError::State(what) if what.starts_with("joint") => {
                        vec![place(&[key("initial"), key("joints")], what)]
                    }
                    PlantError::State(what) => vec![place(&[key("initial")], what)],
                    PlantError::Stiff { .. } => {
                        vec![place(&[key("plant"), key("step")], "")]
                    }
                    PlantError::Mismatch(_) => {
                        vec![place(&[key("plant"), key("mismatch")], "")]
                    }
                    _ => Vec::new(),
                },
                source,
            },
            ScenarioError::Config { source, .. } | ScenarioError::Controller { source, .. }
                if option.is_some() =>
            {
                let option = option.unwrap_or_default();
                ScenarioError::Option { option, source }
            }
            ScenarioError::Config { file, case, source } => ScenarioError::Config {
                file: whole(file, &source),
                case,
                source,
            },
            ScenarioError::Controller { file, case, source } => ScenarioError::Controller {
                file: whole(file, &source),
                case,
                source,
            },
            other => other,
        }
    }
}

fn key(key: &str) -> Step {
    Step::Key(key.to_owned())
}

/// The path that a message begins with: of ``wall[0] `door`: friction: is -1`` the key `friction` of the first wall.
fn steps(message: &str) -> Vec<Step> {
    let mut path = Vec::new();
    let mut rest = message;
    loop {
        let is_key = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        let end = rest.find(|c| !is_key(c)).unwrap_or(rest.len());
        let (key, behind) = rest.split_at(end);
        if key.is_empty() {
            return path;
        }
        path.push(self::key(key));
        rest = behind;
        while let Some((index, behind)) = rest.strip_prefix('[').and_then(|r| r.split_once(']')) {
            let Ok(index) = index.parse() else {
                return path;
            };
            path.push(Step::Index(index));
            rest = behind;
        }
        let named = rest.strip_prefix(" `").and_then(|r| r.split_once("`: "));
        rest = match (named, rest.strip_prefix('.')) {
            (Some((_, behind)), _) | (None, Some(behind)) => behind,
            (None, None) => return path,
        };
    }
}

/// The value at the end of a path, or of as much of it as is there; nothing if none of it is. In a table at its end the
/// key that `about` names first.
fn find(root: &DeTable<'_>, path: &[Step], about: &str) -> Option<Range<usize>> {
    let Some((Step::Key(key), rest)) = path.split_first() else {
        let named = about.split('`').nth(1)?;
        return Some(root.get_key_value(named)?.0.span());
    };
    let (key, value) = root.get_key_value(key.as_str())?;
    Some(find_in(value, rest, about).unwrap_or_else(|| key_or_value(key.span(), value)))
}

fn find_in(value: &Spanned<DeValue<'_>>, path: &[Step], about: &str) -> Option<Range<usize>> {
    match (value.get_ref(), path.split_first()) {
        (DeValue::Table(table), _) => find(table, path, about),
        (DeValue::Array(list), Some((Step::Index(index), rest))) => {
            let element = list.get(*index)?;
            Some(find_in(element, rest, about).unwrap_or_else(|| element.span()))
        }
        _ => None,
    }
}

/// Tables are where their names are, which are in their headers.
fn key_or_value(key: Range<usize>, value: &Spanned<DeValue<'_>>) -> Range<usize> {
    match value.get_ref() {
        DeValue::Table(_) => key,
        _ => value.span(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_is_read_off_a_message() {
        use Step::Index;
        for (message, path) in [
            ("duration: is 0 s", vec![key("duration")]),
            (
                "initial.joints: the robot has no joint `a.b`",
                vec![key("initial"), key("joints")],
            ),
            (
                "wall[1] `a: b`: friction: is -1",
                vec![key("wall"), Index(1), key("friction")],
            ),
            (
                "force_torque[0].cutoff: is 0",
                vec![key("force_torque"), Index(0), key("cutoff")],
            ),
            ("", vec![]),
        ] {
            assert_eq!(steps(message), path, "{message}");
        }
    }
}
