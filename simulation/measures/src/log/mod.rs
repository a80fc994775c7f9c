//! Reads logs back: figures and tables are made from the file, not from the simulator's memory.

mod contents;
mod fields;
mod recorder;

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    sync::Arc,
};

use mcap::{McapError, MessageStream, read::LinearReader, records::Record};
use serde_json::Value;
use wbqp::input;
use wbqp_log::{Damage, Timeline};

use self::fields::Fields;
use crate::{MeasureError, Recording, RotorLimits, Series, Signals, header::Header};

pub use contents::Contents;
pub use recorder::Recorder;

/// Times, s, and texts of a topic's messages.
type Messages = Vec<(f64, Vec<u8>)>;

/// A log in memory: the text of each message in JSON by topic, schemas, metadata and attachments. Clones share the
/// messages.
#[derive(Clone, Debug, Default)]
pub struct Log {
    topics: BTreeMap<String, Arc<Messages>>,
    schemas: BTreeMap<String, Value>,
    header: Header,
}

/// Why a file could not be read as a log.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The file cannot be read.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// The file is not an MCAP file, or damaged.
    #[error("not a complete MCAP file: {0}")]
    Mcap(#[from] McapError),
    /// The file is cut, or not what was written.
    #[error("not a complete MCAP file: {0}{remedy}", remedy = remedy(.0))]
    Damaged(#[from] Damage),
}

/// Of what does not begin like a log there is nothing to save.
fn remedy(damage: &Damage) -> &'static str {
    match damage.at {
        0 => "",
        _ => "; `wbqp log repair` saves what is intact",
    }
}

impl Log {
    /// Reads a file.
    ///
    /// # Errors
    /// [`ReadError::File`], [`ReadError::Damaged`] or [`ReadError::Mcap`].
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        Self::from_bytes(&read(path)?)
    }

    /// Reads metadata and attachments of a file, not its messages.
    ///
    /// # Errors
    /// [`ReadError::File`], [`ReadError::Damaged`] or [`ReadError::Mcap`].
    pub fn open_header(path: &Path) -> Result<Self, ReadError> {
        let bytes = read(path)?;
        wbqp_log::check(&bytes)?;
        Ok(Self {
            header: header(&bytes)?,
            ..Self::default()
        })
    }

    /// Reads the contents of an MCAP file.
    ///
    /// # Errors
    /// [`ReadError::Damaged`] or [`ReadError::Mcap`].
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, ReadError> {
        wbqp_log::check(bytes)?;
        let mut topics: BTreeMap<String, Messages> = BTreeMap::new();
        let mut schemas = BTreeMap::new();
        for message in MessageStream::new(bytes)? {
            let message = message?;
            if message.channel.message_encoding != "json" {
                continue;
            }
            if let Some(schema) = &message.channel.schema
                && !schemas.contains_key(&message.channel.topic)
            {
                // One that is no JSON describes nothing.
                let schema = serde_json::from_slice(&schema.data).unwrap_or_default();
                schemas.insert(message.channel.topic.clone(), schema);
            }
            let time = message.log_time as f64 * 1e-9;
            let sample = (time, message.data.into_owned());
            match topics.get_mut(&message.channel.topic) {
                Some(samples) => samples.push(sample),
                None => {
                    topics.insert(message.channel.topic.clone(), vec![sample]);
                }
            }
        }
        Ok(Self {
            topics: topics.into_iter().map(|(t, m)| (t, Arc::new(m))).collect(),
            schemas,
            header: header(bytes)?,
        })
    }

    /// The topics that have messages.
    pub fn topics(&self) -> impl Iterator<Item = &str> {
        self.topics.keys().map(String::as_str)
    }

    /// What a topic's messages have inside an object that is inside other objects, by the names of these: the names of
    /// its fields.
    pub fn fields(&self, topic: &str, path: &[&str]) -> Vec<&str> {
        let object = self.schema(topic, path).and_then(Value::as_object);
        object.map_or_else(Vec::new, |o| o.keys().map(String::as_str).collect())
    }

    /// The unit of a number, by the names of the objects around it and its own.
    pub fn unit(&self, topic: &str, path: &[&str]) -> Option<&str> {
        let (name, objects) = path.split_last()?;
        let unit = self.schema(topic, objects)?.get(name)?.get("unit")?;
        unit.as_str()
    }

    /// The properties of an object.
    fn schema(&self, topic: &str, path: &[&str]) -> Option<&Value> {
        let root = self.schemas.get(topic)?.get("properties");
        path.iter()
            .fold(root, |inner, name| inner?.get(name)?.get("properties"))
    }

    /// Times (s) and contents of a topic's messages.
    ///
    /// # Errors
    /// [`MeasureError::Topic`] now, [`MeasureError::Unreadable`] per message.
    pub fn messages(
        &self,
        topic: &str,
    ) -> Result<impl Iterator<Item = Result<(f64, Value), MeasureError>>, MeasureError> {
        Ok(self.texts(topic)?.iter().map(move |(time, text)| {
            let message = serde_json::from_slice(text);
            Ok((*time, message.map_err(|source| unreadable(topic, source))?))
        }))
    }

    /// Times (s) and texts of a topic's messages.
    fn texts(&self, topic: &str) -> Result<&Messages, MeasureError> {
        let messages = self.topics.get(topic).ok_or_else(|| MeasureError::Topic {
            topic: topic.to_owned(),
            known: self.topics().collect::<Vec<_>>().join(", "),
        })?;
        Ok(messages)
    }

    /// What a topic's messages have.
    ///
    /// # Errors
    /// [`MeasureError::Topic`], [`MeasureError::Unreadable`].
    pub fn contents(&self, topic: &str) -> Result<Contents, MeasureError> {
        Contents::of(self, topic)
    }

    /// A table of texts.
    pub fn metadata(&self, name: &str) -> Option<&BTreeMap<String, String>> {
        self.header.metadata.get(name)
    }

    /// The log's named instants; empty if it has none.
    pub fn timeline(&self) -> Timeline {
        self.header.timeline()
    }

    /// Names and contents of the attached TOML files.
    pub fn attached_texts(&self) -> impl Iterator<Item = (&str, &str)> {
        self.header.attached_texts()
    }

    /// Contents of an attachment.
    pub fn attachment(&self, name: &str) -> Option<&[u8]> {
        self.header.attachments.get(name).map(Vec::as_slice)
    }

    /// All its series, read at once: for who asks for many of them.
    ///
    /// # Errors
    /// [`MeasureError::Unreadable`].
    pub fn signals(&self) -> Result<Signals, MeasureError> {
        let mut signals = Signals::new();
        for topic in self.topics() {
            let Contents { numbers, texts, .. } = self.contents(topic)?;
            let fields: Vec<String> = numbers.into_iter().chain(texts.into_keys()).collect();
            for (field, series) in fields.iter().zip(self.columns(topic, &fields)?) {
                signals = signals.with_series(topic, field, series);
            }
        }
        let timeline = self.timeline();
        let names = self.metadata(Timeline::NAME).into_iter().flatten();
        for (name, _) in names {
            signals = match timeline.get(name) {
                Some(time) => signals.with_mark(name, time),
                None => signals,
            };
        }
        if self.metadata("rotors").is_some() {
            signals = self
                .rotors()?
                .into_iter()
                .fold(signals, Signals::with_rotor);
        }
        let files = self.header.attached_tables();
        Ok(files.fold(signals, Signals::with_configuration))
    }
}

