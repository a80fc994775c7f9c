//! What a case takes from the scenario's file: entries that are not for it left out, its changes put in.
//!
//! Works on the parsed text, so that whatever is wrong afterwards still has its place in the file.

use std::{
    borrow::Cow,
    collections::{HashMap, HashSet},
    ops::Range,
};

use toml::{
    Spanned,
    de::{DeArray, DeString, DeTable, DeValue},
};
use wbqp::suggestion::suggestion;

use super::parts::Entry;

/// A list of the file, the key by which changes name its entries, and the name of one without that key.
pub(super) struct List {
    pub(super) path: &'static [&'static str],
    key: &'static str,
    default: Option<&'static str>,
}

pub(super) const LISTS: [List; 7] = [
    list(&["event"], "mark"),
    list(&["detector"], "contact"),
    list(&["plant", "wall"], "name"),
    list(&["plant", "contact_point"], "frame"),
    DISTURBANCES,
    list(&["sensors", "force_torque"], "frame"),
    list(&["sensors", "outage"], "sensor"),
];

pub(super) const DISTURBANCES: List = List {
    path: &["plant", "disturbance"],
    key: "name",
    default: Some(crate::plant::DISTURBANCE),
};

/// The place of `[[event]]` among them.
const EVENTS: usize = 0;

const fn list(path: &'static [&'static str], key: &'static str) -> List {
    List {
        path,
        key,
        default: None,
    }
}

/// Keys of the file that are the same in every case.
const FIXED: [&str; 2] = ["name", "case"];

impl List {
    pub(super) fn name_of<'a>(&self, entry: &'a DeValue<'_>) -> Option<&'a str> {
        let given = entry.as_table()?.get(self.key);
        given.map_or(self.default, |name| name.get_ref().as_str())
    }

    fn display(&self) -> String {
        format!("[[{}]]", self.path.join("."))
    }
}

/// What is wrong, and where in the text.
#[derive(Debug)]
pub(super) struct Refusal {
    pub(super) span: Range<usize>,
    pub(super) message: String,
}

/// The entries of the lists, taken out of the file, and which of them are for which cases: read once for all cases.
pub(super) struct Members<'t> {
    text: &'t str,
    /// Nothing for a list that the file does not have.
    lists: Vec<Option<Entries<'t>>>,
}

struct Entries<'t> {
    all: Vec<Entry<'t>>,
    /// Indices of those without `cases`.
    of_every_case: Vec<usize>,
    /// Indices of the others, by case.
    of_case: HashMap<String, Vec<usize>>,
}

impl<'t> Members<'t> {
    /// Takes the entries out of the tables, and notes those that stand in parts of the text of their own: a list has
    /// the one kind or the other.
    pub(super) fn take(
        text: &'t str,
        root: &mut DeTable<'t>,
        parts: &[Vec<Range<usize>>],
        known: &[&str],
    ) -> Result<Self, Refusal> {
        let names: HashSet<&str> = known.iter().copied().collect();
        let mut lists = Vec::new();
        for (index, list) in LISTS.iter().enumerate() {
            let parts = parts.get(index).map_or(&[][..], Vec::as_slice);
            if let Some(span) = table_at(root, list.path) {
                let (path, header) = (list.path.join("."), list.display());
                let message = format!(
                    "`{path}` is a list, also of one: write `{header}`, with two brackets on each side"
                );
                return Err(Refusal { span, message });
            }
            let mut all = match descend(root, list.path) {
                Some(DeValue::Array(entries)) => {
                    let entries = std::mem::replace(entries, DeArray::new());
                    entries.into_iter().map(Entry::Read).collect()
                }
                _ if parts.is_empty() => {
                    lists.push(None);
                    continue;
                }
                _ => Vec::with_capacity(parts.len()),
            };
            all.extend(parts.iter().cloned().map(Entry::Part));
            let mut entries = Entries {
                all,
                of_every_case: Vec::new(),
                of_case: HashMap::new(),
            };
            for (index, entry) in entries.all.iter_mut().enumerate() {
                let cases = match entry {
                    Entry::Read(entry) => cases_of(entry, &names, known)?,
                    Entry::Part(_) => match entry.read(text, list.path) {
                        Some(mut entry) => cases_of(entry.to_mut(), &names, known)?,
                        None => None,
                    },
                };
                match cases {
                    None => entries.of_every_case.push(index),
                    Some(cases) => {
                        for case in cases {
                            entries.of_case.entry(case).or_default().push(index);
                        }
                    }
                }
            }
            lists.push(Some(entries));
        }
        Ok(Self { text, lists })
    }

