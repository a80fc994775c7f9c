//! What scenarios and cases may be called.

use std::collections::HashSet;

use toml::Spanned;

use super::{ScenarioError, text::Text};

/// Of what names of files and folders are made.
fn is_plain(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_' || c == '-'
}

/// Whether a name can be that of a folder in the one that it is made in, on every machine.
pub fn is_name(name: &str) -> bool {
    !name.is_empty()
        && !name.starts_with('.')
        && !name.ends_with('.')
        && name.chars().all(|c| is_plain(c) || c == '.')
}

/// A scenario's name becomes the name of a folder, which must be in the one that runs are written to.
pub(super) fn check_scenario(text: &Text<'_>, name: &Spanned<String>) -> Result<(), ScenarioError> {
    if is_name(name.get_ref()) {
        return Ok(());
    }
    Err(ScenarioError::Value {
        place: text.place(name.span().start),
        what: format!(
            "name `{}` must be made of letters, digits, `_`, `-` and, inside, `.`: it names the folder of its runs",
            name.get_ref()
        ),
    })
}

/// A case's name is called by entries of the file, and becomes the name of a log file.
pub(super) fn check_cases<'n>(
    text: &Text<'_>,
    names: impl Iterator<Item = &'n Spanned<String>>,
) -> Result<(), ScenarioError> {
    let mut known = HashSet::new();
    for (i, spanned) in names.enumerate() {
        let name = spanned.get_ref().as_str();
        let refuse = |what: String| ScenarioError::Value {
            place: text.place(spanned.span().start),
            what: format!("case[{i}]: {what}"),
        };
        if !known.insert(name) {
            return Err(refuse(format!("the name `{name}` is used twice")));
        }
        if name.is_empty() || !name.chars().all(is_plain) {
            return Err(refuse(format!(
                "name `{name}` must be made of letters, digits, `_` and `-`"
            )));
        }
    }
    Ok(())
}
