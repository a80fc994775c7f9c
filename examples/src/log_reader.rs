//! Reads logs back: figures and tables are made from the file, not from the simulator's memory.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    sync::Arc,
};

use mcap::{McapError, MessageStream, read::LinearReader, records::Record};
use wbqp::{
    input,
    serde_json::{self, Value},
};
use wbqp_log::{ChannelId, LogError, LogSink, Timeline};

use crate::series::Series;

/// Times, s, and texts of a topic's messages.
type Messages = Vec<(f64, Vec<u8>)>;

/// A log in memory: the text of each message by topic, schemas, metadata and attachments. Clones share the messages.
#[derive(Clone, Debug, Default)]
pub struct Log {
    topics: BTreeMap<String, Arc<Messages>>,
    schemas: BTreeMap<String, Value>,
    metadata: BTreeMap<String, BTreeMap<String, String>>,
    attachments: BTreeMap<String, Vec<u8>>,
}

/// Why a log could not be read.
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
    /// A topic is not there.
    #[error("the log has no topic `{topic}`; it has {known}")]
    Topic {
        /// The topic asked for.
        topic: String,
        /// The topics there are.
        known: String,
    },
    /// A message is not JSON.
    #[error("a message of `{topic}` is not JSON: {source}")]
    Json {
        /// Its topic.
        topic: String,
        /// What is wrong.
        source: serde_json::Error,
    },
    /// Metadata, or an entry of it, is not there or is not a number.
    #[error("the log's metadata `{name}` lacks `{key}`")]
    Metadata {
        /// The table.
        name: String,
        /// The entry.
        key: String,
    },
    /// An attachment is not there or not what it should be.
    #[error("the log has no usable attachment with {0}")]
    Attachment(String),
}

impl Log {
    /// Reads a file.
    ///
    /// # Errors
    /// [`ReadError::File`] or [`ReadError::Mcap`].
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        Self::from_bytes(&read(path)?)
    }

    /// Reads metadata and attachments of a file, not its messages.
    ///
    /// # Errors
    /// [`ReadError::File`] or [`ReadError::Mcap`].
    pub fn open_header(path: &Path) -> Result<Self, ReadError> {
        Self::header(&read(path)?)
    }

    /// Reads the contents of an MCAP file.
    ///
    /// # Errors
    /// [`ReadError::Mcap`].
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, ReadError> {
        let mut topics: BTreeMap<String, Messages> = BTreeMap::new();
        let mut schemas = BTreeMap::new();
        for message in MessageStream::new(bytes)? {
            let message = message?;
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
            ..Self::header(bytes)?
        })
    }

    fn header(bytes: &[u8]) -> Result<Self, ReadError> {
        let mut log = Self::default();
        for record in LinearReader::new(bytes)? {
            match record? {
                Record::Metadata(m) => {
                    log.metadata.insert(m.name, m.metadata);
                }
                Record::Attachment { header, data, .. } => {
                    log.attachments.insert(header.name, data.into_owned());
                }
                _ => {}
            }
        }
        Ok(log)
    }

    /// The topics that have messages.
    pub fn topics(&self) -> impl Iterator<Item = &str> {
        self.topics.keys().map(String::as_str)
    }

    /// Whether the topic has messages.
    pub fn has(&self, topic: &str) -> bool {
        self.topics.contains_key(topic)
    }

    /// Time of the last message, s.
    pub fn end(&self) -> f64 {
        let last = self.topics.values().filter_map(|m| m.last());
        last.map(|m| m.0).fold(0.0, f64::max)
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

    /// One number over time, by topic and JSON pointer; true is 1 and false is 0.
    ///
    /// # Errors
    /// [`ReadError::Topic`] or [`ReadError::Json`].
    pub fn series(&self, topic: &str, pointer: &str) -> Result<Series, ReadError> {
        self.series_by(topic, |message| {
            message.pointer(pointer).map_or(f64::NAN, to_number)
        })
    }

    /// One number over time, computed from each message.
    ///
    /// # Errors
    /// [`ReadError::Topic`] or [`ReadError::Json`].
    pub fn series_by(
        &self,
        topic: &str,
        value: impl Fn(&Value) -> f64,
    ) -> Result<Series, ReadError> {
        self.messages(topic)?
            .map(|message| message.map(|(time, message)| (time, value(&message))))
            .collect()
    }

    /// Times (s) and contents of a topic's messages.
    ///
    /// # Errors
    /// [`ReadError::Topic`] now, [`ReadError::Json`] per message.
    pub fn messages(
        &self,
        topic: &str,
    ) -> Result<impl Iterator<Item = Result<(f64, Value), ReadError>>, ReadError> {
        let messages = self.topics.get(topic).ok_or_else(|| ReadError::Topic {
            topic: topic.to_owned(),
            known: self.topics().collect::<Vec<_>>().join(", "),
        })?;
        Ok(messages.iter().map(move |(time, text)| {
            let message = serde_json::from_slice(text).map_err(|source| ReadError::Json {
                topic: topic.to_owned(),
                source,
            })?;
            Ok((*time, message))
        }))
    }

    /// A table of texts.
    pub fn metadata(&self, name: &str) -> Option<&BTreeMap<String, String>> {
        self.metadata.get(name)
    }

    /// The log's named instants; empty if it has none.
    pub fn timeline(&self) -> Timeline {
        self.metadata(Timeline::NAME)
            .map(Timeline::from_metadata)
            .unwrap_or_default()
    }

    /// A named instant, s.
    ///
    /// # Errors
    /// [`ReadError::Metadata`] if the run had none of that name.
    pub fn mark(&self, name: &str) -> Result<f64, ReadError> {
        self.timeline()
            .get(name)
            .ok_or_else(|| ReadError::Metadata {
                name: Timeline::NAME.to_owned(),
                key: name.to_owned(),
            })
    }

    /// Limits of the rotors, in the order of their names.
    ///
    /// # Errors
    /// [`ReadError::Metadata`].
    pub fn rotors(&self) -> Result<Vec<RotorLimits>, ReadError> {
        let lacks = |key: &str| ReadError::Metadata {
            name: "rotors".to_owned(),
            key: key.to_owned(),
        };
        let table = self.metadata("rotors").ok_or_else(|| lacks("*.min"))?;
        let number = |key: String| {
            let text = table.get(&key).ok_or_else(|| lacks(&key))?;
            text.parse::<f64>().map_err(|_| lacks(&key))
        };
        let names = table.keys().filter_map(|k| k.strip_suffix(".min"));
        names
            .map(|name| {
                Ok(RotorLimits {
                    name: name.to_owned(),
                    thrust: [
                        number(format!("{name}.min"))?,
                        number(format!("{name}.max"))?,
                    ],
                    speed: [
                        number(format!("{name}.speed_min"))?,
                        number(format!("{name}.speed_max"))?,
                    ],
                    lag: [
                        number(format!("{name}.rise"))?,
                        number(format!("{name}.fall"))?,
                    ],
                })
            })
            .collect()
    }

    /// Names and contents of the attached TOML files.
    pub fn attached_texts(&self) -> impl Iterator<Item = (&str, &str)> {
        let toml = self.attachments.iter();
        let toml = toml.filter(|(name, _)| has_extension(name, "toml"));
        toml.filter_map(|(name, data)| Some((name.as_str(), std::str::from_utf8(data).ok()?)))
    }

    /// Contents of an attachment.
    pub fn attachment(&self, name: &str) -> Option<&[u8]> {
        self.attachments.get(name).map(Vec::as_slice)
    }

    /// The first attached TOML file that has this key at its top.
    ///
    /// # Errors
    /// [`ReadError::Attachment`].
    pub fn attached_toml(&self, key: &str) -> Result<toml::Table, ReadError> {
        self.attached_texts()
            .filter_map(|(_, text)| text.parse::<toml::Table>().ok())
            .find(|table| table.contains_key(key))
            .ok_or_else(|| ReadError::Attachment(format!("a TOML key `{key}`")))
    }
}

