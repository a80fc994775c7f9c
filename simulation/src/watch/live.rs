//! A run that is watched and tuned while it goes on.

use std::{
    fmt, thread,
    time::{Duration, Instant},
};

use wbqp::controller::{Controller, Snapshot};
use wbqp_foxglove::LiveView;
use wbqp_log::{LogError, LogSink, TrueContact};

use super::Watcher;

/// Serves a run to Foxglove while it goes on, at the speed of real time, and takes changes from there
/// ([`LiveView`]).
pub struct LiveWatcher<'a> {
    port: u16,
    announce: &'a mut (dyn FnMut(u16) + 'a),
    view: Option<LiveView>,
    start: Instant,
}

impl<'a> LiveWatcher<'a> {
    /// On a port, 0 for any that is free; `announce` hears which when the run begins.
    pub fn new(port: u16, announce: &'a mut (dyn FnMut(u16) + 'a)) -> Self {
        Self {
            port,
            announce,
            view: None,
            start: Instant::now(),
        }
    }
}

impl fmt::Debug for LiveWatcher<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("LiveWatcher")
            .field("view", &self.view)
            .finish_non_exhaustive()
    }
}

impl Watcher for LiveWatcher<'_> {
    fn begin(&mut self, controller: &Controller, _: &mut dyn LogSink) -> Result<(), LogError> {
        let view = LiveView::on_port(controller, self.port);
        let view = view.map_err(|error| LogError::Write(Box::new(error)))?;
        (self.announce)(view.port());
        self.view = Some(view);
        self.start = Instant::now();
        Ok(())
    }

    fn after_tick(
        &mut self,
        controller: &mut Controller,
        snapshot: &Snapshot,
        truth: &[Option<TrueContact>],
        _: &mut dyn LogSink,
    ) -> Result<(), LogError> {
        if let Some(view) = &mut self.view {
            view.update_with(controller, &snapshot.measurement, truth);
        }
        let time = Duration::try_from_secs_f64(snapshot.measurement.time);
        let ahead = time
            .unwrap_or_default()
            .saturating_sub(self.start.elapsed());
        thread::sleep(ahead);
        Ok(())
    }
}
