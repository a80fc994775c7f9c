//! Logs: channels of timed, named, described values, written to any sink.
//!
//! A [`LogSink`] takes channels, messages, metadata and attachments. [`McapLog`] writes them to an MCAP file that
//! Foxglove and PlotJuggler open; [`MemoryLog`] keeps them for tests. [`ControllerLog`] writes what a controller
//! knows after a tick: state, command, forces of each contact, residuals of each task, and the solver's report.
//!
//! # Format
//! A message is a JSON object described by a JSON schema, which names the unit of every number. What has a name is
//! a field, never a position in a list. A value that does not exist (the set point of a contact without force
//! task) or is not finite is left out, so that every message is valid under its schema; Foxglove refuses schemas
//! with nullable types. Times are seconds of the measurement's clock. Channels of Protocol Buffers are for the types
//! that other programs define, such as Foxglove's.
//!
//! ```
//! use wbqp_log::{LogSink, MemoryLog, JsonWriter, schema};
//!
//! let mut log = MemoryLog::default();
//! let description = schema::object("A spring.", [("force", schema::number("N", "Pull"))]);
//! let channel = log.channel("/spring", "Spring", &description)?;
//! let mut message = Vec::new();
//! JsonWriter::write(&mut message, |o| o.number("force", 2.5));
//! log.write(channel, 0.1, &message)?;
//! assert_eq!(log.messages("/spring").next().unwrap().1["force"], 2.5);
//! # Ok::<(), wbqp_log::LogError>(())
//! ```

mod controller;
mod fields;
mod json;
#[cfg(feature = "mcap")]
mod layout;
mod lock;
#[cfg(feature = "mcap")]
mod mcap;
mod memory;
mod messages;
#[cfg(feature = "mcap")]
mod repair;
mod run;
#[cfg(feature = "mcap")]
mod scan;
pub mod schema;
mod state;
mod time;

pub use controller::{ControllerLog, TrueContact};
pub use fields::{Fields, write_message};
pub use json::JsonWriter;
pub use lock::RunLock;
#[cfg(feature = "mcap")]
pub use mcap::McapLog;
pub use memory::MemoryLog;
#[cfg(feature = "mcap")]
pub use repair::{Repaired, repair};
pub use run::{Timeline, configuration_hash, write_diagnostics, write_rotors, write_run};
#[cfg(feature = "mcap")]
pub use scan::{Damage, check};
pub use state::{state_schema, write_state};
pub use time::nanoseconds;

use std::{collections::BTreeMap, path::PathBuf};

/// A channel of a sink, handed out by [`LogSink::channel`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ChannelId(u32);

impl ChannelId {
    /// For implementations of [`LogSink`]: a number of their own choice.
    pub fn new(index: u32) -> Self {
        Self(index)
    }

    /// The number given by the sink.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// Where a log goes.
pub trait LogSink: Send {
    /// Opens a channel whose messages are JSON objects that obey `schema`.
    ///
    /// # Errors
    /// [`LogError`] if the topic is taken or the sink cannot write.
    fn channel(
        &mut self,
        topic: &str,
        schema_name: &str,
        schema: &serde_json::Value,
    ) -> Result<ChannelId, LogError>;

    /// Opens a channel whose messages are of a Protocol Buffers type: its full name, and the serialized
    /// `google.protobuf.FileDescriptorSet` of the files that define it.
    ///
    /// # Errors
    /// [`LogError`] if the topic is taken or the sink cannot write.
    fn protobuf_channel(
        &mut self,
        topic: &str,
        type_name: &str,
        descriptors: &[u8],
    ) -> Result<ChannelId, LogError>;

    /// Writes one message at `time` in s: JSON text or a serialized message, as its channel has it.
    ///
    /// # Errors
    /// [`LogError`] if the time is negative or not finite, the channel is not the sink's, or it cannot write.
    fn write(&mut self, channel: ChannelId, time: f64, message: &[u8]) -> Result<(), LogError>;

    /// Begins a message at `time` in s that takes values instead of text: for sinks that keep numbers. A message ends
    /// where the next begins. `None`, as from most: [`write`](Self::write) text.
    ///
    /// # Errors
    /// As [`write`](Self::write).
    fn fields(
        &mut self,
        _channel: ChannelId,
        _time: f64,
    ) -> Result<Option<&mut dyn Fields>, LogError> {
        Ok(None)
    }

    /// Writes a table of texts about the log as a whole.
    ///
    /// # Errors
    /// [`LogError`] if the sink cannot write.
    fn metadata(&mut self, name: &str, table: &BTreeMap<String, String>) -> Result<(), LogError>;

    /// Keeps a file beside the messages.
    ///
    /// # Errors
    /// [`LogError`] if the sink cannot write.
    fn attach(&mut self, name: &str, media_type: &str, data: &[u8]) -> Result<(), LogError>;

    /// Completes the log. Nothing can be written after.
    ///
    /// # Errors
    /// [`LogError`] if the sink cannot write.
    fn finish(&mut self) -> Result<(), LogError>;
}

/// Why something could not be logged.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LogError {
    /// The file cannot be made.
    #[error("log {}: cannot be created: {source}", path.display())]
    Create {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// Another run writes it.
    #[error(
        "log {}: another run is writing it: {by}; wait for it, end it, or write somewhere else",
        path.display()
    )]
    Taken {
        /// What both would write.
        path: PathBuf,
        /// Process, start and command of the other run.
        by: String,
    },
    /// A file cannot be read.
    #[error("log {}: cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The file cannot be written on.
    #[error(
        "log {}: cannot be written: {source}; make room, or write to another folder",
        path.display()
    )]
    File {
        /// The file.
        path: PathBuf,
        /// Why.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// The sink cannot write.
    #[error("log: {0}")]
    Write(#[source] Box<dyn std::error::Error + Send + Sync>),
    /// A topic is opened twice.
    #[error("log: topic `{0}` is open already; give each channel a topic of its own")]
    Topic(String),
    /// A channel of another sink.
    #[error("log: channel {} is not of this sink", .0.index())]
    Channel(ChannelId),
    /// A time that a log cannot have.
    #[error("log: time {0} s is negative or not finite")]
    Time(f64),
    /// A message is not JSON.
    #[error("log: message is not JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// The log has been completed.
    #[error("log: is finished, nothing more can be written")]
    Finished,
}
