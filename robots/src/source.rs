//! A text with its name: turns byte offsets into places, and places into errors.

use wbqp::robot::{Place, RobotError};

/// A file's name and text.
#[derive(Clone, Copy)]
pub(crate) struct Source<'a> {
    pub(crate) file: &'a str,
    pub(crate) text: &'a str,
}

impl Source<'_> {
    /// Line and column of a byte offset.
    pub(crate) fn place(&self, offset: usize) -> Place {
        let before = self.text.get(..offset).unwrap_or(self.text);
        let line = before.matches('\n').count() + 1;
        let column = before.chars().rev().take_while(|&c| c != '\n').count() + 1;
        Place::at(self.file, line, column)
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
