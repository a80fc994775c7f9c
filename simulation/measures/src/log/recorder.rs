//! A log that never was a file.

use std::{collections::BTreeMap, sync::Arc};

use serde_json::Value;
use wbqp_log::{ChannelId, LogError, LogSink, nanoseconds};

use super::{Log, Messages};
use crate::header::Header;

/// Keeps what a run writes in JSON, to be read without a file. What is read is what an MCAP file would give.
#[derive(Debug, Default)]
pub struct Recorder {
    topics: Vec<(String, Messages)>,
    schemas: BTreeMap<String, Value>,
    header: Header,
}

impl Recorder {
    /// What was written.
    pub fn into_log(self) -> Log {
        let written = self.topics.into_iter().filter(|(_, m)| !m.is_empty());
        Log {
            topics: written.map(|(t, m)| (t, Arc::new(m))).collect(),
            schemas: self.schemas,
            header: self.header,
        }
    }
}

impl LogSink for Recorder {
    fn channel(&mut self, topic: &str, _: &str, schema: &Value) -> Result<ChannelId, LogError> {
        if self.topics.iter().any(|(t, _)| t == topic) {
            return Err(LogError::Topic(topic.to_owned()));
        }
        self.topics.push((topic.to_owned(), Vec::new()));
        self.schemas.insert(topic.to_owned(), schema.clone());
        Ok(ChannelId::new(self.topics.len() as u32 - 1))
    }

    fn protobuf_channel(&mut self, topic: &str, _: &str, _: &[u8]) -> Result<ChannelId, LogError> {
        let channel = self.channel(topic, "", &Value::Null)?;
        self.schemas.remove(topic);
        Ok(channel)
    }

    fn write(&mut self, channel: ChannelId, time: f64, message: &[u8]) -> Result<(), LogError> {
        let nanoseconds = nanoseconds(time)?;
        let topic = self.topics.get_mut(channel.index());
        let (topic, messages) = topic.ok_or(LogError::Channel(channel))?;
        if !self.schemas.contains_key(topic) {
            return Ok(());
        }
        messages.push((nanoseconds as f64 * 1e-9, message.to_owned()));
        Ok(())
    }

    fn metadata(&mut self, name: &str, table: &BTreeMap<String, String>) -> Result<(), LogError> {
        self.header.metadata.insert(name.to_owned(), table.clone());
        Ok(())
    }

    fn attach(&mut self, name: &str, _: &str, data: &[u8]) -> Result<(), LogError> {
        self.header
            .attachments
            .insert(name.to_owned(), data.to_owned());
        Ok(())
    }

    fn finish(&mut self) -> Result<(), LogError> {
        Ok(())
    }
}
