//! What runs of an entry in each tick: the plug-in, and the references that it follows.

use crate::{
    error::BindError,
    plugin::{
        Displacement, EntryState, Layout, Slopes, bound::Running, followed::Followed,
        rows::RowStore,
    },
};

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
    /// Its keys with their present values, as its file would have them.
    pub(super) fn parameters(&self) -> Result<toml::Table, BindError> {
        match self.plugin.table() {
            Ok(toml::Value::Table(table)) => Ok(table),
            Ok(_) => Ok(toml::Table::new()),
            Err(error) => Err(BindError::Other(error.to_string())),
        }
    }

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

    /// Lets the plug-in add to its rows what a displacement of the state does to them; false if it does not say.
    pub(super) fn differentiate(
        &mut self,
        world: &World,
        entry: EntryState,
        moved: &Displacement,
        (layout, store): (&Layout, &mut RowStore),
    ) -> bool {
        let mut tick = world.tick(entry);
        tick.references = &self.references;
        let mut slopes = Slopes::new(layout, store);
        self.plugin.differentiate(&tick, moved, &mut slopes)
    }
}
