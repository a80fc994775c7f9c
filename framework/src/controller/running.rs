//! What runs of an entry in each tick: the plug-in, and the references that it follows.

use crate::plugin::{EntryState, Layout, Tick, bound::Running, followed::Followed, rows::RowStore};

use super::world::World;

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
        let tick = world.tick(entry);
        for reference in &mut self.references {
            reference.update(&tick);
        }
        let tick = Tick {
            references: &self.references,
            ..tick
        };
        self.plugin.update(&tick, layout, store);
    }
}
