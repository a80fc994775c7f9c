//! Events of one time that ask for two things of which only the last would come to pass.

use std::collections::HashMap;

use wbqp::plugin::PerRow;

use super::Event;

/// What an event does to something.
#[derive(Clone, Copy, PartialEq)]
enum Asked<'e> {
    On,
    Off,
    Weight(&'e PerRow),
    Reference(&'e toml::Value),
}

/// The first event that contradicts one of the same time, itself included: its index, and why, behind the key.
pub(super) fn contradiction(events: &[Event]) -> Option<(usize, String)> {
    let mut in_time: Vec<(usize, &Event)> = events.iter().enumerate().collect();
    in_time.sort_by(|(_, a), (_, b)| a.at.total_cmp(&b.at));
    let mut time = f64::NAN;
    let mut known = HashMap::new();
    for (index, event) in in_time {
        if event.at != time {
            time = event.at;
            known.clear();
        }
        for (of, key, name, asked) in asked(event) {
            let before = known.insert((of, name), (index, asked));
            let Some((other, before)) = before.filter(|(_, before)| *before != asked) else {
                continue;
            };
            let whose = if other == index {
                "this event"
            } else {
                "another event of this time"
            };
            let what = match before {
                Asked::On => "switches it on",
                Asked::Off => "switches it off",
                Asked::Weight(_) | Asked::Reference(_) => "gives it another one",
            };
            let subject = match asked {
                Asked::Weight(_) | Asked::Reference(_) => format!("{key}.{name}"),
                Asked::On | Asked::Off => format!("{key}: `{name}`"),
            };
            let why = format!("{subject}: {whose} {what}, and only the last of them would count");
            return Some((index, why));
        }
    }
    None
}

/// To what an event does something that another could undo: among what it is known, by which key, its name, and what.
fn asked(event: &Event) -> impl Iterator<Item = (&'static str, &'static str, &str, Asked<'_>)> {
    let switches = [
        (
            "contact",
            "deactivate_contact",
            &event.deactivate_contact,
            Asked::Off,
        ),
        (
            "contact",
            "activate_contact",
            &event.activate_contact,
            Asked::On,
        ),
        ("entry", "deactivate", &event.deactivate, Asked::Off),
        ("entry", "activate", &event.activate, Asked::On),
    ];
    let switches = switches.into_iter().flat_map(|(of, key, names, asked)| {
        let names = names.iter();
        names.map(move |name| (of, key, name.as_str(), asked))
    });
    let weights = event.weight.iter();
    let references = event.follow.iter();
    switches
        .chain(weights.map(|(name, to)| ("weight", "weight", name.as_str(), Asked::Weight(to))))
        .chain(
            references.map(|(name, to)| ("follow", "follow", name.as_str(), Asked::Reference(to))),
        )
}
