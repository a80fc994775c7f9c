//! What runs of the entries in a tick: each plug-in and the references that it follows, and what a first tick adds.
//!
//! # The first tick
//! References begin at what was measured, and nothing moves if a task is implausibly far from what it wants. A tick is
//! the first until one was plausible: after a refused one time counts anew, and references begin at what the next one
//! measures.

use super::{
    first::{Counts, Distance, FirstTick, Quantity},
    report::TaskReport,
    world::World,
};
use crate::{
    fault::Fault,
    plugin::{EntryState, Layout, bound::Running, followed::Followed, storage::RowStore},
    problem::BoundEntry,
    settings::StartFrom,
};

/// A plug-in and its references.
#[derive(Debug)]
pub(super) struct RunningPlugin {
    pub(super) plugin: Box<dyn Running>,
    pub(super) references: Vec<Followed>,
    /// By which files name its type.
    pub(super) tag: &'static str,
}

impl RunningPlugin {
    /// Takes the samples of this tick, and lets the plug-in write its rows.
    pub(super) fn update(
        &mut self,
        world: &World,
        entry: EntryState,
        layout: &Layout,
        store: &mut RowStore,
    ) {
        if !self.references.is_empty() {
            let tick = world.tick(entry);
            for reference in &mut self.references {
                reference.update(&tick);
            }
        }
        self.write(world, entry, layout, store);
    }

    /// Lets the plug-in write its rows for the samples that there are.
    pub(super) fn write(
        &mut self,
        world: &World,
        entry: EntryState,
        layout: &Layout,
        store: &mut RowStore,
    ) {
        store.begin();
        let mut tick = world.tick(entry);
        tick.references = &self.references;
        self.plugin.update(&tick, layout, store);
    }
}

impl FirstTick {
    /// Lets references begin at what is measured. Before the plug-ins write the rows of a first tick.
    pub(super) fn begin(&self, start: StartFrom, world: &World, plugins: &mut [RunningPlugin]) {
        if self.was_refused {
            // What the refused tick left in integrators and at points of touch.
            for plugin in plugins.iter_mut() {
                plugin.plugin.activate();
            }
        }
        if start == StartFrom::Home {
            return;
        }
        let tick = world.tick(EntryState::ON);
        for plugin in plugins {
            for reference in &mut plugin.references {
                reference.start_here(&tick);
            }
        }
    }

    /// Whether the rows of a first tick are plausible; the errors of all tasks are in their reports if they are not.
    ///
    /// # Errors
    /// [`Fault::FirstError`] with the first task whose error is too large.
    pub(super) fn check(
        &mut self,
        tasks: &[BoundEntry],
        reports: &mut [TaskReport],
    ) -> Result<(), Fault> {
        let limits = &self.limits;
        let is_far = |(task, entry): (usize, &BoundEntry)| {
            let Distance { position, rotation } = self.distance(task, &entry.store.error);
            entry.live && (position > limits.position || rotation > limits.rotation)
        };
        let Some(task) = tasks.iter().enumerate().position(is_far) else {
            self.is_over = true;
            return Ok(());
        };
        self.was_refused = true;
        for (entry, report) in tasks.iter().zip(reports) {
            report.fill(entry);
        }
        Err(Fault::FirstError(task))
    }

    /// How far a task is from what it wants.
    pub(super) fn distance(&self, task: usize, errors: &[f64]) -> Distance {
        let rows = self.errors.get(task).map(Vec::as_slice).unwrap_or_default();
        let of = |quantity: Quantity| {
            let (mut alone, mut squares) = (0.0_f64, 0.0);
            for (counts, error) in rows.iter().zip(errors) {
                match counts {
                    Counts::Alone(q) if *q == quantity => alone = alone.max(error.abs()),
                    Counts::Together(q) if *q == quantity => squares += error * error,
                    _ => {}
                }
            }
            alone.max(f64::sqrt(squares))
        };
        Distance {
            position: of(Quantity::Position),
            rotation: of(Quantity::Rotation),
        }
    }
}
