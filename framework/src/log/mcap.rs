//! MCAP files: an open container that Foxglove, PlotJuggler and libraries of many languages read.

use std::{
    borrow::Cow,
    collections::BTreeMap,
    fmt,
    fs::File,
    io::{BufWriter, Seek, Write},
    path::Path,
};

use mcap::{Attachment, Compression, McapError, WriteOptions, Writer, records};
use serde_json::Value;

use super::{ChannelId, LogError, LogSink};

/// A sink that writes an MCAP file: JSON messages, jsonschema schemas, zstd chunks. Log time is the message's time in
/// ns.
///
/// A file that is dropped without [`LogSink::finish`] is still completed, but an error then is lost.
pub struct McapLog<W: Write + Seek + Send = BufWriter<File>> {
    /// Gone once the log is finished.
    writer: Option<Writer<W>>,
    channels: Vec<Channel>,
}

struct Channel {
    topic: String,
    id: u16,
    sequence: u32,
}

impl McapLog {
    /// Makes the file, and its directory if there is none.
    ///
    /// # Errors
    /// [`LogError::Create`].
    pub fn create(path: &Path) -> Result<Self, LogError> {
        let create = || {
            if let Some(directory) = path.parent() {
                std::fs::create_dir_all(directory)?;
            }
            File::create(path)
        };
        let file = create().map_err(|source| LogError::Create {
            path: path.to_owned(),
            source,
        })?;
        Self::new(BufWriter::new(file))
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
            .library(concat!("wbqp ", env!("CARGO_PKG_VERSION")));
        Ok(Self {
            writer: Some(options.create(output).map_err(failed)?),
            channels: Vec::new(),
        })
    }

    fn writer(&mut self) -> Result<&mut Writer<W>, LogError> {
        self.writer.as_mut().ok_or(LogError::Finished)
    }
}

fn failed(error: McapError) -> LogError {
    LogError::Write(Box::new(error))
}

impl<W: Write + Seek + Send> LogSink for McapLog<W> {
    fn channel(
        &mut self,
        topic: &str,
        schema_name: &str,
        schema: &Value,
    ) -> Result<ChannelId, LogError> {
        if self.channels.iter().any(|c| c.topic == topic) {
            return Err(LogError::Topic(topic.to_owned()));
        }
        let schema = serde_json::to_vec(schema)?;
        let writer = self.writer()?;
        let schema = writer
            .add_schema(schema_name, "jsonschema", &schema)
            .map_err(failed)?;
        let id = writer
            .add_channel(schema, topic, "json", &BTreeMap::new())
            .map_err(failed)?;
        self.channels.push(Channel {
            topic: topic.to_owned(),
            id,
            sequence: 0,
        });
        Ok(ChannelId::new(self.channels.len() as u32 - 1))
    }

    fn write(&mut self, channel: ChannelId, time: f64, message: &[u8]) -> Result<(), LogError> {
        if !(time.is_finite() && time >= 0.0) {
            return Err(LogError::Time(time));
        }
        let writer = self.writer.as_mut().ok_or(LogError::Finished)?;
        let entry = self
            .channels
            .get_mut(channel.index())
            .ok_or(LogError::Channel(channel))?;
        let nanoseconds = (time * 1e9).round() as u64;
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
    }

    fn metadata(&mut self, name: &str, table: &BTreeMap<String, String>) -> Result<(), LogError> {
        let metadata = records::Metadata {
            name: name.to_owned(),
            metadata: table.clone(),
        };
        self.writer()?.write_metadata(&metadata).map_err(failed)
    }

    fn attach(&mut self, name: &str, media_type: &str, data: &[u8]) -> Result<(), LogError> {
        let attachment = Attachment {
            log_time: 0,
            create_time: 0,
            name: name.to_owned(),
            media_type: media_type.to_owned(),
            data: Cow::Borrowed(data),
        };
        self.writer()?.attach(&attachment).map_err(failed)
    }

    fn finish(&mut self) -> Result<(), LogError> {
        let mut writer = self.writer.take().ok_or(LogError::Finished)?;
        writer.finish().map_err(failed)?;
        let flushed = writer.into_inner().flush();
        flushed.map_err(|error| LogError::Write(Box::new(error)))
    }
}

impl<W: Write + Seek + Send> fmt::Debug for McapLog<W> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("McapLog")
            .field("channels", &self.channels.len())
            .field("finished", &self.writer.is_none())
            .finish()
    }
}
