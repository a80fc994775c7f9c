//! What is left of a table of a file once that is taken out which is wrong with it.
//!
//! Serde stops at the first error. To find the others a caller reads, tells the error, takes out what it points at, and
//! reads the [rest](Rest) again.

use std::{fmt, ops::Range};

use toml::{
    Spanned,
    de::{DeArray, DeTable, DeValue, Error},
};

/// A table, and what was taken out of it.
pub struct Rest<'t> {
    span: Range<usize>,
    written: DeTable<'t>,
    left: DeTable<'t>,
    /// What lost a key or an element, by paths in `written`.
    damaged: Vec<Vec<Step>>,
}

/// A step into a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Step {
    Key(String),
    Index(usize),
}

/// Where in a table: `reference.to[2]`.
pub struct Path<'a>(pub &'a [Step]);

impl fmt::Display for Path<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, step) in self.0.iter().enumerate() {
            match step {
                Step::Key(key) if index == 0 => f.write_str(key)?,
                Step::Key(key) => write!(f, ".{key}")?,
                Step::Index(element) => write!(f, "[{element}]")?,
            }
        }
        Ok(())
    }
}

impl<'t> Rest<'t> {
    /// All of a table that stands at a place; what lost a key already, by its path, is damaged.
    pub fn new(span: Range<usize>, table: DeTable<'t>, damaged: Vec<Vec<Step>>) -> Self {
        Self {
            span,
            written: table.clone(),
            left: table,
            damaged,
        }
    }

    /// What an error is about, counted as the file has it: nothing for the table as a whole. `None` if it is that
    /// something damaged lacks what was taken out of it.
    pub fn path_of(&self, error: &Error) -> Option<Vec<Step>> {
        Some(self.path_in(&self.written, error)).filter(|path| !self.damaged.contains(path))
    }

    /// Takes out what an error points at: the key, or the element of a list. False if that is the table itself.
    pub fn take_out(&mut self, error: &Error) -> bool {
        let written = self.path_in(&self.written, error);
        let here = self.path_in(&self.left, error);
        let Some(depth) = remove(&mut self.left, &here) else {
            return false;
        };
        self.damaged
            .extend(written.get(..depth).map(<[Step]>::to_vec));
        true
    }

    /// What is left.
    pub fn left(&self) -> &DeTable<'t> {
        &self.left
    }

    /// How many values there were, with all that is in them.
    pub fn values(&self) -> usize {
        values(&self.written)
    }

    fn path_in(&self, table: &DeTable<'_>, error: &Error) -> Vec<Step> {
        // What is about the table as a whole is about none of its keys, also of those that have no place of their own.
        let inner = error.span().filter(|span| *span != self.span);
        let path = inner.and_then(|span| locate(table, &span));
        path.unwrap_or_default()
    }
}

fn values(table: &DeTable<'_>) -> usize {
    table.values().map(values_in).sum()
}

fn values_in(value: &Spanned<DeValue<'_>>) -> usize {
    1 + match value.get_ref() {
        DeValue::Table(table) => values(table),
        DeValue::Array(elements) => elements.iter().map(values_in).sum(),
        _ => 0,
    }
}

/// The value at the end of a path; the nearest around it that is there.
pub fn nearest<'a, 't>(table: &'a DeTable<'t>, path: &[Step]) -> Option<&'a Spanned<DeValue<'t>>> {
    let mut steps = path.iter();
    let Some(Step::Key(first)) = steps.next() else {
        return None;
    };
    let mut value = table.get(first.as_str())?;
    loop {
        let inner = match (steps.next(), value.get_ref()) {
            (Some(Step::Key(key)), DeValue::Table(table)) => table.get(key.as_str()),
            (Some(Step::Index(index)), DeValue::Array(elements)) => elements.get(*index),
            _ => None,
        };
        match inner {
            Some(inner) => value = inner,
            None => return Some(value),
        }
    }
}

/// The innermost value, or the key, that contains a span.
pub fn locate(table: &DeTable<'_>, span: &Range<usize>) -> Option<Vec<Step>> {
    table.iter().find_map(|(key, value)| {
        let step = Step::Key(key.get_ref().to_string());
        if contains(&key.span(), span) && !contains(&value.span(), span) {
            return Some(vec![step]);
        }
        locate_in(value, span).map(|mut path| {
            path.insert(0, step);
            path
        })
    })
}

fn locate_in(value: &Spanned<DeValue<'_>>, span: &Range<usize>) -> Option<Vec<Step>> {
    let inner = match value.get_ref() {
        DeValue::Table(table) => locate(table, span),
        DeValue::Array(elements) => elements.iter().enumerate().find_map(|(index, element)| {
            locate_in(element, span).map(|mut path| {
                path.insert(0, Step::Index(index));
                path
            })
        }),
        _ => None,
    };
    inner.or_else(|| contains(&value.span(), span).then(Vec::new))
}

fn contains(outer: &Range<usize>, inner: &Range<usize>) -> bool {
    outer.start <= inner.start && inner.end <= outer.end
}

/// Takes out what a path leads to: an element of a list, else the last key of the path. Gives the number of steps to
/// what lost it.
fn remove(table: &mut DeTable<'_>, path: &[Step]) -> Option<usize> {
    let last = path.iter().rposition(|step| matches!(step, Step::Key(_)))?;
    let (parent, rest) = path.split_at(last);
    let (Step::Key(key), indices) = rest.split_first()? else {
        return None;
    };
    let parent = descend(table, parent)?;
    if let Some((Step::Index(index), lists)) = indices.split_last() {
        let mut list = parent.get_mut(key.as_str())?.get_mut();
        for step in lists {
            let (DeValue::Array(elements), Step::Index(index)) = (list, step) else {
                return None;
            };
            list = elements.get_mut(*index)?.get_mut();
        }
        let DeValue::Array(elements) = list else {
            return None;
        };
        let all = std::mem::replace(elements, DeArray::new());
        let others = all.into_iter().enumerate().filter(|(at, _)| at != index);
        *elements = others.map(|(_, element)| element).collect();
        return Some(path.len() - 1);
    }
    parent.remove(key.as_str())?;
    Some(last)
}

fn descend<'a, 't>(table: &'a mut DeTable<'t>, path: &[Step]) -> Option<&'a mut DeTable<'t>> {
    let Some((first, rest)) = path.split_first() else {
        return Some(table);
    };
    let Step::Key(key) = first else { return None };
    let mut value = table.get_mut(key.as_str())?.get_mut();
    let mut rest = rest;
    while let Some((Step::Index(index), deeper)) = rest.split_first() {
        let DeValue::Array(elements) = value else {
            return None;
        };
        value = elements.get_mut(*index)?.get_mut();
        rest = deeper;
    }
    match value {
        DeValue::Table(inner) => descend(inner, rest),
        _ => None,
    }
}
