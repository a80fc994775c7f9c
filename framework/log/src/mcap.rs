//! MCAP files: an open container that Foxglove, PlotJuggler and libraries of many languages read.

use std::{
    borrow::Cow,
    collections::BTreeMap,
    fmt,
    fs::{self, File},
    io::{self, BufWriter, Seek, Write},
    path::{Path, PathBuf},
};

use mcap::{Attachment, Compression, McapError, WriteOptions, Writer, records};
use serde_json::Value;

use crate::{ChannelId, LogError, LogSink, RunLock, nanoseconds};

/// A sink that writes an MCAP file: messages in JSON or Protocol Buffers with their schemas, zstd chunks. Log time is
/// the message's time in ns.
///
/// A file that is dropped without [`LogSink::finish`] is still completed, but an error then is lost.
pub struct McapLog<W: Write + Seek + Send = BufWriter<File>> {
    /// Gone once the log is finished.
    writer: Option<Writer<W>>,
    channels: Vec<Channel>,
    /// When the chunk began that is being written, ns.
    chunk: Option<u64>,
    /// Of the file, if it is one.
    path: Option<PathBuf>,
    _lock: Option<RunLock>,
}

/// The longest time that the messages of a chunk span, ns. What a run that is killed has not written yet is at most
/// this, and what is in memory.
const CHUNK: u64 = 500_000_000;

/// Level of zstd: 12 makes chunks 0.4 % smaller, in a fifth more time; 9 makes them 0.8 % larger.
const COMPRESSION: u32 = 10;

struct Channel {
    topic: String,
    id: u16,
    sequence: u32,
}

impl McapLog {
    /// Makes the file, and its directory if there is none. Nobody else can until this is dropped: another run, of this
    /// process or another, is refused ([`RunLock`]).
    ///
    /// # Errors
    /// [`LogError::Create`]; [`LogError::Taken`] if another run writes it.
    pub fn create(path: &Path) -> Result<Self, LogError> {
        Self::create_locked(path, RunLock::take(path)?)
    }

    /// Like [`McapLog::create`] with the lock of this path, for who has something to do between.
    ///
    /// # Errors
    /// [`LogError::Create`].
    pub fn create_locked(path: &Path, lock: RunLock) -> Result<Self, LogError> {
        let failed = |source| LogError::Create {
            path: path.to_owned(),
            source,
        };
        // Whoever opens a pipe that nobody reads waits for ever.
        if fs::metadata(path).is_ok_and(|found| !found.is_file()) {
            return Err(failed(io::Error::other("is there, and no file")));
        }
        let file = File::create(path).map_err(failed)?;
        let log = Self::new(BufWriter::new(file)).map_err(|error| at(path, error))?;
        Ok(Self {
            path: Some(path.to_owned()),
            _lock: Some(lock),
            ..log
        })
    }
}

impl<W: Write + Seek + Send> McapLog<W> {
    /// Writes to anything that can seek.
    ///
    /// # Errors
    /// [`LogError::Write`].
    pub fn new(output: W) -> Result<Self, LogError> {
        let options = WriteOptions::new()
            .compression(Some(Compression::Zstd))
            .compression_level(COMPRESSION)
            .library(concat!("wbqp ", env!("CARGO_PKG_VERSION")));
        Ok(Self {
            writer: Some(options.create(output).map_err(failed)?),
            channels: Vec::new(),
            chunk: None,
            path: None,
            _lock: None,
        })
    }

    /// Opens a channel of another file; gives its id here. The schema is its name, encoding and text.
    pub(super) fn copy_channel(
        &mut self,
        channel: &records::Channel,
        schema: Option<(&str, &str, &[u8])>,
    ) -> Result<u16, LogError> {
        self.named(|log| {
            let writer = log.writer()?;
            let schema = match schema {
                Some((name, encoding, text)) => {
                    writer.add_schema(name, encoding, text).map_err(failed)?
                }
                None => 0,
            };
            let (topic, encoding) = (&channel.topic, &channel.message_encoding);
            let id = writer.add_channel(schema, topic, encoding, &channel.metadata);
            id.map_err(failed)
        })
    }

    /// Writes a message of another file; the header has the channel's id here.
    pub(super) fn copy_message(
        &mut self,
        header: &records::MessageHeader,
        data: &[u8],
    ) -> Result<(), LogError> {
        self.named(|log| {
            log.begin_chunk(header.log_time)?;
            let writer = log.writer()?;
            writer.write_to_known_channel(header, data).map_err(failed)
        })
    }