impl Recording for Log {
    fn has(&self, topic: &str) -> bool {
        self.topics.contains_key(topic)
    }

    fn columns(&self, topic: &str, fields: &[String]) -> Result<Vec<Series>, MeasureError> {
        let mut columns = vec![Series::default(); fields.len()];
        let (fields, mut numbers) = (Fields::new(fields), vec![f64::NAN; fields.len()]);
        for (time, text) in self.texts(topic)? {
            numbers.fill(f64::NAN);
            fields
                .read(text, &mut numbers)
                .map_err(|source| unreadable(topic, source))?;
            for (column, number) in columns.iter_mut().zip(&numbers) {
                column.t.push(*time);
                column.y.push(*number);
            }
        }
        Ok(columns)
    }

    fn names(&self, topic: &str, object: &str) -> Result<Vec<String>, MeasureError> {
        for message in self.messages(topic)? {
            let (_, message) = message?;
            if let Some(object) = message.pointer(object).and_then(Value::as_object) {
                return Ok(object.keys().cloned().collect());
            }
        }
        Ok(Vec::new())
    }

    fn end(&self) -> f64 {
        let last = self.topics.values().filter_map(|m| m.last());
        last.map(|m| m.0).fold(0.0, f64::max)
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

/// Metadata and attachments of the contents of an MCAP file.
fn header(bytes: &[u8]) -> Result<Header, ReadError> {
    let mut header = Header::default();
    for record in LinearReader::new(bytes)? {
        match record? {
            Record::Metadata(m) => {
                header.metadata.insert(m.name, m.metadata);
            }
            Record::Attachment {
                header: entry,
                data,
                ..
            } => {
                header.attachments.insert(entry.name, data.into_owned());
            }
            _ => {}
        }
    }
    Ok(header)
}

fn read(path: &Path) -> Result<Vec<u8>, ReadError> {
    input::read(path, input::LARGEST_LOG).map_err(|source| ReadError::File {
        path: path.to_owned(),
        source,
    })
}

fn unreadable(topic: &str, source: serde_json::Error) -> MeasureError {
    MeasureError::Unreadable {
        topic: topic.to_owned(),
        source: Box::new(source),
    }
}