fn read(path: &Path) -> Result<Vec<u8>, ReadError> {
    input::read(path, input::LARGEST_LOG).map_err(|source| ReadError::File {
        path: path.to_owned(),
        source,
    })
}

/// Keeps what a run writes, to be read without a file. What is read is what an MCAP file would give.
#[derive(Debug, Default)]
pub struct Recorder {
    topics: Vec<(String, Messages)>,
    schemas: BTreeMap<String, Value>,
    metadata: BTreeMap<String, BTreeMap<String, String>>,
    attachments: BTreeMap<String, Vec<u8>>,
}

impl Recorder {
    /// What was written.
    pub fn into_log(self) -> Log {
        let written = self.topics.into_iter().filter(|(_, m)| !m.is_empty());
        Log {
            topics: written.map(|(t, m)| (t, Arc::new(m))).collect(),
            schemas: self.schemas,
            metadata: self.metadata,
            attachments: self.attachments,
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

    fn write(&mut self, channel: ChannelId, time: f64, message: &[u8]) -> Result<(), LogError> {
        if !(time.is_finite() && time >= 0.0) {
            return Err(LogError::Time(time));
        }
        let topic = self.topics.get_mut(channel.index());
        let (_, messages) = topic.ok_or(LogError::Channel(channel))?;
        // Files have whole nanoseconds.
        let nanoseconds = (time * 1e9).round() as u64;
        messages.push((nanoseconds as f64 * 1e-9, message.to_owned()));
        Ok(())
    }

    fn metadata(&mut self, name: &str, table: &BTreeMap<String, String>) -> Result<(), LogError> {
        self.metadata.insert(name.to_owned(), table.clone());
        Ok(())
    }

    fn attach(&mut self, name: &str, _: &str, data: &[u8]) -> Result<(), LogError> {
        self.attachments.insert(name.to_owned(), data.to_owned());
        Ok(())
    }

    fn finish(&mut self) -> Result<(), LogError> {
        Ok(())
    }
}

/// Limits of a rotor.
#[derive(Clone, Debug, PartialEq)]
pub struct RotorLimits {
    /// Its name.
    pub name: String,
    /// Smallest and largest thrust, N.
    pub thrust: [f64; 2],
    /// Speeds at these, rad/s.
    pub speed: [f64; 2],
    /// Time constants of the thrust, rising and falling, s.
    pub lag: [f64; 2],
}

impl RotorLimits {
    /// Whether a thrust in N is at a bound: within 1 % of the range.
    pub fn at_a_bound(&self, thrust: f64) -> bool {
        let [low, high] = self.thrust;
        (thrust - low).abs().min((thrust - high).abs()) <= 0.01 * (high - low)
    }
}

fn to_number(value: &Value) -> f64 {
    match value {
        Value::Bool(b) => f64::from(u8::from(*b)),
        other => other.as_f64().unwrap_or(f64::NAN),
    }
}

fn has_extension(name: &str, extension: &str) -> bool {
    Path::new(name)
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case(extension))
}
