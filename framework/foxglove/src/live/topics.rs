//! A server's topics as a log that is written to.

use std::{collections::BTreeMap, sync::Arc};

use foxglove::{Context, PartialMetadata, RawChannel, Schema};
use wbqp::serde_json::{self, Value};
use wbqp_log::{ChannelId, LogError, LogSink, nanoseconds};

/// Topics of a context, which servers hand on. Metadata and attachments, which live views have no place for, are left
/// out.
pub(super) struct Topics {
    context: Arc<Context>,
    channels: Vec<Arc<RawChannel>>,
}

impl Topics {
    pub(super) fn new(context: &Arc<Context>) -> Self {
        Self {
            context: Arc::clone(context),
            channels: Vec::new(),
        }
    }

    fn open(&mut self, topic: &str, schema: Schema, encoding: &str) -> Result<ChannelId, LogError> {
        if self.channels.iter().any(|channel| channel.topic() == topic) {
            return Err(LogError::Topic(topic.to_owned()));
        }
        let channel = self.context.channel_builder(topic);
        let channel = channel.schema(schema).message_encoding(encoding);
        let channel = channel.build_raw();
        self.channels
            .push(channel.map_err(|error| LogError::Write(Box::new(error)))?);
        Ok(ChannelId::new(self.channels.len() as u32 - 1))
    }
}

impl LogSink for Topics {
    fn channel(&mut self, topic: &str, name: &str, schema: &Value) -> Result<ChannelId, LogError> {
        let schema = Schema::new(name, "jsonschema", serde_json::to_vec(schema)?);
        self.open(topic, schema, "json")
    }

    fn protobuf_channel(
        &mut self,
        topic: &str,
        type_name: &str,
        descriptors: &[u8],
    ) -> Result<ChannelId, LogError> {
        let schema = Schema::new(type_name, "protobuf", descriptors.to_vec());
        self.open(topic, schema, "protobuf")
    }

    fn write(&mut self, channel: ChannelId, time: f64, message: &[u8]) -> Result<(), LogError> {
        let log_time = Some(nanoseconds(time)?);
        let known = self.channels.get(channel.index());
        let known = known.ok_or(LogError::Channel(channel))?;
        known.log_with_meta(message, PartialMetadata { log_time });
        Ok(())
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
