//! Entries of a scenario's lists, parsed one by one where they are many: as a table, each takes a hundred times its
//! text.

use std::{borrow::Cow, ops::Range};

use toml::{
    Spanned,
    de::{DeArray, DeTable, DeValue},
};
use wbqp::input::{Enough, Mark, outline};

/// So many entries are parsed one by one.
const MANY: usize = 32;

/// An entry of a list.
pub(super) enum Entry<'t> {
    Read(Spanned<DeValue<'t>>),
    /// Stands in this part of the text, with nothing else.
    Part(Range<usize>),
}

impl<'t> Entry<'t> {
    /// What it says; nothing if it is a part of another text.
    pub(super) fn read(
        &self,
        text: &'t str,
        path: &[&str],
    ) -> Option<Cow<'_, Spanned<DeValue<'t>>>> {
        match self {
            Self::Read(entry) => Some(Cow::Borrowed(entry)),
            Self::Part(part) => parsed(text, part, path).map(Cow::Owned),
        }
    }
}

/// The only entry of the list at a path that a part of the text has; nothing if it has anything else.
pub(super) fn parsed<'t>(
    text: &'t str,
    part: &Range<usize>,
    path: &[&str],
) -> Option<Spanned<DeValue<'t>>> {
    let mut table = DeTable::parse(text.get(part.clone())?).ok()?.into_inner();
    let (list, parents) = path.split_last()?;
    for parent in parents {
        let inner = table.remove(*parent)?.into_inner();
        table = match inner {
            DeValue::Table(inner) if table.is_empty() => inner,
            _ => return None,
        };
    }
    let DeValue::Array(entries) = table.remove(*list)?.into_inner() else {
        return None;
    };
    let mut entries = entries.into_iter();
    match (entries.next(), entries.next()) {
        (Some(entry), None) if table.is_empty() && entry.get_ref().is_table() => {
            Some(moved(entry, part.start))
        }
        _ => None,
    }
}

