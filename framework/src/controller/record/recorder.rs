//! The last ticks of a controller, in a ring made once.

use super::{
    super::{Controller, RequestError},
    Dump, Record, blank_record,
};

impl Controller {
    /// Records the last `ticks` ticks, at least one. Costs a copy of the rows per tick.
    ///
    /// # Errors
    /// [`RequestError::Unrecordable`] if a plug-in cannot be written to a file.
    pub fn with_recorder(mut self, ticks: usize) -> Result<Self, RequestError> {
        if let Err(problem) = &self.made_from.configuration {
            return Err(RequestError::Unrecordable {
                problem: problem.clone(),
            });
        }
        let blank = blank_record(&self);
        self.recorder = Some(Recorder::new(&blank, ticks));
        Ok(self)
    }

    /// The recorded ticks if the level has changed in one of them since this was last asked. Allocates: call it outside
    /// the real-time part.
    pub fn take_dump(&mut self) -> Option<Dump> {
        let recorder = self.recorder.as_mut()?;
        if !std::mem::take(&mut recorder.pending) {
            return None;
        }
        self.dump()
    }

    /// The recorded ticks; nothing without a recorder or before the first tick. Allocates.
    pub fn dump(&self) -> Option<Dump> {
        let records: Vec<Record> = self.recorder.as_ref()?.records().cloned().collect();
        let configuration = self.made_from.configuration.clone().ok()?;
        let directory = &self.made_from.directory;
        (!records.is_empty()).then(|| Dump::new(directory, configuration, &self.robot, records))
    }
}

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
