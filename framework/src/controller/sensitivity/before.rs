//! What a controller remembered before its last tick: from there that tick is computed again.

use super::super::{
    Controller, FallbackLevel, Measurement,
    record::{TickMemory, blank_memory, recall_filters, recall_world, remember_world},
    running::RunningPlugin,
    world::World,
};
use crate::plugin::remembered::Memo;

/// What a controller remembered before its last tick, and what that measured. In storage made once.
#[derive(Clone, Debug)]
pub(in super::super) struct Before {
    /// Whether the tick got as far as rows that its plug-ins wrote.
    pub(super) is_whole: bool,
    /// Time that the tick stood for, and for which `slew` counted, s.
    elapsed: f64,
    slew_time: f64,
    /// Whether what happened since the last usable state was seen.
    is_continuous: bool,
    /// Of the tick before.
    level: FallbackLevel,
    pub(super) measurement: Measurement,
    world: TickMemory,
    /// What each plug-in remembered before its update.
    pub(super) plugins: Vec<Memo>,
}

impl Before {
    pub(in super::super) fn new(controller: &mut Controller) -> Self {
        let memo =
            |plugin: &mut RunningPlugin| Memo::of(|numbers| plugin.plugin.remembered(numbers));
        Self {
            is_whole: false,
            elapsed: 0.0,
            slew_time: 0.0,
            is_continuous: false,
            level: FallbackLevel::default(),
            measurement: controller.measurement(),
            world: blank_memory(&controller.world),
            plugins: controller.plugins.iter_mut().map(memo).collect(),
        }
    }

    /// A tick begins.
    pub(in super::super) fn forget(&mut self) {
        self.is_whole = false;
    }

    /// Takes down what is remembered before a usable measurement is taken over.
    pub(in super::super) fn keep_world(
        &mut self,
        world: &World,
        measurement: &Measurement,
        level: FallbackLevel,
    ) {
        self.measurement.copy_from(measurement);
        self.level = level;
        (self.elapsed, self.slew_time) = (world.elapsed, world.slew_time);
        self.is_continuous = world.is_continuous;
        remember_world(world, &mut self.world);
    }

    /// Takes down what a plug-in remembers before its update.
    pub(in super::super) fn keep_plugin(&mut self, index: usize, plugin: &mut RunningPlugin) {
        if let Some(memo) = self.plugins.get_mut(index) {
            memo.save(|numbers| plugin.plugin.remembered(numbers));
        }
    }

    /// All plug-ins have written their rows.
    pub(in super::super) fn complete(&mut self) {
        self.is_whole = true;
    }

    /// Lets another world take a measurement as the tick took its own.
    pub(super) fn measure(&self, world: &mut World, measurement: &Measurement) {
        if world.observer.is_some() {
            // It predicts from the last state.
            recall_world(world, &self.world);
        } else {
            recall_filters(world, &self.world);
        }
        (world.elapsed, world.slew_time) = (self.elapsed, self.slew_time);
        world.is_continuous = self.is_continuous;
        world.measure(measurement, self.level);
    }
}
