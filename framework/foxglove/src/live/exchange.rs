//! What passes between the loop and the view's thread. Neither waits for the other.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use crossbeam_queue::ArrayQueue;
use wbqp::{
    Controller, Measurement,
    controller::{RequestError, Snapshot},
};
use wbqp_log::TrueContact;

use super::parameters::Request;

/// Ticks that wait to be shown.
pub(super) const DEPTH: usize = 16;
/// Changes that wait to be applied.
const REQUESTS: usize = 64;
/// Changes that are applied after one tick.
const REQUESTS_PER_TICK: usize = 4;

/// A tick on its way to the view.
#[derive(Debug)]
pub(super) struct Shown {
    pub(super) snapshot: Snapshot,
    pub(super) truth: Vec<Option<TrueContact>>,
}

/// A request and what the controller said.
#[derive(Debug)]
pub(super) struct Outcome {
    pub(super) request: Request,
    pub(super) result: Result<(), RequestError>,
}

/// Queues without locks, of sizes that never change.
#[derive(Debug)]
pub(super) struct Exchange {
    shown: ArrayQueue<Box<Shown>>,
    /// Those that may be written again.
    blank: ArrayQueue<Box<Shown>>,
    requests: ArrayQueue<Request>,
    outcomes: ArrayQueue<Outcome>,
    dropped: AtomicU64,
    stopped: AtomicBool,
}

impl Exchange {
    pub(super) fn new(controller: &Controller) -> Self {
        let blank = ArrayQueue::new(DEPTH);
        let contacts = controller.contact_names().count();
        for _ in 0..DEPTH {
            let shown = Shown {
                snapshot: controller.snapshot(),
                truth: vec![None; contacts],
            };
            // There is room for as many as there are.
            let _ = blank.push(Box::new(shown));
        }
        Self {
            shown: ArrayQueue::new(DEPTH),
            blank,
            requests: ArrayQueue::new(REQUESTS),
            outcomes: ArrayQueue::new(REQUESTS),
            dropped: AtomicU64::new(0),
            stopped: AtomicBool::new(false),
        }
    }

    /// In the loop: shows a tick. If the view is behind, the oldest that waits is overwritten.
    pub(super) fn show(
        &self,
        controller: &Controller,
        measurement: &Measurement,
        truth: &[Option<TrueContact>],
    ) {
        let oldest = || {
            let oldest = self.shown.pop();
            self.count_dropped();
            oldest
        };
        let Some(mut shown) = self.blank.pop().or_else(oldest) else {
            return;
        };
        shown.snapshot.take(controller, measurement);
        for (i, out) in shown.truth.iter_mut().enumerate() {
            *out = truth.get(i).copied().flatten();
        }
        // There is room for as many as there are.
        let _ = self.shown.push(shown);
    }

    /// In the loop: applies what clients have asked for.
    pub(super) fn apply(&self, controller: &mut Controller) {
        for _ in 0..REQUESTS_PER_TICK {
            // Whoever asked has to hear of it: what cannot be answered yet waits.
            if self.outcomes.is_full() {
                return;
            }
            let Some(request) = self.requests.pop() else {
                return;
            };
            let result = request.change.apply(controller);
            let _ = self.outcomes.push(Outcome { request, result });
        }
    }

    /// In the view's thread: the next tick to be shown.
    pub(super) fn next_shown(&self) -> Option<Box<Shown>> {
        self.shown.pop()
    }

    /// In the view's thread: gives a tick back to be written again.
    pub(super) fn give_back(&self, shown: Box<Shown>) {
        let _ = self.blank.push(shown);
    }

    /// In a server's thread: asks for a change; gives it back if too many wait.
    pub(super) fn ask(&self, request: Request) -> Result<(), Request> {
        self.requests.push(request)
    }

    /// In the view's thread: what became of a request.
    pub(super) fn next_outcome(&self) -> Option<Outcome> {
        self.outcomes.pop()
    }

    fn count_dropped(&self) {
        self.dropped.fetch_add(1, Ordering::Relaxed);
    }

    /// Ticks that were never shown.
    pub(super) fn dropped(&self) -> u64 {
        self.dropped.load(Ordering::Relaxed)
    }

    pub(super) fn stop(&self) {
        self.stopped.store(true, Ordering::Relaxed);
    }

    pub(super) fn is_stopped(&self) -> bool {
        self.stopped.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use wbqp::ControllerConfig;

    use super::*;
    use {wbqp_robots as _, wbqp_tasks as _};

    #[test]
    fn the_newest_ticks_win() {
        let text = concat!(
            "[controller]\nrate = 250.0\n\n[robot]\ntype = \"othex\"\n\n",
            "[[task]]\ntype = \"posture\"\nkp = 20.0\n",
        );
        let config = ControllerConfig::from_str(text, "live.toml", Path::new("."));
        let mut controller = Controller::new(config.expect("is read")).expect("is made");
        let exchange = Exchange::new(&controller);
        let mut measurement = controller.measurement();
        let count = DEPTH as u32 + 5;
        for tick in 1..=count {
            measurement.time = 0.004 * f64::from(tick);
            controller.tick(&measurement);
            exchange.show(&controller, &measurement, &[]);
        }
        let shown = std::iter::from_fn(|| exchange.next_shown());
        let times: Vec<f64> = shown.map(|shown| shown.snapshot.measurement.time).collect();
        let newest = (6..=count).map(|tick| 0.004 * f64::from(tick));
        let newest: Vec<f64> = newest.collect();
        assert_eq!(times, newest);
        assert_eq!(exchange.dropped(), 5);
    }
}
