//! Texts that come from files, on one line of a message.

/// What a name with control characters is refused for.
pub(crate) const CONTROL: &str = "has control characters, such as line breaks: leave them out";

/// A text with its control characters written out, `\n` or `\u{1b}`: on a terminal they would move the cursor, or hide
/// what stands before them.
pub(crate) fn one_line(text: &str) -> String {
    let mut line = String::with_capacity(text.len());
    for character in text.chars() {
        if character.is_control() {
            line.extend(character.escape_default());
        } else {
            line.push(character);
        }
    }
    line
}
