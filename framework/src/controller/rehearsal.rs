//! What will be asked of a controller, before it runs.

use super::Controller;
use crate::{
    contact::ContactId,
    plugin::{EntryState, Sample, Space},
};

/// The set point of a normal force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlannedForce<'a> {
    /// The task.
    pub task: &'a str,
    /// The contact.
    pub contact: ContactId,
    /// What its reference says, N.
    pub normal: f64,
}

impl Controller {
    /// The set points, at a time in s, of the tasks that push, are switched on and have a weight.
    ///
    /// For a controller that is only looked at: it has not run and will not. What is asked of it afterwards
    /// ([`follow`](Controller::follow) and so on) counts from one period after that time.
    pub fn rehearse(&mut self, time: f64) -> Vec<PlannedForce<'_>> {
        self.world.time = time;
        self.world.origin = Some(0.0);
        let mut planned = Vec::new();
        for (bound, task) in self.entries.iter().zip(&mut self.tasks) {
            let Some(contact) = task.pushes() else {
                continue;
            };
            if !bound.switch.is_wanted() || bound.weight.wanted().iter().all(|w| *w == 0.0) {
                continue;
            }
            let Some(follow) = task.follow() else {
                continue;
            };
            let mut sample = Sample::new(Space::Vector(1));
            let entry = EntryState {
                alpha: 1.0,
                since: f64::NEG_INFINITY,
            };
            follow
                .reference
                .sample(&self.world.tick(entry), &mut sample);
            planned.extend(sample.value.first().map(|&normal| PlannedForce {
                task: &bound.name,
                contact,
                normal,
            }));
        }
        planned
    }
}
