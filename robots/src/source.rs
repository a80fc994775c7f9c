//! A text with its name: turns byte offsets into places, and places into errors.

use wbqp::robot::{RobotError, SourceLocation};

/// A file's name and text.
pub(crate) struct Source<'a> {
    pub(crate) file: &'a str,
    pub(crate) text: &'a str,
    /// Byte offset of each line.
    lines: Vec<usize>,
    /// Characters before each block of the text: a file may have all on one line.
    before: Vec<usize>,
}

/// Bytes of a block.
const BLOCK: usize = 1024;

impl<'a> Source<'a> {
    pub(crate) fn new(file: &'a str, text: &'a str) -> Self {
        let ends = text.match_indices('\n').map(|(at, _)| at + 1);
        Self {
            file,
            text,
            lines: std::iter::once(0).chain(ends).collect(),
            before: text
                .as_bytes()
                .chunks(BLOCK)
                .scan(0, |sum, block| {
                    let before = *sum;
                    *sum += characters(block);
                    Some(before)
                })
                .collect(),
        }
    }

    /// How many characters are before a byte offset.
    fn characters_before(&self, offset: usize) -> usize {
        let offset = offset.min(self.text.len());
        let Some(block) = self.before.len().checked_sub(1) else {
            return 0;
        };
        let block = block.min(offset / BLOCK);
        let rest = self.text.as_bytes().get(block * BLOCK..offset);
        self.before.get(block).copied().unwrap_or(0) + rest.map_or(0, characters)
    }

    /// Line and column of a byte offset.
    pub(crate) fn place(&self, offset: usize) -> SourceLocation {
        let line = self.lines.partition_point(|&start| start <= offset).max(1);
        let start = self.lines.get(line - 1).copied().unwrap_or(0);
        let column = self.characters_before(offset) - self.characters_before(start) + 1;
        SourceLocation::at(self.file, line, column)
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

/// Characters that begin in some bytes of a text.
fn characters(bytes: &[u8]) -> usize {
    bytes.iter().filter(|byte| **byte & 0xC0 != 0x80).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_in_characters_also_far_into_a_line() {
        let text = format!("é\n{}x", "aé".repeat(2000));
        let source = Source::new("file", &text);
        assert_eq!(source.place(0).position, Some((1, 1)));
        assert_eq!(source.place(3).position, Some((2, 1)));
        assert_eq!(source.place(text.len() - 1).position, Some((2, 4001)));
        assert_eq!(source.place(text.len() + 9).position, Some((2, 4002)));
        assert_eq!(Source::new("file", "").place(0).position, Some((1, 1)));
    }
}
