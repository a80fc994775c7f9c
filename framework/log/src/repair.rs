//! A log whose writer was killed, or that was damaged since: what is intact, made into a whole file again.

use std::{
    collections::{BTreeMap, btree_map::Entry},
    fs, io,
    path::Path,
};

use mcap::records::{Channel, MessageHeader, Record};

use crate::{
    Damage, LogError, LogSink, McapLog,
    scan::{Piece, Records, Scan},
};
use wbqp::input;

/// What was found in a file.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Repaired {
    /// Messages that were saved.
    pub messages: u64,
    /// Time of the last of them, s.
    pub end: f64,
    /// Bytes at the end that are of no use: the file was cut there.
    pub lost: u64,
    /// Whether the file was whole.
    pub was_whole: bool,
    /// The first place that is not what was written, if there is one. A cut end is none.
    pub damage: Option<Damage>,
    /// How many such places there are.
    pub damages: u64,
    /// Whether it is in the index alone, from which nothing is needed: it is made anew.
    pub is_index_alone: bool,
    /// Messages that were in the file and are not saved, if it says how many there were.
    pub messages_lost: Option<u64>,
}

/// Reads a log and writes what is intact of it as a whole file: channels with their schemas, messages in their order,
/// metadata and attachments. A damaged chunk, or another record, is left out, and those behind it are not. `to` must
/// not exist; it does not after an error either.
///
/// In memory are the file, and a chunk at a time, which is at most 1024 times as long as in the file.
///
/// # Errors
/// [`LogError::Read`] if `from` cannot be read or is no MCAP file at all, [`LogError::Create`] if `to` cannot be made,
/// [`LogError::Write`].
pub fn repair(from: &Path, to: &Path) -> Result<Repaired, LogError> {
    let read = |source| LogError::Read {
        path: from.to_owned(),
        source,
    };
    let bytes = input::read(from, input::LARGEST_LOG).map_err(read)?;
    let Some(scan) = Scan::new(&bytes) else {
        let what = "is no MCAP file: it does not begin like one";
        return Err(read(io::Error::new(io::ErrorKind::InvalidData, what)));
    };
    if fs::exists(to).unwrap_or(true) {
        return Err(LogError::Create {
            path: to.to_owned(),
            source: io::Error::new(
                io::ErrorKind::AlreadyExists,
                "is there already: remove it, or give another name",
            ),
        });
    }
    let known = Known::of(&bytes);
    let log = McapLog::create(to)?;
    let saved = Saved::new(log, &known).all(scan);
    if saved.is_err() {
        // Half a file is no repaired one; whether it can be removed changes nothing.
        let _ = fs::remove_file(to);
    }
    saved
}

/// The name, the encoding and the text of a schema.
type Schema = (String, String, Vec<u8>);

/// Schemas and channels of all intact parts: the index has those again that a damaged chunk had.
#[derive(Default)]
struct Known {
    schemas: BTreeMap<u16, Schema>,
    channels: BTreeMap<u16, Channel>,
}

impl Known {
    fn of(file: &[u8]) -> Self {
        let mut known = Self::default();
        for piece in Scan::new(file).into_iter().flatten() {
            match piece {
                Piece::Record(record) => known.record(record),
                Piece::Chunk(bytes) => Records::new(&bytes).flatten().for_each(|r| known.record(r)),
                Piece::Damaged(_) | Piece::Cut(_) => {}
            }
        }
        known
    }

    /// Of two with the same id the first counts.
    fn record(&mut self, record: Record<'_>) {
        match record {
            Record::Schema { header, data } => {
                let schema = || (header.name, header.encoding, data.into_owned());
                self.schemas.entry(header.id).or_insert_with(schema);
            }
            Record::Channel(channel) => {
                self.channels.entry(channel.id).or_insert(channel);
            }
            _ => {}
        }
    }
}

/// A file that is being written.
struct Saved<'k> {
    log: McapLog,
    known: &'k Known,
    /// By the id of the old file.
    channels: BTreeMap<u16, u16>,
    messages: u64,
    /// ns.
    end: u64,
    damage: Option<Damage>,
    damages: u64,
    is_index_alone: bool,
    is_index_damaged: bool,
    /// Messages that the file says it has.
    said: Option<u64>,
    lost: u64,
    /// Whether what follows is the index.
    in_index: bool,
}

impl<'k> Saved<'k> {
    fn new(log: McapLog, known: &'k Known) -> Self {
        Self {
            log,
            known,
            channels: BTreeMap::new(),
            messages: 0,
            end: 0,
            damage: None,
            damages: 0,
            is_index_alone: true,
            is_index_damaged: false,
            said: None,
            lost: 0,
            in_index: false,
        }
    }

    fn all(mut self, scan: Scan<'_>) -> Result<Repaired, LogError> {
        let has_end = scan.has_end();
        // Channels without a message too.
        for id in self.known.channels.keys() {
            self.channel(*id)?;
        }
        for piece in scan {
            match piece {
                Piece::Record(record) => self.record(record)?,
                Piece::Chunk(bytes) => {
                    for record in Records::new(&bytes).flatten() {
                        self.record(record)?;
                    }
                }
                Piece::Damaged(damage) => {
                    self.is_index_alone &= self.in_index;
                    self.is_index_damaged |= self.in_index;
                    self.damages += 1;
                    self.damage.get_or_insert(damage);
                }
                Piece::Cut(lost) => self.lost = lost,
            }
        }
        self.log.finish()?;
        let said = self.said.filter(|_| !self.is_index_damaged);
        let missing = said.map(|said| said.saturating_sub(self.messages));
        Ok(Repaired {
            messages: self.messages,
            end: self.end as f64 / 1e9,
            lost: self.lost,
            was_whole: has_end && self.lost == 0 && self.damage.is_none(),
            is_index_alone: self.is_index_alone && self.damage.is_some(),
            damage: self.damage,
            damages: self.damages,
            messages_lost: missing,
        })
    }

    fn record(&mut self, record: Record<'_>) -> Result<(), LogError> {
        match record {
            Record::Message { header, data } => {
                if let Some(id) = self.channel(header.channel_id)? {
                    self.messages += 1;
                    self.end = self.end.max(header.log_time);
                    let header = MessageHeader {
                        channel_id: id,
                        ..header
                    };
                    self.log.copy_message(&header, &data)?;
                }
            }
            Record::Metadata(table) => self.log.metadata(&table.name, &table.metadata)?,
            Record::Attachment { header, data, .. } => {
                self.log.attach(&header.name, &header.media_type, &data)?;
            }
            Record::DataEnd(_) => self.in_index = true,
            Record::Footer(_) => self.in_index = false,
            Record::Statistics(statistics) => self.said = Some(statistics.message_count),
            _ => {}
        }
        Ok(())
    }

    /// The id here of a channel of the old file, which is opened when it is wanted.
    fn channel(&mut self, old: u16) -> Result<Option<u16>, LogError> {
        let Entry::Vacant(entry) = self.channels.entry(old) else {
            return Ok(self.channels.get(&old).copied());
        };
        let Some(channel) = self.known.channels.get(&old) else {
            return Ok(None);
        };
        let schema = self.known.schemas.get(&channel.schema_id);
        let schema = schema
            .map(|(name, encoding, text)| (name.as_str(), encoding.as_str(), text.as_slice()));
        Ok(Some(*entry.insert(self.log.copy_channel(channel, schema)?)))
    }
}