    /// Encodings are those of schema and messages.
    fn open_channel(
        &mut self,
        topic: &str,
        schema_name: &str,
        (schema_encoding, encoding): (&str, &str),
        schema: &[u8],
    ) -> Result<ChannelId, LogError> {
        self.named(|log| {
            if log.channels.iter().any(|c| c.topic == topic) {
                return Err(LogError::Topic(topic.to_owned()));
            }
            let writer = log.writer()?;
            let schema = writer.add_schema(schema_name, schema_encoding, schema);
            let schema = schema.map_err(failed)?;
            let id = writer.add_channel(schema, topic, encoding, &BTreeMap::new());
            log.channels.push(Channel {
                topic: topic.to_owned(),
                id: id.map_err(failed)?,
                sequence: 0,
            });
            Ok(ChannelId::new(log.channels.len() as u32 - 1))
        })
    }

    /// Ends the chunk if a message at this time, ns, would make it too long.
    fn begin_chunk(&mut self, time: u64) -> Result<(), LogError> {
        let is_full = |begin: &u64| time.abs_diff(*begin) >= CHUNK;
        if self.chunk.as_ref().is_some_and(is_full) {
            self.writer()?.flush().map_err(failed)?;
            self.chunk = None;
        }
        self.chunk.get_or_insert(time);
        Ok(())
    }

    /// Does something whose errors name the file.
    fn named<T>(
        &mut self,
        act: impl FnOnce(&mut Self) -> Result<T, LogError>,
    ) -> Result<T, LogError> {
        act(self).map_err(|error| match &self.path {
            Some(path) => at(path, error),
            None => error,
        })
    }

    fn writer(&mut self) -> Result<&mut Writer<W>, LogError> {
        self.writer.as_mut().ok_or(LogError::Finished)
    }
}

fn failed(error: McapError) -> LogError {
    LogError::Write(match error {
        // Its own words are not the system's.
        McapError::Io(error) => Box::new(error),
        error => Box::new(error),
    })
}

/// The same error with the file's name.
fn at(path: &Path, error: LogError) -> LogError {
    match error {
        LogError::Write(source) => LogError::File {
            path: path.to_owned(),
            source,
        },
        error => error,
    }
}

impl<W: Write + Seek + Send> LogSink for McapLog<W> {
    fn channel(
        &mut self,
        topic: &str,
        schema_name: &str,
        schema: &Value,
    ) -> Result<ChannelId, LogError> {
        let schema = serde_json::to_vec(schema)?;
        self.open_channel(topic, schema_name, ("jsonschema", "json"), &schema)
    }

    fn protobuf_channel(
        &mut self,
        topic: &str,
        type_name: &str,
        descriptors: &[u8],
    ) -> Result<ChannelId, LogError> {
        self.open_channel(topic, type_name, ("protobuf", "protobuf"), descriptors)
    }

    fn write(&mut self, channel: ChannelId, time: f64, message: &[u8]) -> Result<(), LogError> {
        self.named(|log| {
            let nanoseconds = nanoseconds(time)?;
            log.begin_chunk(nanoseconds)?;
            let writer = log.writer.as_mut().ok_or(LogError::Finished)?;
            let entry = log
                .channels
                .get_mut(channel.index())
                .ok_or(LogError::Channel(channel))?;
            let header = records::MessageHeader {
                channel_id: entry.id,
                sequence: entry.sequence,
                log_time: nanoseconds,
                publish_time: nanoseconds,
            };
            entry.sequence = entry.sequence.wrapping_add(1);
            writer
                .write_to_known_channel(&header, message)
                .map_err(failed)
        })
    }

    fn metadata(&mut self, name: &str, table: &BTreeMap<String, String>) -> Result<(), LogError> {
        self.named(|log| {
            let metadata = records::Metadata {
                name: name.to_owned(),
                metadata: table.clone(),
            };
            log.writer()?.write_metadata(&metadata).map_err(failed)
        })
    }

    fn attach(&mut self, name: &str, media_type: &str, data: &[u8]) -> Result<(), LogError> {
        self.named(|log| {
            let attachment = Attachment {
                log_time: 0,
                create_time: 0,
                name: name.to_owned(),
                media_type: media_type.to_owned(),
                data: Cow::Borrowed(data),
            };
            log.writer()?.attach(&attachment).map_err(failed)
        })
    }

    fn finish(&mut self) -> Result<(), LogError> {
        self.named(|log| {
            let mut writer = log.writer.take().ok_or(LogError::Finished)?;
            writer.finish().map_err(failed)?;
            let flushed = writer.into_inner().flush();
            flushed.map_err(|error| LogError::Write(Box::new(error)))
        })
    }
}

impl<W: Write + Seek + Send> fmt::Debug for McapLog<W> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("McapLog")
            .field("channels", &self.channels.len())
            .field("finished", &self.writer.is_none())
            .finish_non_exhaustive()
    }
}
