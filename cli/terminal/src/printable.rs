//! Texts of any origin on a terminal.

use std::borrow::Cow;

/// A text as it is printed: of control characters line breaks and tabs stay, the others, which may come from names of
/// files and would move the cursor or hide what stands before them, are written out, as `\u{1b}`.
pub fn printable(text: &str) -> Cow<'_, str> {
    let is_hidden = |c: char| c.is_control() && c != '\n' && c != '\t';
    if !text.contains(is_hidden) {
        return text.into();
    }
    let mut shown = String::with_capacity(text.len());
    for character in text.chars() {
        if is_hidden(character) {
            shown.extend(character.escape_default());
        } else {
            shown.push(character);
        }
    }
    shown.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_moves_the_cursor_is_written_out() {
        assert_eq!(printable("a\tb\nä"), "a\tb\nä");
        assert_eq!(printable("\u{1b}[2Ja\r\u{9b}"), "\\u{1b}[2Ja\\r\\u{9b}");
    }
}
