//! Collects what is wrong with a configuration, as spans; turns it into sorted errors with line and column.

use std::{fmt, ops::Range};

use super::{ConfigError, ConfigErrorKind, ConfigErrors, overrides::Applied};
use crate::robot::Place;

/// Syntax errors that are told: one slip makes a parser stumble over what follows.
const SYNTAX_ERRORS: usize = 3;

/// Bytes of the text that is read: the file, and behind its end the values of the overrides.
pub(super) type Span = Range<usize>;

/// A step into a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Step {
    Key(String),
    Index(usize),
}

/// Where in an entry: `reference.to[2]`.
pub(super) struct Path<'a>(pub(super) &'a [Step]);

impl fmt::Display for Path<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, step) in self.0.iter().enumerate() {
            match step {
                Step::Key(key) if index == 0 => f.write_str(key)?,
                Step::Key(key) => write!(f, ".{key}")?,
                Step::Index(element) => write!(f, "[{element}]")?,
            }
        }
        Ok(())
    }
}

/// Whose problem it is: an entry, and a path into it.
#[derive(Clone, Debug, Default)]
pub(super) struct At {
    pub(super) subject: String,
    pub(super) path: Vec<Step>,
}

impl At {
    pub(super) fn subject(subject: impl Into<String>) -> Self {
        Self {
            subject: subject.into(),
            path: Vec::new(),
        }
    }

    pub(super) fn key(&self, key: &str) -> Self {
        self.then(&[Step::Key(key.to_owned())])
    }

    pub(super) fn then(&self, steps: &[Step]) -> Self {
        let mut at = self.clone();
        at.path.extend_from_slice(steps);
        at
    }
}

struct Problem {
    kind: ConfigErrorKind,
    span: Option<Span>,
    at: At,
    message: String,
}

/// The text, and what is wrong with it so far.
pub(super) struct Report<'a> {
    file: &'a str,
    text: &'a str,
    overrides: Vec<Applied>,
    /// Starts of the tables of the file, sorted.
    sections: Vec<usize>,
    problems: Vec<Problem>,
}

impl<'a> Report<'a> {
    pub(super) fn new(file: &'a str, text: &'a str, overrides: Vec<Applied>) -> Self {
        Self {
            file,
            text,
            overrides,
            sections: Vec::new(),
            problems: Vec::new(),
        }
    }

    pub(super) fn set_sections(&mut self, mut starts: Vec<usize>) {
        starts.sort_unstable();
        self.sections = starts;
    }

    pub(super) fn add(
        &mut self,
        kind: ConfigErrorKind,
        span: Option<Span>,
        at: &At,
        message: impl Into<String>,
    ) {
        self.problems.push(Problem {
            kind,
            span,
            at: at.clone(),
            message: message.into(),
        });
    }

    /// Number of problems so far: tells whether a step found any.
    pub(super) fn len(&self) -> usize {
        self.problems.len()
    }

    pub(super) fn place(&self, span: &Span) -> Place {
        if self.applied(span).is_some() {
            return Place::file(self.file);
        }
        let (line, column) = self.position(span.start);
        Place::at(self.file, line, column)
    }

    fn applied(&self, span: &Span) -> Option<&Applied> {
        self.overrides
            .iter()
            .find(|applied| applied.span.start <= span.start && span.start < applied.span.end)
    }

    /// Line and column in characters, from 1.
    fn position(&self, offset: usize) -> (usize, usize) {
        let mut end = offset.min(self.text.len());
        while !self.text.is_char_boundary(end) {
            end -= 1;
        }
        let before = self.text.get(..end).unwrap_or_default();
        let line = before.matches('\n').count() + 1;
        let start = before.rfind('\n').map_or(0, |newline| newline + 1);
        let column = before.get(start..).unwrap_or_default().chars().count() + 1;
        (line, column)
    }

    /// A broken line breaks what is read from it: those problems go away with it.
    fn is_follow_up(&self, problem: &Problem, syntax: &[Span]) -> bool {
        if problem.kind == ConfigErrorKind::Syntax || syntax.is_empty() {
            return false;
        }
        let Some(span) = &problem.span else {
            return problem.kind == ConfigErrorKind::MissingKey;
        };
        if self.applied(span).is_some() {
            return false;
        }
        let line = self.position(span.start).0;
        let touched = syntax.iter().any(|broken| {
            (broken.start <= span.end && span.start <= broken.end)
                || self.position(broken.start).0 == line
        });
        let end = self
            .sections
            .iter()
            .copied()
            .find(|start| *start > span.start)
            .unwrap_or(usize::MAX);
        let missing = problem.kind == ConfigErrorKind::MissingKey
            && syntax
                .iter()
                .any(|broken| broken.start >= span.start && broken.start <= end);
        touched || missing
    }

    /// The errors, sorted by position; nothing if there are none.
    pub(super) fn finish(mut self) -> Result<(), ConfigErrors> {
        let syntax: Vec<Span> = self
            .problems
            .iter()
            .filter(|problem| problem.kind == ConfigErrorKind::Syntax)
            .filter_map(|problem| problem.span.clone())
            .collect();
        let mut problems = std::mem::take(&mut self.problems);
        problems.retain(|problem| !self.is_follow_up(problem, &syntax));
        if problems.is_empty() {
            return Ok(());
        }
        problems.sort_by_key(|problem| problem.span.as_ref().map(|span| span.start));
        let mut syntax = 0;
        problems.retain(|problem| {
            let is_syntax = problem.kind == ConfigErrorKind::Syntax;
            syntax += usize::from(is_syntax);
            !is_syntax || syntax <= SYNTAX_ERRORS
        });
        let mut errors: Vec<ConfigError> = problems
            .into_iter()
            .map(|problem| self.error(problem))
            .collect();
        errors.dedup();
        Err(ConfigErrors::new(errors))
    }

    fn error(&self, problem: Problem) -> ConfigError {
        let At { subject, path } = problem.at;
        let mut path = path.as_slice();
        let (place, subject) = match &problem.span {
            None => (Place::file(self.file), subject),
            Some(span) => match self.applied(span) {
                None => (self.place(span), subject),
                Some(applied) => {
                    // The override's own name has the key.
                    if let [Step::Key(key), rest @ ..] = path
                        && *key == applied.key
                    {
                        path = rest;
                    }
                    (Place::file(self.file), applied.subject.clone())
                }
            },
        };
        let message = if path.is_empty() {
            problem.message
        } else {
            format!("{}: {}", Path(path), problem.message)
        };
        ConfigError {
            kind: problem.kind,
            place: Some(place),
            subject,
            message,
        }
    }
}