    /// Of each list the indices of the entries that a case has and others may not have.
    pub(super) fn own(&self, case: &str) -> Vec<&[usize]> {
        let lists = 0..self.lists.len();
        lists.map(|list| self.own_of(list, case)).collect()
    }

    /// The same of the events.
    pub(super) fn own_events(&self, case: &str) -> &[usize] {
        self.own_of(EVENTS, case)
    }

    fn own_of(&self, list: usize, case: &str) -> &[usize] {
        let entries = self.lists.get(list).and_then(Option::as_ref);
        let own = entries.and_then(|entries| entries.of_case.get(case));
        own.map_or(&[][..], Vec::as_slice)
    }

    /// The indices of the entries of a list that a case has, in the file's order.
    fn indices(&self, list: usize, case: &str) -> Vec<usize> {
        let Some(Some(entries)) = self.lists.get(list) else {
            return Vec::new();
        };
        let own = self.own_of(list, case);
        let mut indices: Vec<usize> = entries.of_every_case.iter().chain(own).copied().collect();
        indices.sort_unstable();
        indices
    }

    /// All entries of a list, whichever cases have them.
    pub(super) fn entries(
        &self,
        list: &List,
    ) -> impl Iterator<Item = Cow<'_, Spanned<DeValue<'t>>>> {
        let path = list.path;
        let index = LISTS.iter().position(|other| other.path == path);
        let entries = index.and_then(|index| self.lists.get(index)?.as_ref());
        let all = entries.into_iter().flat_map(|entries| &entries.all);
        all.filter_map(move |entry| entry.read(self.text, path))
    }

    /// The entry of a list, without its cases.
    fn entry(&self, list: usize, index: usize) -> Option<Spanned<DeValue<'t>>> {
        let path = LISTS.get(list)?.path;
        let entries = self.lists.get(list)?.as_ref()?;
        let mut entry = entries.all.get(index)?.read(self.text, path)?.into_owned();
        if let DeValue::Table(keys) = entry.get_mut() {
            keys.remove("cases");
        }
        Some(entry)
    }

    /// The events of a case, read one by one.
    pub(super) fn events(
        &self,
        case: &str,
    ) -> impl ExactSizeIterator<Item = Option<Spanned<DeValue<'t>>>> {
        let indices = self.indices(EVENTS, case).into_iter();
        indices.map(|index| self.entry(EVENTS, index))
    }

    /// Puts the entries that are for a case where those of all cases were; of events only if they are asked for.
    pub(super) fn put(&self, root: &mut DeTable<'t>, case: &str, events: Events) {
        for list in 0..LISTS.len() {
            if list != EVENTS || events == Events::Put {
                self.put_list(root, case, list);
            }
        }
    }

    /// Puts the events of a case.
    pub(super) fn put_events(&self, root: &mut DeTable<'t>, case: &str) {
        self.put_list(root, case, EVENTS);
    }

    fn put_list(&self, root: &mut DeTable<'t>, case: &str, list: usize) {
        let (Some(List { path, .. }), Some(Some(_))) = (LISTS.get(list), self.lists.get(list))
        else {
            return;
        };
        let Some(DeValue::Array(put)) = descend_or_make(root, path) else {
            return;
        };
        let indices = self.indices(list, case).into_iter();
        for entry in indices.filter_map(|index| self.entry(list, index)) {
            put.push(entry);
        }
    }

    /// Whether there is an entry of that name that is not for a case.
    fn leave_out(&self, case: &str, list: &List, name: &str) -> bool {
        let index = LISTS.iter().position(|other| other.path == list.path);
        let Some((index, Some(Some(entries)))) = index.map(|index| (index, self.lists.get(index)))
        else {
            return false;
        };
        let its = self.indices(index, case);
        let mut others = (0..entries.all.len()).filter(|index| its.binary_search(index).is_err());
        others.any(|other| {
            let entry = entries.all.get(other);
            let entry = entry.and_then(|entry| entry.read(self.text, list.path));
            entry.is_some_and(|entry| list.name_of(entry.get_ref()) == Some(name))
        })
    }
}

