//! Entries that would do nothing: disturbances that do not push, and what would begin behind the end of the run.

use std::collections::HashSet;

use toml::de::DeTable;

use super::{
    Case, ScenarioError,
    change::{DISTURBANCES, Refusal},
    file::Cases,
    text::Text,
};

/// Refuses a disturbance of which nothing says how it pushes, neither its entry nor any change: a forgotten key.
///
/// One whose force is zero in so many words is taken: what changes it may come later, such as a factor of a campaign,
/// and a sweep may begin at zero.
pub(super) fn check_disturbances(text: &Text<'_>, cases: &Cases<'_>) -> Result<(), ScenarioError> {
    let mut changed: Option<HashSet<String>> = None;
    for (index, entry) in cases.members().entries(&DISTURBANCES).enumerate() {
        let (Some(keys), Some(name)) = (
            entry.get_ref().as_table(),
            DISTURBANCES.name_of(entry.get_ref()),
        ) else {
            continue;
        };
        if keys.contains_key("force") || keys.contains_key("moment") {
            continue;
        }
        let changed = changed.get_or_insert_with(|| changed_disturbances(text, cases));
        if changed.contains(name) {
            continue;
        }
        return Err(text.refusal(Refusal {
            span: entry.span(),
            message: format!(
                "plant.disturbance[{index}] `{name}`: has neither `force` (N) nor `moment` (N·m), so that it does \
                 nothing: give it one (of zeros, if something else sets it later), or take it out"
            ),
        }));
    }
    Ok(())
}

/// The names of disturbances that any case or the variation changes.
fn changed_disturbances(text: &Text<'_>, cases: &Cases<'_>) -> HashSet<String> {
    let mut names = HashSet::new();
    let mut add = |change: &DeTable<'_>| {
        let plant = change
            .get("plant")
            .and_then(|plant| plant.get_ref().as_table());
        let list = plant.and_then(|plant| plant.get("disturbance")?.get_ref().as_table());
        let keys = list.into_iter().flat_map(DeTable::keys);
        names.extend(keys.map(|name| name.get_ref().to_string()));
    };
    add(cases.varied());
    text.each_change(cases, add);
    names
}

impl Case {
    /// Refuses disturbances and outages that no run of this file, as long as the longest of its cases, would see.
    ///
    /// What begins behind the end of this case alone is left: entries are shared, and a case, or a variation, may be
    /// shorter than the others without having to take out what only they come to.
    pub(super) fn check_beginnings(&self, text: &Text<'_>, rate: f64) -> Result<(), ScenarioError> {
        let never = |key: String, from: f64, end: f64, does: &str| {
            self.refuse(&format!(
                "{key}.from: is {from} s, and the longest case ends at {end} s: it would never {does}; let it begin \
                 earlier, or make `duration` longer"
            ))
        };
        let own = self.duration();
        for (index, disturbance) in self.plant().disturbances.iter().enumerate() {
            if disturbance.from >= own {
                let end = own.max(text.longest());
                if disturbance.from >= end {
                    let key = format!("plant.disturbance[{index}]");
                    return Err(never(key, disturbance.from, end, "push"));
                }
            }
        }
        // It breaks at the first sample after it begins, and the last sample is a period before the end.
        let last = |end: f64| end - (1.0 - 1e-6) / rate;
        for (index, outage) in self.sensors().outages.iter().enumerate() {
            if outage.from > last(own) {
                let end = own.max(text.longest());
                if outage.from > last(end) {
                    let key = format!("sensors.outage[{index}]");
                    return Err(never(key, outage.from, end, "break the sensor"));
                }
            }
        }
        Ok(())
    }
}
