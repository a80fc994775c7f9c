//! A run's numbers, taken while it goes on.

use std::{
    cell::Cell,
    collections::{BTreeMap, BTreeSet},
    fmt::Display,
};

use serde_json::Value;
use wbqp_log::{ChannelId, Fields, LogError, LogSink, nanoseconds};

use crate::{MeasureError, Recording, RotorLimits, Series, escaped, header::Header};

/// A sink that keeps the numbers of a run in columns: no text, and no allocation for a message once each of a topic's
/// fields was there, up to the number of messages that it was made for. What measures read from it is what they read
/// from the run's log file, with all digits instead of the file's; texts and lists are not kept.
#[derive(Debug, Default)]
pub struct Columns {
    topics: Vec<Topic>,
    header: Header,
    /// Times at which anything came, of topics that are not kept too.
    times: Vec<f64>,
    /// Messages of a topic for which there is room from the start.
    capacity: usize,
    /// The topics that are kept; all if nothing is said.
    kept: Option<BTreeSet<String>>,
    /// Takes messages of no use.
    nowhere: Nowhere,
}

/// The messages of a channel.
#[derive(Debug, Default)]
struct Topic {
    name: String,
    is_kept: bool,
    /// Whether somebody has asked for it.
    is_asked: Cell<bool>,
    times: Vec<f64>,
    /// Objects and numbers in the order in which the first message had them: what is inside an object follows it.
    nodes: Vec<Node>,
    /// The object that is open; none: the message itself.
    open: Option<usize>,
    /// The node that comes next if this message is like the last.
    next: usize,
    capacity: usize,
}

#[derive(Debug)]
struct Node {
    name: String,
    /// The object that it is in.
    parent: Option<usize>,
    /// Empty for an object; shorter than the times where the last messages did not have it.
    values: Vec<f64>,
    is_object: bool,
}

impl Columns {
    /// Nothing yet, with room for so many messages of each topic.
    pub fn with_capacity(messages: usize) -> Self {
        Self {
            capacity: messages,
            times: Vec::with_capacity(messages),
            ..Self::default()
        }
    }

    /// The times at which anything came, s, ascending: those of all ticks, also where a topic that is asked for, or
    /// that is kept, has no message.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Keeps these topics alone.
    pub fn of_topics(mut self, topics: BTreeSet<String>) -> Self {
        self.kept = Some(topics);
        self
    }

    /// The topics that somebody has asked for so far.
    pub fn asked(&self) -> BTreeSet<String> {
        let asked = self.topics.iter().filter(|topic| topic.is_asked.get());
        asked.map(|topic| topic.name.clone()).collect()
    }

    fn topic(&self, topic: &str) -> Result<&Topic, MeasureError> {
        let written = || self.topics.iter().filter(|t| !t.times.is_empty());
        let found = written().find(|t| t.name == topic);
        let found = found.inspect(|topic| topic.is_asked.set(true));
        found.ok_or_else(|| MeasureError::Topic {
            topic: topic.to_owned(),
            known: written()
                .map(|t| t.name.as_str())
                .collect::<Vec<_>>()
                .join(", "),
        })
    }

    fn open(&mut self, topic: &str, is_kept: bool) -> Result<ChannelId, LogError> {
        if self.topics.iter().any(|t| t.name == topic) {
            return Err(LogError::Topic(topic.to_owned()));
        }
        let is_kept = is_kept && self.kept.as_ref().is_none_or(|kept| kept.contains(topic));
        self.topics.push(Topic {
            name: topic.to_owned(),
            is_kept,
            times: Vec::with_capacity(if is_kept { self.capacity } else { 0 }),
            capacity: self.capacity,
            ..Topic::default()
        });
        Ok(ChannelId::new(self.topics.len() as u32 - 1))
    }

    fn begin(&mut self, channel: ChannelId, time: f64) -> Result<&mut dyn Fields, LogError> {
        // As files have them.
        let time = nanoseconds(time)? as f64 * 1e-9;
        let topic = self.topics.get_mut(channel.index());
        let topic = topic.ok_or(LogError::Channel(channel))?;
        if self.times.last().is_none_or(|last| *last < time) {
            self.times.push(time);
        }
        if !topic.is_kept {
            return Ok(&mut self.nowhere);
        }
        topic.times.push(time);
        (topic.open, topic.next) = (None, 0);
        Ok(topic)
    }
}

impl Topic {
    /// The node of that name in the open object.
    fn node(&mut self, name: &str, is_object: bool) -> usize {
        let open = self.open;
        let is_it =
            |node: &Node| node.parent == open && node.is_object == is_object && node.name == name;
        let index = match self.nodes.get(self.next) {
            Some(node) if is_it(node) => self.next,
            _ => self.nodes.iter().position(is_it).unwrap_or_else(|| {
                let room = if is_object { 0 } else { self.capacity };
                self.nodes.push(Node {
                    name: name.to_owned(),
                    parent: open,
                    values: Vec::with_capacity(room.max(self.times.len())),
                    is_object,
                });
                self.nodes.len() - 1
            }),
        };
        self.next = index + 1;
        index
    }

    fn push(&mut self, name: &str, value: f64) {
        let index = self.node(name, false);
        let values = &mut self.nodes[index].values;
        values.resize(self.times.len().saturating_sub(1), f64::NAN);
        values.push(value);
    }

    /// What a JSON pointer names.
    fn find(&self, pointer: &str) -> Option<usize> {
        let mut path = pointer.split('/').skip(1).peekable();
        let mut parent = None;
        while let Some(name) = path.next() {
            let is_last = path.peek().is_none();
            let is_it = |node: &Node| node.parent == parent && escaped(&node.name) == name;
            let found = self.nodes.iter().position(is_it)?;
            if is_last {
                return Some(found);
            }
            parent = Some(found);
        }
        None
    }