/// Whether the tables of a case have its events, each of which takes a hundred times its text.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Events {
    Put,
    LeftOut,
}

/// The cases of an entry; nothing if it is in all of them. Takes out its `cases`.
fn cases_of(
    entry: &mut Spanned<DeValue<'_>>,
    names: &HashSet<&str>,
    known: &[&str],
) -> Result<Option<HashSet<String>>, Refusal> {
    let DeValue::Table(keys) = entry.get_mut() else {
        return Ok(None);
    };
    let Some(cases) = keys.remove("cases") else {
        return Ok(None);
    };
    let refuse = |span, message| Err(Refusal { span, message });
    let DeValue::Array(listed) = cases.get_ref() else {
        let found = cases.get_ref().type_str();
        let message = format!("`cases` must be a list of cases' names, found {found}");
        return refuse(cases.span(), message);
    };
    if listed.is_empty() {
        let message = "`cases` is empty: this would be in no case".to_owned();
        return refuse(cases.span(), message);
    }
    let mut found = HashSet::new();
    for name in listed {
        match name.get_ref().as_str() {
            Some(name) if names.contains(name) => {
                found.insert(name.to_owned());
            }
            Some(other) => {
                let message = format!("there is no case `{other}`{}", suggestion(other, known));
                return refuse(name.span(), message);
            }
            None => {
                let found = name.get_ref().type_str();
                let message = format!("`cases` must be a list of cases' names, found {found}");
                return refuse(name.span(), message);
            }
        }
    }
    Ok(Some(found))
}

fn descend<'a, 't>(table: &'a mut DeTable<'t>, path: &[&str]) -> Option<&'a mut DeValue<'t>> {
    let (first, rest) = path.split_first()?;
    let value = table.get_mut(*first)?.get_mut();
    match (rest.is_empty(), value) {
        (true, value) => Some(value),
        (false, DeValue::Table(inner)) => descend(inner, rest),
        _ => None,
    }
}

/// Where the key at a path is, if its value is a table.
fn table_at(table: &DeTable<'_>, path: &[&str]) -> Option<Range<usize>> {
    let (first, rest) = path.split_first()?;
    let (key, value) = table.get_key_value(*first)?;
    let inner = value.get_ref().as_table()?;
    if rest.is_empty() {
        Some(key.span())
    } else {
        table_at(inner, rest)
    }
}

/// The same; what is not there is made.
fn descend_or_make<'a, 't>(
    table: &'a mut DeTable<'t>,
    path: &[&'static str],
) -> Option<&'a mut DeValue<'t>> {
    let (first, rest) = path.split_first()?;
    let made = match rest {
        [] => DeValue::Array(DeArray::new()),
        _ => DeValue::Table(DeTable::new()),
    };
    let key = Spanned::new(0..0, DeString::Borrowed(first));
    let entry = table.entry(key).or_insert(Spanned::new(0..0, made));
    match (rest, entry.get_mut()) {
        ([], value) => Some(value),
        (_, DeValue::Table(inner)) => descend_or_make(inner, rest),
        _ => None,
    }
}

/// Whose changes they are.
#[derive(Clone, Copy)]
pub(super) enum Whose<'a> {
    /// The case's own: every entry that they name must be there.
    Case,
    /// A variation's, which is the same for all cases: an entry that this case leaves out is none of its business.
    Variation {
        members: &'a Members<'a>,
        case: &'a str,
    },
}

