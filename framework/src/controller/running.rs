//! What runs of an entry in each tick: the plug-in, and the references that it follows.

use std::any::Any;

use crate::{
    error::BindError,
    plugin::{
        AnyReference, EntryState, Layout, Tick, bound::Running, followed::Followed, rows::RowStore,
    },
};

use super::{error::RequestError, world::World};

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

    /// Its parameters.
    pub(super) fn parameters(&self) -> &dyn Any {
        self.plugin.parameters()
    }
}

/// Lets another reference take over from the first of a task's references at a time, s.
pub(super) fn follow(
    references: &mut [Followed],
    name: &str,
    reference: &dyn AnyReference,
    time: f64,
) -> Result<(), RequestError> {
    let name = || name.to_owned();
    let followed = references
        .first_mut()
        .ok_or_else(|| RequestError::NoReference { name: name() })?;
    let refused = |source: BindError| RequestError::Value {
        name: name(),
        source,
    };
    followed.replace(reference, time).map_err(refused)
}
