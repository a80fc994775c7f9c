//! Ticks in numbers: what each depended on and what came out, kept in storage made once.

mod contacts;
mod dump;
mod recorder;
mod recording;
mod tick_record;

pub use dump::Dump;
pub(super) use tick_record::Record;

pub(super) use recorder::Recorder;
pub(crate) use recording::MadeFrom;
pub(super) use recording::{
    blank_memory, blank_record, recall_filters, recall_rows, recall_world, record_inputs,
    record_outcome, record_rows, remember_world,
};
pub(super) use tick_record::Memory as TickMemory;
pub(crate) use tick_record::{CommandRecord, ContactMemory};
use tick_record::{EntryRecord, Memory, Outcome, StateRecord};
