//! Events that come to nothing.

use std::collections::HashSet;

use wbqp::controller::Controller;

use crate::scenario::Case;

impl Case {
    /// References that are given to tasks that are never on.
    pub(super) fn unfollowed(&self, controller: &Controller) -> Vec<String> {
        let switched: HashSet<&String> = self.events().iter().flat_map(|e| &e.activate).collect();
        let is_off = |task: &str| controller.is_on(task) == Ok(false);
        let mut told = HashSet::new();
        let followed = self.events().iter().flat_map(|e| e.follow.keys());
        followed
            .filter(|task| is_off(task) && !switched.contains(task) && told.insert(task.as_str()))
            .map(|task| {
                format!(
                    "task `{task}` gets a reference (`follow`) and is never on: add `activate = [\"{task}\"]` to an \
                     event"
                )
            })
            .collect()
    }

    /// References that take longer than what is left of the run.
    pub(super) fn unfinished(&self) -> Vec<String> {
        let end = self.duration();
        let mut warnings = Vec::new();
        for event in self.events() {
            for (task, reference) in &event.follow {
                let number = |value: &toml::Value| {
                    let whole = value.as_integer().map(|whole| whole as f64);
                    value.as_float().or(whole)
                };
                let duration = reference.get("duration").and_then(number);
                if let Some(duration) = duration.filter(|d| event.at + d > end + 1e-9) {
                    warnings.push(format!(
                        "task `{task}`: its reference from {} s on takes {duration} s, and the run ends at {end} s",
                        event.at
                    ));
                }
            }
        }
        warnings
    }
}
