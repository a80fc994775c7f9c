//! Collects what is wrong with a configuration, as spans; turns it into sorted errors with line and column.

use std::ops::Range;

use super::{ConfigError, ConfigErrorKind, ConfigErrors, overrides::Applied};
pub(super) use crate::input::{Step, TablePath as Path};
use wbqp_robot_model::SourceLocation;

/// Syntax errors that are told: one slip makes a parser stumble over what follows.
const SYNTAX_ERRORS: usize = 3;

/// Errors that are told of a file: nobody reads more, and each takes memory.
pub(super) const MOST: usize = 10_000;

/// Values that are read again for the sake of bad ones, over all tables of a file: each bad one has its table read once
/// more, which would take time with the square of what there is.
const READ_AGAIN: usize = 1 << 24;

/// Bytes of the text that is read: the file, and behind its end the values of the overrides.
pub(super) type Span = Range<usize>;

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

fn lines(text: &str) -> Vec<usize> {
    let ends = text.match_indices('\n').map(|(at, _)| at + 1);
    std::iter::once(0).chain(ends).collect()
}

/// What a parser could not read.
struct Broken {
    /// By start.
    spans: Vec<Span>,
    /// The largest end of the spans up to each.
    ends: Vec<usize>,
    /// The lines on which they begin, sorted.
    lines: Vec<usize>,
}

impl Broken {
    fn new(spans: impl Iterator<Item = Span>, line: impl Fn(usize) -> usize) -> Self {
        let mut spans: Vec<Span> = spans.collect();
        spans.sort_unstable_by_key(|span| (span.start, span.end));
        let mut largest = 0;
        let ends = spans.iter().map(|span| {
            largest = largest.max(span.end);
            largest
        });
        Self {
            ends: ends.collect(),
            lines: spans.iter().map(|span| line(span.start)).collect(),
            spans,
        }
    }

    fn is_empty(&self) -> bool {
        self.spans.is_empty()
    }

    /// Whether one of them begins on a line.
    fn line(&self, line: usize) -> bool {
        self.lines.binary_search(&line).is_ok()
    }

    /// Whether one of them touches a span.
    fn touch(&self, span: &Span) -> bool {
        let before = self
            .spans
            .partition_point(|broken| broken.start <= span.end);
        before > 0
            && self
                .ends
                .get(before - 1)
                .is_some_and(|end| span.start <= *end)
    }

    /// Whether one of them begins in a range, its end included.
    fn begins_in(&self, range: Span) -> bool {
        let first = self
            .spans
            .partition_point(|broken| broken.start < range.start);
        self.spans
            .get(first)
            .is_some_and(|broken| broken.start <= range.end)
    }
}

/// The text, and what is wrong with it so far.
pub(super) struct Report<'a> {
    file: &'a str,
    text: &'a str,
    overrides: Vec<Applied>,
    /// Where each line of the text begins.
    lines: Vec<usize>,
    /// Starts of the tables of the file, sorted.
    sections: Vec<usize>,
    problems: Vec<Problem>,
    /// Problems beyond those that are told.
    untold: usize,
    /// Values that may still be read again.
    left: usize,
}

