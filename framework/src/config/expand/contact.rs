//! A contact with `motion` brings its constraints.
//!
//! | `motion` | of the contact's motion |
//! |---|---|
//! | `"hard"` | a `contact_motion` that holds |
//! | `"soft"` | a `contact_motion` with that type's default weight |
//! | `"free"` | nothing: it may slide |
//!
//! Its cone is a `friction_pyramid` if it is of kind `point`, and a `contact_wrench` if it has a sole. What the file
//! lists itself, an entry of the same type for the same contact, is not brought a second time.
//!
//! The limits of the actuators go without saying, whether there are contacts or not: they are written out here too.

use std::collections::HashSet;

use serde::{
    Deserialize,
    de::value::{Error, StrDeserializer},
};
use toml::{Spanned, de::DeValue};

use super::{List, Notes, Reading, Span, Texts, names, value};
use crate::{
    config::{
        ConfigErrorKind as Kind,
        document::Document,
        entry,
        report::{At, Report},
        table::Section,
    },
    contact::{ContactKind, Motion},
    plugin::AnyConstraint,
    registry,
    suggestion::{did_you_mean, suggestion},
};

/// What limits the efforts of all actuators.
const LIMITS: &str = "actuator_limits";
const MOTION: &str = "contact_motion";
const PYRAMID: &str = "friction_pyramid";
const WRENCH: &str = "contact_wrench";

/// The ground.
const UPWARD: &str = "{ normal = [0.0, 0.0, 1.0], x_axis = [1.0, 0.0, 0.0] }";
const UP: &str = "[0.0, 0.0, 1.0]";
const ALONG_X: &str = "[1.0, 0.0, 0.0]";
/// Largest normal force of a contact that does not say it, N: a tonne on one foot, which no robot here puts there. A
/// smaller one would be a limit for somebody's robot.
const FORCE_MAX: &str = "1e4";

/// What a configuration lists itself.
#[derive(Debug, Default)]
pub(in crate::config) struct Listed {
    /// Types of constraints with the contact that they are for; without one, the empty string.
    pub(in crate::config) constraints: HashSet<(String, String)>,
    /// Names of tasks and constraints.
    pub(in crate::config) names: HashSet<String>,
}

impl Listed {
    pub(super) fn of(document: &Document<'_>) -> Self {
        let text =
            |section: &Section<'_>, key| value::string(section, key).unwrap_or_default().to_owned();
        let constraints = document.constraints.iter();
        let entries = document.tasks.iter().chain(&document.constraints);
        Self {
            constraints: constraints
                .map(|section| (text(section, "type"), text(section, "contact")))
                .collect(),
            names: entries.map(|section| text(section, "name")).collect(),
        }
    }

    fn has(&self, tag: &str, contact: &str) -> bool {
        if contact.is_empty() {
            // Asked once of a file.
            return self.constraints.iter().any(|(t, _)| t == tag);
        }
        let asked = (tag.to_owned(), contact.to_owned());
        self.constraints.contains(&asked)
    }
}

/// What a contact brings.
struct Brought {
    tag: &'static str,
    contact: String,
    span: Span,
    /// Half lengths of a sole.
    half: Option<[f64; 2]>,
    motion: Motion,
}

