//! What will be asked of a controller, before it runs.

use super::running::RunningPlugin;
use crate::{
    contact::ContactId,
    plugin::{Sample, Tick},
    problem::BoundEntry,
};

/// The set points of the tasks that push, are switched on and have a weight.
pub(super) fn planned_forces<'a>(
    tick: &Tick<'_>,
    entries: &'a [BoundEntry],
    plugins: &mut [RunningPlugin],
) -> Vec<(&'a str, ContactId, f64)> {
    let mut planned = Vec::new();
    for (bound, plugin) in entries.iter().zip(plugins) {
        if !bound.switch.is_wanted() || bound.weight.wanted().iter().all(|w| *w == 0.0) {
            continue;
        }
        for reference in &mut plugin.references {
            let Some(pushes) = reference.pushes else {
                continue;
            };
            if let Sample::Vector(sample) = reference.look(tick)
                && let Some(&normal) = sample.value.first()
            {
                planned.push((bound.name.as_str(), pushes.contact, normal));
            }
        }
    }
    planned
}