    fn series(&self, pointer: &str) -> Series {
        let values = self.find(pointer).map(|i| self.nodes[i].values.as_slice());
        let mut y = values.unwrap_or_default().to_vec();
        y.resize(self.times.len(), f64::NAN);
        Series {
            t: self.times.clone(),
            y,
        }
    }
}

impl Fields for Topic {
    fn number(&mut self, name: &str, value: f64) {
        self.exact_number(name, value);
    }

    fn rounded_number(&mut self, name: &str, value: f64, _: usize) {
        self.exact_number(name, value);
    }

    fn exact_number(&mut self, name: &str, value: f64) {
        // What is not finite is not in a file either.
        self.push(name, if value.is_finite() { value } else { f64::NAN });
    }

    fn integer(&mut self, name: &str, value: u64) {
        self.push(name, value as f64);
    }

    fn boolean(&mut self, name: &str, value: bool) {
        self.push(name, f64::from(u8::from(value)));
    }

    fn display(&mut self, _: &str, _: &dyn Display) {}

    fn begin(&mut self, name: &str) {
        self.open = Some(self.node(name, true));
    }

    fn end(&mut self) {
        self.open = self.open.and_then(|open| self.nodes[open].parent);
    }

    fn begin_list(&mut self, _: &str) -> bool {
        false
    }

    fn begin_item(&mut self) {}

    fn end_list(&mut self) {}
}

/// Takes everything and keeps nothing.
#[derive(Debug, Default)]
struct Nowhere;

impl Fields for Nowhere {
    fn number(&mut self, _: &str, _: f64) {}
    fn rounded_number(&mut self, _: &str, _: f64, _: usize) {}
    fn exact_number(&mut self, _: &str, _: f64) {}
    fn integer(&mut self, _: &str, _: u64) {}
    fn boolean(&mut self, _: &str, _: bool) {}
    fn display(&mut self, _: &str, _: &dyn Display) {}
    fn begin(&mut self, _: &str) {}
    fn end(&mut self) {}
    fn begin_list(&mut self, _: &str) -> bool {
        false
    }
    fn begin_item(&mut self) {}
    fn end_list(&mut self) {}
}

impl LogSink for Columns {
    fn channel(&mut self, topic: &str, _: &str, _: &Value) -> Result<ChannelId, LogError> {
        self.open(topic, true)
    }

    fn protobuf_channel(&mut self, topic: &str, _: &str, _: &[u8]) -> Result<ChannelId, LogError> {
        self.open(topic, false)
    }

    fn fields(
        &mut self,
        channel: ChannelId,
        time: f64,
    ) -> Result<Option<&mut dyn Fields>, LogError> {
        self.begin(channel, time).map(Some)
    }

    fn write(&mut self, channel: ChannelId, time: f64, message: &[u8]) -> Result<(), LogError> {
        let is_kept = self.topics.get(channel.index()).is_some_and(|t| t.is_kept);
        let fields = self.begin(channel, time)?;
        if is_kept {
            fill(fields, &serde_json::from_slice(message)?);
        }
        Ok(())
    }

    fn metadata(&mut self, name: &str, table: &BTreeMap<String, String>) -> Result<(), LogError> {
        self.header.metadata.insert(name.to_owned(), table.clone());
        Ok(())
    }

    fn attach(&mut self, name: &str, _: &str, data: &[u8]) -> Result<(), LogError> {
        let data = data.to_owned();
        self.header.attachments.insert(name.to_owned(), data);
        Ok(())
    }

    fn finish(&mut self) -> Result<(), LogError> {
        Ok(())
    }
}

/// The numbers of a message that came as text.
fn fill(fields: &mut dyn Fields, message: &Value) {
    for (name, value) in message.as_object().into_iter().flatten() {
        match value {
            Value::Bool(value) => fields.boolean(name, *value),
            Value::Number(value) => fields.exact_number(name, value.as_f64().unwrap_or(f64::NAN)),
            Value::Object(_) => fields.object(name, |fields| fill(fields, value)),
            Value::Null | Value::String(_) | Value::Array(_) => {}
        }
    }
}

impl Recording for Columns {
    fn has(&self, topic: &str) -> bool {
        self.topic(topic).is_ok()
    }

    fn columns(&self, topic: &str, fields: &[String]) -> Result<Vec<Series>, MeasureError> {
        let topic = self.topic(topic)?;
        Ok(fields.iter().map(|field| topic.series(field)).collect())
    }

    fn names(&self, topic: &str, object: &str) -> Result<Vec<String>, MeasureError> {
        let topic = self.topic(topic)?;
        let Some(object) = topic.find(object) else {
            return Ok(Vec::new());
        };
        let inside = topic.nodes.iter().filter(|n| n.parent == Some(object));
        let mut names: Vec<String> = inside.map(|node| node.name.clone()).collect();
        names.sort_unstable();
        Ok(names)
    }

    fn end(&self) -> f64 {
        let last = self.topics.iter().filter_map(|topic| topic.times.last());
        last.copied().fold(0.0, f64::max)
    }

    fn mark(&self, name: &str) -> Result<f64, MeasureError> {
        self.header.mark(name)
    }

    fn rotors(&self) -> Result<Vec<RotorLimits>, MeasureError> {
        self.header.rotors()
    }

    fn configuration(&self, key: &str) -> Result<toml::Table, MeasureError> {
        self.header.configuration(key)
    }
}
