//! A text with its name: turns byte offsets into places, and places into errors.

use wbqp::robot::{RobotError, SourceLocation};

/// A file's name and text.
pub(crate) struct Source<'a> {
    pub(crate) file: &'a str,
    pub(crate) text: &'a str,
    /// Byte offset of each line.
    lines: Vec<usize>,
}

impl<'a> Source<'a> {
    pub(crate) fn new(file: &'a str, text: &'a str) -> Self {
        let ends = text.match_indices('\n').map(|(at, _)| at + 1);
        Self {
            file,
            text,
            lines: std::iter::once(0).chain(ends).collect(),
        }
    }

    /// Line and column of a byte offset.
    pub(crate) fn place(&self, offset: usize) -> SourceLocation {
        let line = self.lines.partition_point(|&start| start <= offset).max(1);
        let start = self.lines.get(line - 1).copied().unwrap_or(0);
        let before = self.text.get(start..offset).unwrap_or_default();
        SourceLocation::at(self.file, line, before.chars().count() + 1)
    }

    /// The error for an element that cannot be used.
    pub(crate) fn error(
        &self,
        offset: usize,
        element: &str,
        what: impl Into<String>,
    ) -> RobotError {
        RobotError::Element {
            place: self.place(offset),
            element: element.to_owned(),
            what: what.into(),
        }
    }

    /// Refuses an element.
    pub(crate) fn refuse<T>(
        &self,
        offset: usize,
        element: &str,
        what: impl Into<String>,
    ) -> Result<T, RobotError> {
        Err(self.error(offset, element, what))
    }
}
