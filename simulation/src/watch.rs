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

/// Serves a run to Foxglove while it goes on, at the speed of real time, and takes changes from there
/// ([`LiveView`](wbqp_foxglove::LiveView)).
#[cfg(feature = "live")]
pub struct LiveWatcher<'a> {
    port: u16,
    announce: &'a mut (dyn FnMut(u16) + 'a),
    view: Option<wbqp_foxglove::LiveView>,
    start: std::time::Instant,
}

#[cfg(feature = "live")]
impl<'a> LiveWatcher<'a> {
    /// On a port, 0 for any that is free; `announce` hears which when the run begins.
    pub fn new(port: u16, announce: &'a mut (dyn FnMut(u16) + 'a)) -> Self {
        Self {
            port,
            announce,
            view: None,
            start: std::time::Instant::now(),
        }
    }
}

#[cfg(feature = "live")]
impl std::fmt::Debug for LiveWatcher<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("LiveWatcher")
            .field("view", &self.view)
            .finish_non_exhaustive()
    }
}

#[cfg(feature = "live")]
impl Watcher for LiveWatcher<'_> {
    fn begin(&mut self, controller: &Controller, _: &mut dyn LogSink) -> Result<(), LogError> {
        let view = wbqp_foxglove::LiveView::on_port(controller, self.port);
        let view = view.map_err(|error| LogError::Write(Box::new(error)))?;
        (self.announce)(view.port());
        self.view = Some(view);
        self.start = std::time::Instant::now();
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
        let time = std::time::Duration::try_from_secs_f64(snapshot.measurement.time);
        let ahead = time
            .unwrap_or_default()
            .saturating_sub(self.start.elapsed());
        std::thread::sleep(ahead);
        Ok(())
    }
}
