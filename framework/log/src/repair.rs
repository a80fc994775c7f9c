//! A log whose writer was killed: what was written, made into a whole file again.

use std::{collections::BTreeMap, fs, io, path::Path};

use mcap::{
    read::{ChunkReader, parse_record},
    records::{MessageHeader, Record},
};

use crate::{LogError, LogSink, McapLog};
use wbqp::input;

/// With which every MCAP file begins and ends.
const MAGIC: &[u8] = b"\x89MCAP0\r\n";

/// What was found in a file.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Repaired {
    /// Messages that were saved.
    pub messages: u64,
    /// Time of the last of them, s.
    pub end: f64,
    /// Bytes at the end that are of no use.
    pub lost: u64,
    /// Whether the file was whole.
    pub was_whole: bool,
}

/// Reads a log as far as it goes and writes what is in it as a whole file: channels with their schemas, messages in
/// their order, metadata and attachments. `to` must not exist.
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
    let Some(body) = bytes.strip_prefix(MAGIC) else {
        let what = "is no MCAP file: it does not begin like one";
        return Err(read(io::Error::new(io::ErrorKind::InvalidData, what)));
    };
    if fs::exists(to).unwrap_or(true) {
        return Err(LogError::Create {
            path: to.to_owned(),
            source: io::Error::new(io::ErrorKind::AlreadyExists, "is there already"),
        });
    }
    let was_whole = body.ends_with(MAGIC);
    let body = body.strip_suffix(MAGIC).unwrap_or(body);
    let mut saved = Saved {
        log: McapLog::create(to)?,
        schemas: BTreeMap::new(),
        channels: BTreeMap::new(),
        messages: 0,
        end: 0,
    };
    let mut rest = body;
    // Up to a record in whose middle the file ends, or that is none.
    while let Some((op, record, behind)) = first_record(rest) {
        let Ok(record) = parse_record(op, record) else {
            break;
        };
        saved.record(record)?;
        rest = behind;
    }
    let lost = rest.len() as u64;
    saved.log.finish()?;
    Ok(Repaired {
        messages: saved.messages,
        end: saved.end as f64 / 1e9,
        lost,
        was_whole: was_whole && lost == 0,
    })
}

/// Kind and body of the first record, and what is behind it; nothing if it is not all there.
fn first_record(bytes: &[u8]) -> Option<(u8, &[u8], &[u8])> {
    let (&op, rest) = bytes.split_first()?;
    let (length, rest) = rest.split_first_chunk::<8>()?;
    let length = usize::try_from(u64::from_le_bytes(*length)).ok()?;
    let (body, behind) = rest.split_at_checked(length)?;
    Some((op, body, behind))
}

/// A file that is being written.
struct Saved {
    log: McapLog,
    /// By the id of the old file: name, encoding, text.
    schemas: BTreeMap<u16, (String, String, Vec<u8>)>,
    /// By the id of the old file.
    channels: BTreeMap<u16, u16>,
    messages: u64,
    /// ns.
    end: u64,
}

impl Saved {
    fn record(&mut self, record: Record<'_>) -> Result<(), LogError> {
        match record {
            Record::Chunk { header, data } => {
                let Ok(chunk) = ChunkReader::new(header, &data) else {
                    return Ok(());
                };
                // One that is damaged gives what is before the damage.
                for record in chunk.map_while(Result::ok) {
                    self.record(record)?;
                }
            }
            Record::Schema { header, data } => {
                let schema = (header.name, header.encoding, data.into_owned());
                self.schemas.insert(header.id, schema);
            }
            Record::Channel(channel) => {
                if let std::collections::btree_map::Entry::Vacant(entry) =
                    self.channels.entry(channel.id)
                {
                    let schema = self.schemas.get(&channel.schema_id);
                    let schema = schema.map(|(name, encoding, text)| {
                        (name.as_str(), encoding.as_str(), text.as_slice())
                    });
                    let id = self.log.copy_channel(&channel, schema)?;
                    entry.insert(id);
                }
            }
            Record::Message { header, data } => {
                if let Some(&id) = self.channels.get(&header.channel_id) {
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
            _ => {}
        }
        Ok(())
    }
}
