//! All that is wrong with the keys of a file, where reading it tells the first.

use toml::de::DeTable;
use wbqp::input::Rest;

use super::{ScenarioError, change::Events, file::Cases, text::Text};

/// Mistakes that are told: nobody reads more at once, and for each the file is read once more.
const MOST: usize = 20;

/// Bytes of a file that is read again, at most: all of it together, with its events, takes a hundred times its text.
const LARGEST: usize = 1 << 15;

impl Text<'_> {
    /// What is wrong with a case, of which an error is known.
    pub(super) fn all_wrong(
        &self,
        cases: &Cases<'_>,
        index: usize,
        error: toml::de::Error,
    ) -> ScenarioError {
        let tables = self.is_read_again().then(|| self.tables(cases, index));
        let Some(Ok((mut root, events))) = tables else {
            return self.error(&error);
        };
        let name = cases.name(index).map_or("", |name| name.get_ref().as_str());
        if events == Events::LeftOut {
            cases.members().put_events(&mut root, name);
        }
        self.mistakes(error, cases, root)
    }

    /// The error that reading a table gave, with what else is wrong with keys and values that can be left out.
    pub(super) fn mistakes(
        &self,
        mut error: toml::de::Error,
        cases: &Cases<'_>,
        root: DeTable<'_>,
    ) -> ScenarioError {
        if !self.is_read_again() {
            return self.error(&error);
        }
        let mut rest = Rest::new(cases.span(), root, Vec::new());
        let mut found = Vec::new();
        loop {
            if rest.path_of(&error).is_some() {
                let start = error.span().map_or(0, |span| span.start);
                found.push((start, self.error(&error)));
            }
            if found.len() == MOST || !rest.take_out(&error) {
                break;
            }
            error = match cases.read(rest.left().clone()) {
                Err(next) => next,
                Ok(_) => break,
            };
        }
        found.sort_by_key(|(start, _)| *start);
        ScenarioError::of(found.into_iter().map(|(_, error)| error))
    }

    fn is_read_again(&self) -> bool {
        self.file().len() <= LARGEST
    }
}