impl<'a> Report<'a> {
    pub(super) fn new(file: &'a str, text: &'a str, overrides: Vec<Applied>) -> Self {
        Self {
            file,
            text,
            overrides,
            lines: lines(text),
            sections: Vec::new(),
            problems: Vec::new(),
            untold: 0,
            left: READ_AGAIN,
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
        // What a parser stumbles over says which of the others do not count.
        if self.problems.len() >= MOST && kind != ConfigErrorKind::Syntax {
            self.untold += 1;
            return;
        }
        self.problems.push(Problem {
            kind,
            span,
            at: at.clone(),
            message: message.into(),
        });
    }

    /// Number of problems so far: tells whether a step found any.
    pub(super) fn len(&self) -> usize {
        self.problems.len() + self.untold
    }

    /// Whether a table with that many values may be read again: there is room for what is wrong with it, and time.
    pub(super) fn may_read_again(&mut self, values: usize) -> bool {
        let left = self.left.checked_sub(values);
        self.left = left.unwrap_or(0);
        left.is_some() && self.problems.len() < MOST
    }

    pub(super) fn place(&self, span: &Span) -> SourceLocation {
        if self.applied(span).is_some() {
            return SourceLocation::file(self.file);
        }
        let (line, column) = self.position(span.start);
        SourceLocation::at(self.file, line, column)
    }

    fn applied(&self, span: &Span) -> Option<&Applied> {
        // They follow one another behind the end of the file.
        let after = |applied: &Applied| applied.span.start <= span.start;
        let index = self.overrides.partition_point(after).checked_sub(1)?;
        let applied = self.overrides.get(index)?;
        (span.start < applied.span.end).then_some(applied)
    }

    /// Line and column in characters, from 1.
    fn position(&self, offset: usize) -> (usize, usize) {
        let mut end = offset.min(self.text.len());
        while !self.text.is_char_boundary(end) {
            end -= 1;
        }
        let line = self.lines.partition_point(|start| *start <= end).max(1);
        let start = self.lines.get(line - 1).copied().unwrap_or(0);
        let before = self.text.get(start..end).unwrap_or_default();
        (line, before.chars().count() + 1)
    }

    /// A broken line breaks what is read from it: those problems go away with it.
    fn is_follow_up(&self, problem: &Problem, broken: &Broken) -> bool {
        if problem.kind == ConfigErrorKind::Syntax || broken.is_empty() {
            return false;
        }
        let Some(span) = &problem.span else {
            return problem.kind == ConfigErrorKind::MissingKey;
        };
        if self.applied(span).is_some() {
            return false;
        }
        if broken.touch(span) || broken.line(self.position(span.start).0) {
            return true;
        }
        let next = self.sections.partition_point(|start| *start <= span.start);
        let end = self.sections.get(next).copied().unwrap_or(usize::MAX);
        problem.kind == ConfigErrorKind::MissingKey && broken.begins_in(span.start..end)
    }

    /// The errors, sorted by position; nothing if there are none.
    pub(super) fn finish(mut self) -> Result<(), ConfigErrors> {
        let syntax = self.problems.iter();
        let syntax = syntax.filter(|problem| problem.kind == ConfigErrorKind::Syntax);
        let broken = Broken::new(
            syntax.filter_map(|problem| problem.span.clone()),
            |offset| self.position(offset).0,
        );
        let mut problems = std::mem::take(&mut self.problems);
        problems.retain(|problem| !self.is_follow_up(problem, &broken));
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
        if self.untold > 0 {
            errors.push(ConfigError {
                kind: ConfigErrorKind::Value,
                place: Some(SourceLocation::file(self.file)),
                subject: String::new(),
                message: format!("{} more errors are not told", self.untold),
            });
        }
        Err(ConfigErrors::new(errors))
    }

    fn error(&self, problem: Problem) -> ConfigError {
        let At { subject, path } = problem.at;
        let mut path = path.as_slice();
        let mut remedy = "";
        let (place, subject) = match &problem.span {
            None => (SourceLocation::file(self.file), subject),
            Some(span) => match self.applied(span) {
                None => (self.place(span), subject),
                Some(applied) => {
                    // The override's own name has the key.
                    if let [Step::Key(key), rest @ ..] = path
                        && *key == applied.key
                    {
                        path = rest;
                    }
                    if problem.kind == ConfigErrorKind::MissingKey {
                        remedy = "; an override gives a table as a whole";
                    }
                    (SourceLocation::file(self.file), applied.subject.clone())
                }
            },
        };
        let message = if path.is_empty() {
            format!("{}{remedy}", problem.message)
        } else {
            format!("{}: {}{remedy}", Path(path), problem.message)
        };
        ConfigError {
            kind: problem.kind,
            place: Some(place),
            subject,
            message,
        }
    }
}
