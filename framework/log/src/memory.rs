//! A log in memory, for tests.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::{ChannelId, LogError, LogSink, nanoseconds};

/// A log in memory: everything is public, and what is JSON is parsed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MemoryLog {
    /// Topic, schema name and schema of each channel.
    pub channels: Vec<(String, String, Value)>,
    /// Channel, time in s and contents of each message, in the order written.
    pub messages: Vec<(ChannelId, f64, Value)>,
    /// Channel, time in s and contents of each message of Protocol Buffers; the schema of such a channel is its type's
    /// name alone.
    pub protobuf: Vec<(ChannelId, f64, Vec<u8>)>,
    /// Metadata tables by name.
    pub metadata: BTreeMap<String, BTreeMap<String, String>>,
    /// Media type and contents of the attachments by name.
    pub attachments: BTreeMap<String, (String, Vec<u8>)>,
    /// Whether the log is complete.
    pub finished: bool,
}

impl MemoryLog {
    /// Times (s) and contents of a topic's messages.
    pub fn messages(&self, topic: &str) -> impl Iterator<Item = (f64, &Value)> {
        let channel = self.channels.iter().position(|c| c.0 == topic);
        self.messages
            .iter()
            .filter(move |(id, ..)| Some(id.index()) == channel)
            .map(|(_, time, message)| (*time, message))
    }

    fn open(&self) -> Result<(), LogError> {
        if self.finished {
            return Err(LogError::Finished);
        }
        Ok(())
    }
}

impl LogSink for MemoryLog {
    fn channel(
        &mut self,
        topic: &str,
        schema_name: &str,
        schema: &Value,
    ) -> Result<ChannelId, LogError> {
        self.open()?;
        if self.channels.iter().any(|c| c.0 == topic) {
            return Err(LogError::Topic(topic.to_owned()));
        }
        let channel = (topic.to_owned(), schema_name.to_owned(), schema.clone());
        self.channels.push(channel);
        Ok(ChannelId::new(self.channels.len() as u32 - 1))
    }

    fn protobuf_channel(
        &mut self,
        topic: &str,
        type_name: &str,
        _: &[u8],
    ) -> Result<ChannelId, LogError> {
        self.channel(topic, type_name, &Value::Null)
    }

    fn write(&mut self, channel: ChannelId, time: f64, message: &[u8]) -> Result<(), LogError> {
        self.open()?;
        let opened = self.channels.get(channel.index());
        let (_, _, schema) = opened.ok_or(LogError::Channel(channel))?;
        nanoseconds(time)?;
        if schema.is_null() {
            self.protobuf.push((channel, time, message.to_owned()));
            return Ok(());
        }
        let message = serde_json::from_slice(message)?;
        self.messages.push((channel, time, message));
        Ok(())
    }

    fn metadata(&mut self, name: &str, table: &BTreeMap<String, String>) -> Result<(), LogError> {
        self.open()?;
        self.metadata.insert(name.to_owned(), table.clone());
        Ok(())
    }

    fn attach(&mut self, name: &str, media_type: &str, data: &[u8]) -> Result<(), LogError> {
        self.open()?;
        let attachment = (media_type.to_owned(), data.to_vec());
        self.attachments.insert(name.to_owned(), attachment);
        Ok(())
    }

    fn finish(&mut self) -> Result<(), LogError> {
        self.open()?;
        self.finished = true;
        Ok(())
    }
}
