//! Names that are taken once.

use std::collections::HashSet;

#[derive(Debug, Default)]
pub(crate) struct Names(HashSet<String>);

impl Names {
    /// The name, or with a number behind it if it is taken.
    pub(crate) fn take(&mut self, wanted: &str) -> String {
        let numbered = (2..).map(|n| format!("{wanted}_{n}"));
        let mut candidates = std::iter::once(wanted.to_owned()).chain(numbered);
        loop {
            // There is always another number.
            let name = candidates.next().unwrap_or_default();
            if self.0.insert(name.clone()) {
                return name;
            }
        }
    }
}