/// Writes out all contacts with `motion`, and the limits of the actuators, which go without saying.
pub(in crate::config) fn write_out<'t>(
    document: &mut Document<'t>,
    reading: Reading,
    listed: &Listed,
    texts: &'t Texts,
    notes: &mut Notes,
    report: &mut Report<'_>,
) {
    let mut brought = Vec::new();
    let mut asked = None;
    for (index, section) in document.contacts.iter_mut().enumerate() {
        ask_for_motion(index, section, &mut asked, report);
        if contact(index, section, &mut brought, notes, report) {
            document.is_short = true;
        }
    }
    // A file in long form may be for a program that links no constraints.
    let is_linked = registry::find::<dyn AnyConstraint>(LIMITS).is_some();
    if document.is_short || reading == Reading::File && is_linked {
        let robot = document.robot.as_ref().map(|robot| robot.span.clone());
        let contact = || {
            document
                .contacts
                .first()
                .map(|contact| contact.span.clone())
        };
        let limits = Brought {
            tag: LIMITS,
            contact: String::new(),
            span: robot.or_else(contact).unwrap_or_default(),
            half: None,
            motion: Motion::Hard,
        };
        brought.insert(0, limits);
    }
    brought.retain(|one| !listed.has(one.tag, &one.contact));
    brought.retain(|one| is_possible(one, listed, report));
    let lengths = brought
        .iter()
        .flat_map(|one| one.half.into_iter().flatten());
    let lengths = lengths.map(|length| format!("{length:?}")).collect();
    let mut lengths = texts.contacts.get_or_init(|| lengths).iter();
    for one in brought {
        let index = document.constraints.len();
        let span = &one.span;
        let mut section = Section::new(span.clone());
        let name = one.name();
        let mut put = |key, value| value::put(&mut section, key, value);
        put("name", value::text(name, span));
        put("type", value::text(one.tag, span));
        let why = if one.contact.is_empty() {
            "no robot exceeds its limits".to_owned()
        } else {
            format!("contact `{}` brings it", one.contact)
        };
        if !one.contact.is_empty() {
            put("contact", value::text(one.contact, span));
        }
        if one.motion == Motion::Soft {
            put("hardness", value::text("soft", span));
        }
        if one.half.is_some() {
            for key in ["half_length_x", "half_length_y"] {
                let length = lengths.next().and_then(|text| value::parsed(text, span));
                if let Some(length) = length {
                    put(key, length);
                }
                notes.add(List::Constraint, index, key, "half of the contact's `size`");
            }
        }
        notes.add(List::Constraint, index, "name", "its contact and type");
        notes.add(List::Constraint, index, "type", why);
        document.constraints.push(section);
    }
}

impl Brought {
    fn name(&self) -> String {
        if self.contact.is_empty() {
            self.tag.to_owned()
        } else {
            names::derived(&self.contact, self.tag)
        }
    }
}

/// Whether an entry can be added: its type is linked, its name is free.
fn is_possible(one: &Brought, listed: &Listed, report: &mut Report<'_>) -> bool {
    let name = one.name();
    let (subject, who) = if one.contact.is_empty() {
        ("robot".to_owned(), "a short file")
    } else {
        (format!("contact `{}`", one.contact), "`motion`")
    };
    let at = At::subject(subject);
    let tag = one.tag;
    let (kind, message) = if registry::find::<dyn AnyConstraint>(tag).is_none() {
        let message = format!(
            "{who} brings a constraint of type `{tag}`, which is not linked: add `use wbqp_tasks as _;` \
             (crate wbqp-tasks)"
        );
        (Kind::UnknownType, message)
    } else if listed.names.contains(&name) {
        let message = format!(
            "{who} brings a constraint that is called `{name}`, and another entry has that name: give that one another \
             `name`"
        );
        (Kind::Duplicate, message)
    } else {
        return true;
    };
    report.add(kind, Some(one.span.clone()), &at, message);
    false
}

/// A contact in neither form, of which no key is a slip of one of theirs, is asked for the shorter one, and taken to
/// have it: the file is refused, and what it brings is not missing besides. Of contacts that one table made, the first
/// is asked.
fn ask_for_motion(
    index: usize,
    section: &mut Section<'_>,
    asked: &mut Option<Span>,
    report: &mut Report<'_>,
) {
    let keys = ["motion", "kind", "surface"];
    let is_meant = |key: &str| key == "size" || did_you_mean(key, &keys).is_some();
    if section.keys.keys().any(|key| is_meant(key.get_ref())) {
        return;
    }
    let span = section.span.clone();
    if asked.as_ref() != Some(&span) {
        let at = At::subject(entry::subject("contact", Some(index), section));
        let message = "key `motion` is missing: \"hard\" for a contact that does not move, \"soft\" or \"free\" (or, \
                       for one whose constraints the file lists, `kind` and `surface`)";
        report.add(Kind::MissingKey, Some(span.clone()), &at, message);
        *asked = Some(span.clone());
    }
    value::put(section, "motion", value::text("hard".to_owned(), &span));
}

