//! Who follows a run.

#[cfg(feature = "live")]
mod live;
#[cfg(feature = "foxglove")]
mod scene;

#[cfg(feature = "live")]
pub use live::LiveWatcher;
#[cfg(feature = "foxglove")]
pub use scene::SceneWatcher;

use wbqp::controller::{Controller, Snapshot};
use wbqp_log::{LogError, LogSink, TrueContact};
use wbqp_replay::DumpFolder;

/// What is wanted of a run beside its log and its summary.
#[derive(Default)]
pub struct RunOptions<'a> {
    /// Hears the finished fraction, 0 to 1, about a hundred times.
    pub progress: Option<&'a mut dyn FnMut(f64)>,
    /// Where the ticks before a change of the level go, for `replay`.
    pub dumps: Option<&'a mut DumpFolder>,
    /// They follow every tick, in this order.
    pub watchers: Vec<&'a mut dyn Watcher>,
}

impl RunOptions<'_> {
    /// Tells how much of the run is done.
    pub(crate) fn tell(&mut self, fraction: f64) {
        if let Some(progress) = &mut self.progress {
            progress(fraction);
        }
    }
}

impl std::fmt::Debug for RunOptions<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("RunOptions")
            .field("dumps", &self.dumps)
            .field("watchers", &self.watchers.len())
            .finish_non_exhaustive()
    }
}

/// Somebody who follows a run tick by tick, writes into its log, and may change the controller between two ticks.
pub trait Watcher {
    /// Before the first tick.
    ///
    /// # Errors
    /// What ends the run.
    fn begin(&mut self, controller: &Controller, sink: &mut dyn LogSink) -> Result<(), LogError>;

    /// After each tick, which `snapshot` is of. `truth` is what the plant knows of each contact. What is changed of the
    /// controller holds from the next tick on; whoever waits here slows the run down.
    ///
    /// # Errors
    /// What ends the run.
    fn after_tick(
        &mut self,
        controller: &mut Controller,
        snapshot: &Snapshot,
        truth: &[Option<TrueContact>],
        sink: &mut dyn LogSink,
    ) -> Result<(), LogError>;
}

/// Nobody follows where there is none.
impl<W: Watcher> Watcher for Option<W> {
    fn begin(&mut self, controller: &Controller, sink: &mut dyn LogSink) -> Result<(), LogError> {
        self.as_mut()
            .map_or(Ok(()), |one| one.begin(controller, sink))
    }

    fn after_tick(
        &mut self,
        controller: &mut Controller,
        snapshot: &Snapshot,
        truth: &[Option<TrueContact>],
        sink: &mut dyn LogSink,
    ) -> Result<(), LogError> {
        self.as_mut().map_or(Ok(()), |one| {
            one.after_tick(controller, snapshot, truth, sink)
        })
    }
}
