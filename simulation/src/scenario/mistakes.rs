//! All that is wrong with the keys of a file, where reading it tells the first: what is wrong is taken out, and the
//! rest is read again.

use std::ops::Range;

use toml::{
    Spanned,
    de::{DeTable, DeValue},
};

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
        self.mistakes(error, root, |rest| cases.read(rest).err())
    }

    /// The error that reading a table gave, with what else is wrong with keys and values that can be left out.
    pub(super) fn mistakes(
        &self,
        first: toml::de::Error,
        mut root: DeTable<'_>,
        read: impl Fn(DeTable<'_>) -> Option<toml::de::Error>,
    ) -> ScenarioError {
        let mut found = Vec::new();
        let mut next = Some(first);
        while let Some(error) = next {
            let is_taken_out = error.span().is_some_and(|span| take_out(&mut root, &span));
            // A key that is missing may be one that was taken out.
            if found.is_empty() || is_taken_out {
                let start = error.span().map_or(0, |span| span.start);
                found.push((start, self.error(&error)));
            }
            let goes_on = is_taken_out && found.len() < MOST && self.is_read_again();
            next = if goes_on { read(root.clone()) } else { None };
        }
        found.sort_by_key(|(start, _)| *start);
        ScenarioError::of(found.into_iter().map(|(_, error)| error))
    }

    fn is_read_again(&self) -> bool {
        self.file().len() <= LARGEST
    }
}

/// Removes the key, or the key with the value, that stands at a place; false for tables and lists, in which something
/// is missing.
fn take_out(table: &mut DeTable<'_>, span: &Range<usize>) -> bool {
    let is_it = |key: Range<usize>, value: &Spanned<DeValue<'_>>| {
        let is_single = !matches!(value.get_ref(), DeValue::Table(_) | DeValue::Array(_));
        key == *span || (is_single && value.span() == *span)
    };
    let found = table.iter().find(|(key, value)| is_it(key.span(), value));
    if let Some(key) = found.map(|(key, _)| key.get_ref().to_string()) {
        return table.remove(key.as_str()).is_some();
    }
    table.iter_mut().any(|(_, value)| match value.get_mut() {
        DeValue::Table(inner) => take_out(inner, span),
        DeValue::Array(elements) => elements.iter_mut().any(|element| match element.get_mut() {
            DeValue::Table(inner) => take_out(inner, span),
            _ => false,
        }),
        _ => false,
    })
}
