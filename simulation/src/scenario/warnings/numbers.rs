//! Numbers that hardly any robot or world has.

use std::collections::HashSet;

use wbqp::{config::plausible::MOST_APART, controller::Controller};

use crate::scenario::{Case, Event};

impl Case {
    /// Those of the world, of its sensors, of the beginning and of events.
    pub(super) fn odd_numbers(&self, controller: &Controller) -> Vec<String> {
        let mut warnings = self.initial_numbers().into_warnings();
        let of_table = |table, warnings: Vec<String>| {
            let named = move |what| format!("{table}.{what}");
            warnings.into_iter().map(named)
        };
        warnings.extend(of_table("plant", self.plant().check().into_warnings()));
        warnings.extend(of_table("sensors", self.sensors().check().into_warnings()));
        for event in self.events() {
            // What is refused was refused when the scenario was read.
            let own = event.check_numbers(controller).unwrap_or_default();
            warnings.extend(
                own.iter()
                    .map(|what| format!("event at {} s: {what}", event.at)),
            );
        }
        warnings.extend(self.weights_apart(controller));
        warnings
    }

    /// New weights beside which nothing is left of another one, or of which nothing is left beside it.
    fn weights_apart(&self, controller: &Controller) -> Vec<String> {
        let weights = |event: &Event| -> Vec<(String, f64)> {
            let all = event.weight.iter().flat_map(|(name, weight)| {
                let values = weight.values().iter();
                values.map(|value| (name.clone(), *value))
            });
            all.collect()
        };
        let first = controller.entry_names().flat_map(|name| {
            let own = controller.weight(name).unwrap_or_default();
            own.iter().map(|value| (name.to_owned(), *value))
        });
        let mut known: Vec<(String, f64)> = first.filter(|(_, value)| *value > 0.0).collect();
        let mut told = HashSet::new();
        let mut warnings = Vec::new();
        for event in self.events() {
            let new: Vec<_> = weights(event)
                .into_iter()
                .filter(|(_, w)| *w > 0.0)
                .collect();
            known.extend(new.iter().cloned());
            for (name, weight) in new {
                let apart = |other: f64| (weight / other).max(other / weight) > MOST_APART;
                let other = known.iter().find(|(_, other)| apart(*other));
                let Some((other, of_other)) = other.filter(|_| told.insert(name.clone())) else {
                    continue;
                };
                warnings.push(format!(
                    "event at {} s: weight.{name}: is {weight:e}, and that of `{other}` is {of_other:e}: where both \
                     are about the same motion, nothing of the smaller one is left in 64 bits; keep weights within \
                     {MOST_APART:e} of one another",
                    event.at
                ));
            }
        }
        warnings
    }
}
