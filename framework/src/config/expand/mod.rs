//! Short forms, written out before anything is deserialised.
//!
//! A file may say less than a controller needs. What it leaves out is put into its tables here, in the steps of
//! [`read`]; everything after sees the long form, as if the file had said it. What is put in has the place of what
//! brought it, so that errors have a line, and a name, so that overrides find it.

mod contact;
mod defaults;
mod implied;
mod long;
mod names;
mod robot;
pub(crate) mod schema;
pub(super) mod value;

use std::cell::OnceCell;

use super::{
    Overrides,
    document::Document,
    overrides::OverrideText,
    report::{Report, Span},
};

pub(super) use contact::{Listed, write_out as write_out_contacts};
pub(super) use defaults::fill as fill_defaults;
pub use long::expand;
pub(super) use names::{fill as fill_names, remedy};

/// Texts of values that no file has, for as long as the document.
#[derive(Debug, Default)]
pub(super) struct Texts {
    contacts: OnceCell<Vec<String>>,
    defaults: OnceCell<Vec<String>>,
}

/// What kind of text is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reading {
    /// Somebody wrote it, and need not say what goes without saying.
    File,
    /// A controller was written out as it was: nothing else belongs to it.
    Record,
}

/// What was put into a document, and why.
#[derive(Debug, Default)]
pub(super) struct Notes(Vec<Note>);

/// A value that was put into a table.
#[derive(Debug)]
struct Note {
    list: List,
    /// Among its kind.
    index: usize,
    key: String,
    why: String,
}

/// A kind of table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum List {
    Robot,
    Contact,
    Task,
    Constraint,
}

impl Notes {
    fn add(&mut self, list: List, index: usize, key: impl Into<String>, why: impl Into<String>) {
        self.0.push(Note {
            list,
            index,
            key: key.into(),
            why: why.into(),
        });
    }

    /// By table, in the order in which they came: so that those of a table are found.
    fn sort(&mut self) {
        self.0.sort_by_key(Note::table);
    }

    /// Those of a table, after they are sorted.
    fn of(&self, list: List, index: usize) -> impl Iterator<Item = &Note> {
        let first = self.0.partition_point(|note| note.table() < (list, index));
        let rest = self.0.iter().skip(first);
        rest.take_while(move |note| note.table() == (list, index))
    }
}

impl Note {
    fn table(&self) -> (List, usize) {
        (self.list, self.index)
    }
}

/// Parses a file and writes it out, with the overrides in it: those that name an entry that the file lists before short
/// contacts are written out, so that they count for what a contact brings, those that name what it brings after that.
pub(super) fn read<'t>(
    source: &'t str,
    reading: Reading,
    overrides: &Overrides,
    appendix: &'t OverrideText,
    texts: &'t Texts,
    report: &mut Report<'_>,
) -> (Document<'t>, Notes) {
    let mut notes = Notes::default();
    let mut document = Document::parse(source, report);
    robot::fill_type(&mut document, &mut notes, report);
    names::split_frames(&mut document, report);
    names::fill(&mut document, &mut notes);
    let rest = appendix.apply(overrides, &mut document, report);
    let listed = Listed::of(&document);
    contact::write_out(&mut document, reading, &listed, texts, &mut notes, report);
    OverrideText::apply_rest(rest, overrides, &mut document, report);
    defaults::fill(&mut document, texts, &mut notes);
    notes.sort();
    (document, notes)
}

/// A key that stands nowhere gets the place of what brought it.
fn key_at(span: &Span) -> Span {
    span.start..span.start
}
