//! The last ticks of a controller, in a ring made once.

use super::Record;

/// A ring of records, and whether something happened that is worth a dump.
#[derive(Clone, Debug)]
pub(crate) struct Recorder {
    ring: Vec<Record>,
    /// Where the next tick goes.
    next: usize,
    /// How many are filled.
    filled: usize,
    pub(crate) pending: bool,
}

impl Recorder {
    /// A ring of copies of a record that has the controller's sizes.
    pub(crate) fn new(blank: &Record, capacity: usize) -> Self {
        Self {
            ring: vec![blank.clone(); capacity.max(1)],
            next: 0,
            filled: 0,
            pending: false,
        }
    }

    /// The record of the tick that is under way.
    pub(crate) fn current(&mut self) -> Option<&mut Record> {
        self.ring.get_mut(self.next)
    }

    /// The tick's own problem was solved, or given up, in so many iterations.
    pub(crate) fn solved_in(&mut self, iterations: u32) {
        if let Some(record) = self.current() {
            record.outcome.solved_in = iterations;
        }
    }

    /// The tick is over.
    pub(crate) fn advance(&mut self) {
        self.next = (self.next + 1) % self.ring.len();
        self.filled = (self.filled + 1).min(self.ring.len());
    }

    /// The records, oldest first.
    pub(crate) fn records(&self) -> impl Iterator<Item = &Record> {
        let length = self.ring.len();
        let first = (self.next + length - self.filled) % length;
        (0..self.filled).filter_map(move |i| self.ring.get((first + i) % length))
    }
}
