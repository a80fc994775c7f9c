//! Outages whose sensor is misspelt, found where a case changes the one that was meant.

use toml::de::{DeTable, DeValue};

use super::change::Refusal;
use crate::sensors::BUILT_IN;

/// If changes name the outage of a sensor that there is, and the file has one of a sensor that there is not: that one.
/// That the first is not there is only what comes of it.
pub(super) fn misspelt(root: &DeTable<'_>, changes: &DeTable<'_>) -> Option<Refusal> {
    let changed = table(table(changes, "sensors")?, "outage")?;
    let sensors = table(root, "sensors")?;
    let mut known = BUILT_IN.to_vec();
    known.extend(texts(sensors, "force_torque", "frame").map(|(_, frame, _)| frame));
    let there: Vec<_> = texts(sensors, "outage", "sensor").collect();
    let meant = changed.keys().map(|name| &**name.get_ref()).find(|name| {
        let is_there = there.iter().any(|(_, sensor, _)| sensor == name);
        known.contains(name) && !is_there
    })?;
    let mut odd = there.into_iter();
    let (index, odd, span) = odd.find(|(_, sensor, _)| !known.contains(sensor))?;
    Some(Refusal {
        span,
        message: format!(
            "sensors.outage[{index}].sensor: there is no sensor `{odd}`; did you mean `{meant}`, whose outage is \
             changed?"
        ),
    })
}

fn table<'a, 't>(of: &'a DeTable<'t>, key: &str) -> Option<&'a DeTable<'t>> {
    of.get(key)?.get_ref().as_table()
}

/// Of a list's entries that have a text under a key: their index, the text, and where it is.
fn texts<'a>(
    of: &'a DeTable<'_>,
    list: &str,
    key: &'a str,
) -> impl Iterator<Item = (usize, &'a str, std::ops::Range<usize>)> {
    let entries = match of.get(list).map(toml::Spanned::get_ref) {
        Some(DeValue::Array(entries)) => entries.iter().as_slice(),
        _ => &[],
    };
    entries
        .iter()
        .enumerate()
        .filter_map(move |(index, entry)| {
            let text = entry.get_ref().as_table()?.get(key)?;
            Some((index, text.get_ref().as_str()?, text.span()))
        })
}
