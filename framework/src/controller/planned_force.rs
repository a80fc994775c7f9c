//! What will be asked of a controller, before it runs.

use super::{Controller, running::RunningPlugin};
use crate::{
    contact::ContactId,
    plugin::{EntryState, Sample, Tick},
    problem::BoundEntry,
};

impl Controller {
    /// The set points, at a time in s, of the tasks that push, are switched on and have a weight: of each its name, the
    /// contact, and the normal force that its reference says, N.
    ///
    /// For a controller that is only looked at: it has not run and will not. What is asked of it afterwards
    /// ([`follow`](Controller::follow) and so on) counts from one period after that time.
    pub fn planned_forces(&mut self, time: f64) -> Vec<(&str, ContactId, f64)> {
        self.world.time = time;
        self.world.origin = Some(0.0);
        let tick = self.world.tick(EntryState::ON);
        planned_forces(&tick, &self.entries, &mut self.plugins)
    }
}

/// The set points of the tasks that push, are switched on and have a weight.
fn planned_forces<'a>(
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
