//! Who follows a run.

use wbqp::{
    controller::{Controller, Snapshot},
    replay::DumpFolder,
};
use wbqp_log::{LogError, LogSink, TrueContact};

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

    /// Before each tick, at `time`, s. Whoever waits here slows the run down.
    fn before_tick(&mut self, time: f64, controller: &mut Controller) {
        let _ = (time, controller);
    }

    /// After each tick. `truth` is what the plant knows of each contact.
    ///
    /// # Errors
    /// What ends the run.
    fn after_tick(
        &mut self,
        snapshot: &Snapshot,
        truth: &[Option<TrueContact>],
        sink: &mut dyn LogSink,
    ) -> Result<(), LogError>;
}

/// Writes what a 3-D view shows into the log of a run ([`SceneLog`](wbqp_foxglove::SceneLog)).
#[cfg(feature = "foxglove")]
#[derive(Debug, Default)]
pub struct SceneWatcher(Option<wbqp_foxglove::SceneLog>);

#[cfg(feature = "foxglove")]
impl Watcher for SceneWatcher {
    fn begin(&mut self, controller: &Controller, sink: &mut dyn LogSink) -> Result<(), LogError> {
        self.0 = Some(wbqp_foxglove::SceneLog::new(controller, sink)?);
        Ok(())
    }

    fn after_tick(
        &mut self,
        snapshot: &Snapshot,
        truth: &[Option<TrueContact>],
        sink: &mut dyn LogSink,
    ) -> Result<(), LogError> {
        match &mut self.0 {
            Some(log) => log.record(snapshot, truth, sink),
            None => Ok(()),
        }
    }
}
