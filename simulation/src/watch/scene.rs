//! A run in 3-D, in its log.

use wbqp::controller::{Controller, Snapshot};
use wbqp_foxglove::SceneLog;
use wbqp_log::{LogError, LogSink, TrueContact};

use super::Watcher;

/// Writes what a 3-D view shows into the log of a run ([`SceneLog`]).
#[derive(Debug, Default)]
pub struct SceneWatcher(Option<SceneLog>);

impl Watcher for SceneWatcher {
    fn begin(&mut self, controller: &Controller, sink: &mut dyn LogSink) -> Result<(), LogError> {
        self.0 = Some(SceneLog::new(controller, sink)?);
        Ok(())
    }

    fn after_tick(
        &mut self,
        _: &mut Controller,
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
