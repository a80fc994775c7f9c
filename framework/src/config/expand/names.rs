//! One table for several frames, and names that follow from what an entry is.
//!
//! | of | name |
//! |---|---|
//! | a contact | its `frame` |
//! | a task or constraint with a `frame` | `<frame>_<type>` |
//! | one with a `contact` | `<contact>_<type>` |
//! | any other | `<type>` |

use toml::{Spanned, de::DeValue};

use super::{List, Notes, value};
use crate::config::{
    ConfigErrorKind as Kind,
    document::Document,
    entry,
    report::{At, Report, Step},
    table::Section,
};

/// Makes a contact of each of the `frames` of a table.
pub(super) fn split_frames(document: &mut Document<'_>, report: &mut Report<'_>) {
    let sections = std::mem::take(&mut document.contacts);
    for mut section in sections {
        let at = At::subject(entry::subject(
            "contact",
            Some(document.contacts.len()),
            &section,
        ));
        let Some(frames) = section.take("frames") else {
            document.contacts.push(section);
            continue;
        };
        let frames_at = at.key("frames");
        let span = frames.span();
        for (key, problem) in [
            ("frame", "there is `frames` as well; leave one of them out"),
            (
                "name",
                "each contact of `frames` is called by its frame; leave it out",
            ),
        ] {
            if let Some(other) = section.take(key) {
                report.add(Kind::Value, Some(other.span()), &at.key(key), problem);
            }
        }
        let DeValue::Array(frames) = frames.into_inner() else {
            report.add(
                Kind::Value,
                Some(span),
                &frames_at,
                "must be a list of frames by name",
            );
            continue;
        };
        if frames.is_empty() {
            report.add(
                Kind::Value,
                Some(span),
                &frames_at,
                "must name at least one frame",
            );
        }
        for (index, frame) in frames.into_iter().enumerate() {
            if !frame.get_ref().is_str() {
                let at = frames_at.then(&[Step::Index(index)]);
                let message = "must be the name of a frame";
                report.add(Kind::Value, Some(frame.span()), &at, message);
                continue;
            }
            let mut one = section.clone();
            value::put(&mut one, "frame", frame);
            document.contacts.push(one);
        }
    }
}

/// Names what has no name.
pub(in crate::config) fn fill(document: &mut Document<'_>, notes: &mut Notes) {
    for (index, section) in document.contacts.iter_mut().enumerate() {
        if section.keys.contains_key("name") {
            continue;
        }
        let Some(frame) = section.keys.get("frame") else {
            continue;
        };
        let (span, Some(name)) = (frame.span(), frame.get_ref().as_str()) else {
            continue;
        };
        let name = name.to_owned();
        value::put(section, "name", value::text(name, &span));
        notes.add(List::Contact, index, "name", "its frame");
    }
    for (list, sections) in [
        (List::Task, &mut document.tasks),
        (List::Constraint, &mut document.constraints),
    ] {
        for (index, section) in sections.iter_mut().enumerate() {
            if section.keys.contains_key("name") {
                continue;
            }
            let Some(tag) = value::string(section, "type") else {
                continue;
            };
            let of = ["frame", "contact"]
                .into_iter()
                .find_map(|key| value::string(section, key).map(|name| (key, name)));
            let (name, why) = match of {
                Some((key, whose)) => (derived(whose, tag), format!("its {key} and type")),
                None => (tag.to_owned(), "its type".to_owned()),
            };
            let span = section.span.clone();
            value::put(section, "name", value::text(name, &span));
            notes.add(list, index, "name", why);
        }
    }
}

/// The name of an entry of this type that belongs to a frame or a contact.
pub(super) fn derived(whose: &str, tag: &str) -> String {
    format!("{whose}_{tag}")
}

/// What to do about a name that is taken, if the file does not say the name.
pub(in crate::config) fn remedy(section: &Section<'_>) -> &'static str {
    let place = |key: &str| section.keys.get(key).map(Spanned::span);
    let is_implied = |name: super::Span| {
        name == section.span || place("frame").is_some_and(|frame| frame == name)
    };
    match place("name") {
        Some(name) if is_implied(name.clone()) => "; give one of them a `name`",
        _ => "",
    }
}
