//! A log that keeps nothing: it hands on what is written.

use std::collections::BTreeMap;

use wbqp::serde_json::Value;
use wbqp_log::{ChannelId, LogError, LogSink};

/// Calls a function with topic, time in s and contents of every message.
#[derive(Debug)]
pub struct Listener<F> {
    topics: Vec<String>,
    listen: F,
}

impl<F: FnMut(&str, f64, &[u8]) -> Result<(), LogError>> Listener<F> {
    /// Without a channel yet.
    pub fn new(listen: F) -> Self {
        Self {
            topics: Vec::new(),
            listen,
        }
    }
}

impl<F: FnMut(&str, f64, &[u8]) -> Result<(), LogError> + Send> LogSink for Listener<F> {
    fn channel(&mut self, topic: &str, _: &str, _: &Value) -> Result<ChannelId, LogError> {
        self.topics.push(topic.to_owned());
        Ok(ChannelId::new(self.topics.len() as u32 - 1))
    }

    fn protobuf_channel(&mut self, topic: &str, _: &str, _: &[u8]) -> Result<ChannelId, LogError> {
        self.channel(topic, "", &Value::Null)
    }

    fn write(&mut self, channel: ChannelId, time: f64, message: &[u8]) -> Result<(), LogError> {
        let topic = self.topics.get(channel.index());
        (self.listen)(topic.ok_or(LogError::Channel(channel))?, time, message)
    }

    fn metadata(&mut self, _: &str, _: &BTreeMap<String, String>) -> Result<(), LogError> {
        Ok(())
    }

    fn attach(&mut self, _: &str, _: &str, _: &[u8]) -> Result<(), LogError> {
        Ok(())
    }

    fn finish(&mut self) -> Result<(), LogError> {
        Ok(())
    }
}
