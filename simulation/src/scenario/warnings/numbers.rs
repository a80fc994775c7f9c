//! Numbers that hardly any robot or world has.

use std::collections::HashSet;

use wbqp::{config::plausible::MOST_APART, controller::Controller};

use crate::scenario::{Case, check::detector_numbers};

impl Case {
    /// Those of the world, of its sensors, of the beginning, of detectors and of events.
    pub(super) fn odd_numbers(&self, controller: &Controller) -> Vec<String> {
        let mut warnings = self.initial_numbers().into_warnings();
        let of_table = |table, warnings: Vec<String>| {
            let named = move |what| format!("{table}.{what}");
            warnings.into_iter().map(named)
        };
        warnings.extend(of_table("plant", self.plant().check().into_warnings()));
        warnings.extend(of_table("sensors", self.sensors().check().into_warnings()));
        // What is refused was refused when the scenario was read.
        for detector in self.detectors() {
            let own = detector_numbers(detector).unwrap_or_default();
            warnings.extend(own.iter().map(|what| format!("detector: {what}")));
        }
        for event in self.events() {
            let own = event.check_numbers(controller).unwrap_or_default();
            warnings.extend(
                own.iter()
                    .map(|what| format!("event at {} s: {what}", event.at)),
            );
        }
        warnings.extend(self.weights_apart(controller));
        warnings
    }

    /// New weights beside which nothing is left of the smallest one so far, or of which nothing is left beside the
    /// largest.
    fn weights_apart(&self, controller: &Controller) -> Vec<String> {
        let mut range = Range::default();
        for name in controller.entry_names() {
            for weight in controller.weight(name).unwrap_or_default() {
                range.extend(name, *weight);
            }
        }
        let mut told = HashSet::new();
        let mut warnings = Vec::new();
        for event in self.events() {
            for (name, weights) in &event.weight {
                for &weight in weights.values() {
                    range.extend(name, weight);
                    let Some((other, of_other)) = range.far_from(weight) else {
                        continue;
                    };
                    if told.insert(name) {
                        warnings.push(format!(
                            "event at {} s: weight.{name}: is {weight:e}, and that of `{other}` is {of_other:e}: \
                             where both are about the same motion, nothing of the smaller one is left in 64 bits; \
                             keep weights within {MOST_APART:e} of one another",
                            event.at
                        ));
                    }
                }
            }
        }
        warnings
    }
}

/// The smallest and the largest weight so far that is not zero, with the entry's name.
#[derive(Default)]
struct Range<'a> {
    smallest: Option<(&'a str, f64)>,
    largest: Option<(&'a str, f64)>,
}

impl<'a> Range<'a> {
    fn extend(&mut self, name: &'a str, weight: f64) {
        if weight <= 0.0 {
            return;
        }
        if self.smallest.is_none_or(|(_, smallest)| weight < smallest) {
            self.smallest = Some((name, weight));
        }
        if self.largest.is_none_or(|(_, largest)| weight > largest) {
            self.largest = Some((name, weight));
        }
    }

    /// The end that is too far away for both to count.
    fn far_from(&self, weight: f64) -> Option<(&'a str, f64)> {
        let apart = |other: f64| (weight / other).max(other / weight) > MOST_APART;
        let ends = self.smallest.into_iter().chain(self.largest);
        ends.filter(|_| weight > 0.0)
            .find(|(_, other)| apart(*other))
    }
}