/// Puts changes into the file.
pub(super) fn apply<'t>(
    root: &mut DeTable<'t>,
    changes: &DeTable<'t>,
    whose: Whose<'_>,
) -> Result<(), Refusal> {
    for (key, _) in changes {
        if FIXED.contains(&&**key.get_ref()) {
            return Err(Refusal {
                span: key.span(),
                message: format!("`{}` is the same in every case", key.get_ref()),
            });
        }
    }
    merge(root, changes, whose, &mut Vec::new())
}

fn merge<'t>(
    table: &mut DeTable<'t>,
    changes: &DeTable<'t>,
    whose: Whose<'_>,
    path: &mut Vec<String>,
) -> Result<(), Refusal> {
    for (key, change) in changes {
        path.push(key.get_ref().to_string());
        let list = LISTS.iter().find(|list| list.path == path.as_slice());
        match change.get_ref() {
            DeValue::Table(changes) if list.is_some() || !changes.contains_key("type") => {
                let old = table
                    .entry(key.clone())
                    .or_insert_with(|| Spanned::new(change.span(), nothing(list)));
                match (old.get_mut(), list) {
                    (DeValue::Table(old), None) => merge(old, changes, whose, path)?,
                    (DeValue::Array(entries), Some(list)) => {
                        merge_entries(entries, changes, list, whose, path)?;
                    }
                    (other, _) => *other = change.get_ref().clone(),
                }
            }
            // Lists and numbers, and references: what has a `type` is replaced as a whole.
            _ => {
                table.insert(key.clone(), change.clone());
            }
        }
        path.pop();
    }
    Ok(())
}

fn nothing<'t>(list: Option<&List>) -> DeValue<'t> {
    match list {
        Some(_) => DeValue::Array(DeArray::new()),
        None => DeValue::Table(DeTable::new()),
    }
}

fn merge_entries<'t>(
    entries: &mut DeArray<'t>,
    changes: &DeTable<'t>,
    list: &List,
    whose: Whose<'_>,
    path: &mut Vec<String>,
) -> Result<(), Refusal> {
    for (name, change) in changes {
        let is_named =
            |entry: &Spanned<DeValue<'_>>| list.name_of(entry.get_ref()) == Some(&**name.get_ref());
        let refuse = |what: String| Refusal {
            span: name.span(),
            message: format!("{} {what}", list.display()),
        };
        let mut found = entries.iter_mut().filter(|entry| is_named(entry));
        let (entry, other) = (found.next(), found.next());
        if other.is_some() {
            let what = format!("with {} `{}` is there twice", list.key, name.get_ref());
            return Err(refuse(what));
        }
        let Some(entry) = entry else {
            if let Whose::Variation { members, case } = whose
                && members.leave_out(case, list, name.get_ref())
            {
                continue;
            }
            let names = entries
                .iter()
                .filter_map(|entry| list.name_of(entry.get_ref()));
            let known: Vec<&str> = names.collect();
            let hint = suggestion(name.get_ref(), &known);
            let what = format!("with {} `{}` is not there{hint}", list.key, name.get_ref());
            return Err(refuse(what));
        };
        let (DeValue::Table(keys), DeValue::Table(changes)) = (entry.get_mut(), change.get_ref())
        else {
            return Err(Refusal {
                span: change.span(),
                message: format!(
                    "must be a table of values, found {}",
                    change.get_ref().type_str()
                ),
            });
        };
        path.push(name.get_ref().to_string());
        merge(keys, changes, whose, path)?;
        path.pop();
    }
    Ok(())
}