/// Writes out one contact. Whether it is short.
fn contact(
    index: usize,
    section: &mut Section<'_>,
    brought: &mut Vec<Brought>,
    notes: &mut Notes,
    report: &mut Report<'_>,
) -> bool {
    let at = At::subject(entry::subject("contact", Some(index), section));
    let size = section.take("size");
    let Some(motion) = section.take("motion") else {
        if let Some(size) = size {
            let message = "goes with `motion`, which brings the constraints of the sole: add `motion = \"hard\"`, \
                           or leave it out and list a `contact_wrench`";
            report.add(Kind::Value, Some(size.span()), &at.key("size"), message);
        }
        return false;
    };
    let span = motion.span();
    let motion = read_motion(motion.get_ref()).unwrap_or_else(|| {
        let hint = match motion.get_ref().as_str() {
            Some(word) => suggestion(word, &["free", "hard", "soft"]),
            None => String::new(),
        };
        let message = format!("must be \"hard\", \"soft\" or \"free\"{hint}");
        report.add(Kind::Value, Some(span.clone()), &at.key("motion"), message);
        // The file is refused; what any motion brings is not missing besides.
        Motion::Hard
    });
    let has_size = size.is_some();
    let half = size.and_then(|size| {
        let numbers = value::numbers(size.get_ref()).unwrap_or_default();
        match numbers.as_slice() {
            [x, y] if [x, y].iter().all(|l| l.is_finite() && **l > 0.0) => Some([x / 2.0, y / 2.0]),
            _ => {
                let message = "must be two lengths of the sole above zero, m: [along x, along y]";
                report.add(Kind::Value, Some(size.span()), &at.key("size"), message);
                None
            }
        }
    });
    fill(index, section, &span, notes, |key| match key {
        "kind" if has_size => Some(("\"full\"", "it has a `size`")),
        "kind" => Some(("\"point\"", "it has no `size`")),
        "surface" => Some((UPWARD, "the ground")),
        "active" => Some(("true", "it has `motion`")),
        "force_max" => Some((FORCE_MAX, "more than any robot puts on one contact")),
        _ => None,
    });
    level(section, &span);
    let kind = value::string(section, "kind")
        .unwrap_or_default()
        .to_owned();
    // A word that is no kind is refused when the contact is read.
    let known = kind_of(&kind);
    if has_size && !known.is_some_and(ContactKind::has_moments) {
        let message = format!(
            "a contact of kind `{kind}` has no sole: leave `size` out, or make it of kind `full`"
        );
        report.add(Kind::Value, Some(span), &at.key("size"), message);
        return true;
    }
    let Some(name) = value::string(section, "name").map(str::to_owned) else {
        return true;
    };
    let mut bring = |tag, half| {
        brought.push(Brought {
            tag,
            contact: name.clone(),
            span: span.clone(),
            half,
            motion: if tag == MOTION { motion } else { Motion::Hard },
        });
    };
    match (half, known) {
        (Some(half), _) => bring(WRENCH, Some(half)),
        (None, Some(ContactKind::Point)) => bring(PYRAMID, None),
        // Without a sole's size its moments have to be limited by an entry of its own.
        (None, Some(ContactKind::Full | ContactKind::Normal | ContactKind::NormalTilt) | None) => {}
    }
    if motion != Motion::Free {
        bring(MOTION, None);
    }
    true
}

/// The kind that a word names, if it names one.
fn kind_of(word: &str) -> Option<ContactKind> {
    ContactKind::deserialize(StrDeserializer::<Error>::new(word)).ok()
}

fn read_motion(value: &DeValue<'_>) -> Option<Motion> {
    match value.as_str()? {
        "hard" => Some(Motion::Hard),
        "soft" => Some(Motion::Soft),
        "free" => Some(Motion::Free),
        _ => None,
    }
}

/// Puts in what a contact with `motion` does not say.
fn fill(
    index: usize,
    section: &mut Section<'_>,
    span: &Span,
    notes: &mut Notes,
    default: impl Fn(&str) -> Option<(&'static str, &'static str)>,
) {
    for key in ["kind", "surface", "active", "force_max"] {
        if section.keys.contains_key(key) {
            continue;
        }
        if let Some((text, why)) = default(key)
            && let Some(value) = value::parsed(text, span)
        {
            value::put(section, key, value);
            notes.add(List::Contact, index, key, why);
        }
    }
}

/// A surface that says only where it is faces upwards.
fn level(section: &mut Section<'_>, span: &Span) {
    let Some(DeValue::Table(surface)) = section.keys.get_mut("surface").map(Spanned::get_mut)
    else {
        return;
    };
    if surface.contains_key("normal") {
        return;
    }
    for (key, text) in [("normal", UP), ("x_axis", ALONG_X)] {
        if !surface.contains_key(key)
            && let Some(value) = value::parsed(text, span)
        {
            let key = toml::Spanned::new(super::key_at(span), key.into());
            surface.insert(key, value);
        }
    }
}