/// With the places that it has in the whole of which a part was parsed.
fn moved(value: Spanned<DeValue<'_>>, by: usize) -> Spanned<DeValue<'_>> {
    let span = value.span();
    let value = match value.into_inner() {
        DeValue::Table(table) => {
            let mut moved_table = DeTable::new();
            for (key, value) in table {
                let span = key.span();
                let key = Spanned::new(span.start + by..span.end + by, key.into_inner());
                moved_table.insert(key, moved(value, by));
            }
            DeValue::Table(moved_table)
        }
        DeValue::Array(elements) => {
            let mut moved_array = DeArray::new();
            for element in elements {
                moved_array.push(moved(element, by));
            }
            DeValue::Array(moved_array)
        }
        other => other,
    };
    Spanned::new(span.start + by..span.end + by, value)
}

/// Where the entries of lists stand, and the text without them.
pub(super) struct Sections {
    /// As long as the text, with blanks in place of the entries.
    pub(super) rest: String,
    /// Of each list.
    pub(super) parts: Vec<Vec<Range<usize>>>,
}

impl Sections {
    /// Nothing if the entries are few, or if a list or what it is in is written in another way than with headers: then
    /// the whole says what belongs to what.
    pub(super) fn of(text: &str, paths: &[&[&str]]) -> Option<Self> {
        let names: Vec<String> = paths.iter().map(|path| path.join(".")).collect();
        let mut parts = vec![Vec::new(); paths.len()];
        // The list whose entry is being passed, and where it began.
        let mut open: Option<(usize, usize)> = None;
        let mut has_headers = false;
        let is_mixed = outline(text, |start, mark| {
            match mark {
                Mark::Header(header) => {
                    has_headers = true;
                    // The bracket before it belongs to it.
                    let start = start.saturating_sub(1);
                    if let Some((list, _)) = open
                        && names.get(list).is_some_and(|name| is_below(header, name))
                    {
                        return Enough::No;
                    }
                    close(&mut parts, open, start);
                    open = names
                        .iter()
                        .position(|name| name == header)
                        .map(|list| (list, start));
                }
                Mark::Key(key, _) if !has_headers => {
                    let first = key.split('.').next().unwrap_or_default();
                    let first = first.trim().trim_matches(['"', '\'']);
                    if paths.iter().any(|path| path.first() == Some(&first)) {
                        return Enough::Yes;
                    }
                }
                _ => {}
            }
            Enough::No
        });
        close(&mut parts, open, text.len());
        let count: usize = parts.iter().map(Vec::len).sum();
        if is_mixed == Enough::Yes || count < MANY {
            return None;
        }
        let rest = without(text, parts.iter().flatten())?;
        Some(Self { rest, parts })
    }
}

fn is_below(header: &str, list: &str) -> bool {
    let below = header.strip_prefix(list);
    below.is_some_and(|below| below.starts_with('.'))
}

fn close(parts: &mut [Vec<Range<usize>>], open: Option<(usize, usize)>, end: usize) {
    if let Some((list, start)) = open
        && let Some(parts) = parts.get_mut(list)
    {
        parts.push(start..end);
    }
}

fn without<'a>(text: &str, parts: impl Iterator<Item = &'a Range<usize>>) -> Option<String> {
    let mut parts: Vec<&Range<usize>> = parts.collect();
    parts.sort_unstable_by_key(|part| part.start);
    let mut rest = String::with_capacity(text.len());
    for part in parts {
        rest.push_str(text.get(rest.len()..part.start)?);
        rest.extend(std::iter::repeat_n(' ', part.len()));
    }
    rest.push_str(text.get(rest.len()..)?);
    Some(rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PATHS: &[&[&str]] = &[&["event"], &["plant", "wall"], &["case"]];

    /// As it is parsed at once, from the parts.
    fn from_parts(text: &str, sections: &Sections) -> String {
        let mut root = DeTable::parse(&sections.rest).unwrap();
        let mut lists = Vec::new();
        for (path, parts) in PATHS.iter().zip(&sections.parts) {
            let entries = parts.iter().map(|part| parsed(text, part, path).unwrap());
            lists.push(format!("{:?}", entries.collect::<Vec<_>>()));
        }
        for path in PATHS {
            assert!(take(root.get_mut(), path).is_none(), "{path:?}");
        }
        format!("{:?} {lists:?}", root.get_ref())
    }

    fn at_once(text: &str) -> String {
        let mut root = DeTable::parse(text).unwrap();
        let mut lists = Vec::new();
        for path in PATHS {
            let list = take(root.get_mut(), path);
            let Some(DeValue::Array(entries)) = list.map(Spanned::into_inner) else {
                lists.push("[]".to_owned());
                continue;
            };
            lists.push(format!("{:?}", entries.into_iter().collect::<Vec<_>>()));
        }
        format!("{:?} {lists:?}", root.get_ref())
    }

    fn take<'t>(root: &mut DeTable<'t>, path: &[&str]) -> Option<Spanned<DeValue<'t>>> {
        match path {
            [list] => root.remove(*list),
            [parent, rest @ ..] => match root.get_mut(*parent)?.get_mut() {
                DeValue::Table(inner) => take(inner, rest),
                _ => None,
            },
            [] => None,
        }
    }

    /// Entries that stand among other tables, with tables and lists of their own.
    fn scattered() -> String {
        let mut text = "name = \"é\" # [[event]]\nduration = 1.0\n".to_owned();
        for index in 0..MANY {
            text += &format!(
                "[[event]]\nat = {index}.5\r\nmark = \"[[case]]\"\n[event.weight]\n'é {index}' = 2.0\n"
            );
            text += match index % 5 {
                0 => {
                    "  [[plant.wall]]\nname = \"a\"\npoint = [\n[[1.0]]\n]\n[plant.wall.more]\nx = {y = 1}\n"
                }
                1 => {
                    "[[case]] # é\nname = \"\"\"\n[[event]]\n\"\"\"\n[case.change.event.a]\nat = 1.0\n"
                }
                _ => "",
            };
            text += match index {
                7 => "[plant]\nstep = 1e-3\n",
                9 => "[sensors]\n# nothing\n[sensors.noise]\na = 1\n",
                _ => "",
            };
        }
        text
    }

    #[test]
    fn the_parts_are_the_whole_with_every_place() {
        let text = scattered();
        let sections = Sections::of(&text, PATHS).unwrap();
        assert_eq!(sections.rest.len(), text.len());
        assert!(sections.parts.iter().all(|parts| parts.len() > 5));
        assert_eq!(from_parts(&text, &sections), at_once(&text));
    }

    #[test]
    fn few_entries_and_lists_without_headers_are_parsed_at_once() {
        let events = "[[event]]\nat = 0.5\n".repeat(MANY);
        assert!(Sections::of(&events, PATHS).is_some());
        assert!(Sections::of(events.get(10..).unwrap(), PATHS).is_none());
        for first in [
            "event = []",
            "plant.step = 1.0",
            "'plant' = {}",
            " \"case\"= 1",
        ] {
            assert!(
                Sections::of(&format!("{first}\n{events}"), PATHS).is_none(),
                "{first}"
            );
        }
    }

    #[test]
    fn a_part_with_anything_else_is_none() {
        for text in [
            "[event]\nat = 0.5\n",
            "[[event]]\nat = 0.5\n[[event]]\nat = 0.5\n",
            "[[event]]\nat = 0.5\n[other]\n",
            "[[event]]\nat = \n",
            "[[plant.event]]\nat = 0.5\n",
            "",
        ] {
            assert!(
                parsed(text, &(0..text.len()), &["event"]).is_none(),
                "{text}"
            );
        }
        let walls = "[plant]\nstep = 1.0\n[[plant.wall]]\nname = \"a\"\n";
        assert!(parsed(walls, &(0..walls.len()), &["plant", "wall"]).is_none());
        assert!(parsed(walls, &(19..walls.len()), &["plant", "wall"]).is_some());
    }
}
