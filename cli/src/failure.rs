//! What an error says on a terminal.

use std::path::Path;

use anyhow::{Result, anyhow};

/// The error and its causes, a line each; many messages have that of their cause in them.
pub fn lines(error: &anyhow::Error) -> Vec<String> {
    let text = error.chain().fold(String::new(), |all, cause| {
        let cause = cause.to_string();
        if all.is_empty() {
            cause
        } else if cause.lines().all(|line| all.contains(line)) {
            all
        } else {
            format!("{all}: {cause}")
        }
    });
    text.lines().map(str::to_owned).collect()
}

/// A path that is written into a file, or into a value of one.
///
/// # Errors
/// A path that is no text in UTF-8.
pub(crate) fn utf8(path: &Path) -> Result<&str> {
    path.to_str().ok_or_else(|| {
        anyhow!(
            "{}: the path is not UTF-8, and files name others in UTF-8 alone: rename the file, or its folder",
            path.display()
        )
    })
}
