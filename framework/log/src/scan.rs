//! The bytes of a log, taken apart without trusting any of them: lengths and checksums are looked at before anything
//! is handed to the `mcap` crate, which takes a damaged length for a promise. What is damaged is left out, and the
//! scan goes on behind it.

use std::io::Read as _;

use mcap::{
    read::parse_record,
    records::{Record, op},
};

use crate::layout::{fits, is_kind};

/// With which every MCAP file begins and ends.
pub(crate) const MAGIC: &[u8] = b"\x89MCAP0\r\n";

/// So many times its length in the file a chunk may take in memory; one that says to be longer is damaged. Those of
/// logs are about ten times as long.
const LARGEST_RATIO: u64 = 1024;

/// Kind and length, before every record.
const HEAD: usize = 9;

/// A place in a log where it is not what was written.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("damaged at byte {at}: {what}")]
#[non_exhaustive]
pub struct Damage {
    /// Bytes before it.
    pub at: u64,
    /// What is wrong there.
    pub what: &'static str,
}

/// What stands at a place.
pub(crate) enum Piece<'a> {
    /// A record with lengths that fit.
    Record(Record<'a>),
    /// The records of a chunk whose checksum is right.
    Chunk(Vec<u8>),
    /// Left out.
    Damaged(Damage),
    /// The file ends in the middle of a record: so many bytes are left.
    Cut(u64),
}

/// All pieces of a file, one after the other.
pub(crate) struct Scan<'a> {
    /// Without the magic bytes at the end.
    file: &'a [u8],
    has_end: bool,
    at: usize,
    has_chunks: bool,
    /// The kinds with a checksum of much of the file that were there: again and again it would take for ever.
    summed: Vec<u8>,
}

impl<'a> Scan<'a> {
    /// Nothing if the file does not begin like an MCAP file.
    pub(crate) fn new(file: &'a [u8]) -> Option<Self> {
        let body = file.strip_prefix(MAGIC)?;
        let has_end = body.ends_with(MAGIC);
        let end = file.len() - if has_end { MAGIC.len() } else { 0 };
        Some(Self {
            file: file.get(..end)?,
            has_end,
            at: MAGIC.len(),
            has_chunks: false,
            summed: Vec::new(),
        })
    }

    /// Whether the file ends like an MCAP file.
    pub(crate) fn has_end(&self) -> bool {
        self.has_end
    }

    /// Whether something that looks like a record begins there, or the file ends.
    fn may_begin(&self, at: usize) -> bool {
        match self.file.get(at) {
            None => true,
            Some(_) if self.is_other_file(at) => true,
            Some(&kind) if is_kind(kind) => !self.has_end || record(self.file, at).is_some(),
            Some(_) => false,
        }
    }

    /// Whether another log was put behind this one. Its channels have the ids of others.
    fn is_other_file(&self, at: usize) -> bool {
        let rest = self.file.get(at..);
        rest.is_some_and(|rest| rest.starts_with(MAGIC))
    }

    /// Where the next chunk begins whose lengths are right.
    fn chunk_after(&self, from: usize) -> Option<usize> {
        let rest = self.file.get(from..)?;
        let candidates = rest.iter().enumerate().filter(|(_, b)| **b == op::CHUNK);
        candidates
            .map(|(k, _)| from + k)
            .find(|&at| record(self.file, at).is_some_and(|(kind, body)| fits(kind, body)))
    }

    /// Goes on at `next`, or where another log begins before.
    fn damaged(&mut self, what: &'static str, next: usize) -> Piece<'a> {
        let damage = Damage {
            at: self.at as u64,
            what,
        };
        let skipped = self.file.get(self.at + 1..next).unwrap_or_default();
        let other = skipped
            .windows(MAGIC.len())
            .position(|bytes| bytes == MAGIC);
        self.at = other.map_or(next, |other| self.at + 1 + other);
        Piece::Damaged(damage)
    }

    fn checked(&mut self, kind: u8, body: &'a [u8]) -> Result<Piece<'a>, &'static str> {
        if !is_kind(kind) {
            return Err("there is no record of this kind");
        }
        if !fits(kind, body) {
            return Err("the lengths in this record do not fit into it");
        }
        if matches!(kind, op::DATA_END | op::FOOTER) {
            if self.summed.contains(&kind) {
                return Err("this record is there twice");
            }
            self.summed.push(kind);
        }
        match kind {
            op::CHUNK => {
                self.has_chunks = true;
                Ok(Piece::Chunk(chunk(body)?))
            }
            // An index whose kind has another bit looks like one.
            op::MESSAGE if self.has_chunks => Err("a message outside the chunks"),
            op::DATA_END => match body.first_chunk().map(|crc| u32::from_le_bytes(*crc)) {
                Some(crc) if !is_sum(self.file.get(..self.at), crc) => {
                    Err("the checksum of everything before it is another one")
                }
                _ => parsed(kind, body),
            },
            op::FOOTER => match footer(body) {
                Some((start, crc)) if !is_sum(self.summary(start), crc) => {
                    Err("the checksum of the index before it is another one")
                }
                _ => parsed(kind, body),
            },
            _ => parsed(kind, body),
        }
    }

    /// What the footer's checksum is of, the footer standing here.
    fn summary(&self, start: u64) -> Option<&'a [u8]> {
        let start = match usize::try_from(start).ok()? {
            0 => self.at,
            start => start,
        };
        self.file.get(start..self.at + HEAD + 16)
    }
}

impl<'a> Iterator for Scan<'a> {
    type Item = Piece<'a>;

    fn next(&mut self) -> Option<Piece<'a>> {
        let left = self.file.len().saturating_sub(self.at);
        if left == 0 {
            return None;
        }
        if self.is_other_file(self.at) {
            let end = self.file.len();
            return Some(self.damaged(
                "the log ends here, and what was put behind its end is left out",
                end,
            ));
        }
        let Some((kind, body)) = record(self.file, self.at) else {
            if let Some(next) = self.chunk_after(self.at + 1) {
                return Some(self.damaged("this record goes beyond the end of the file", next));
            }
            if self.has_end {
                let end = self.file.len();
                return Some(self.damaged("this record goes beyond the end of the file", end));
            }
            self.at = self.file.len();
            return Some(Piece::Cut(left as u64));
        };
        let next = self.at + HEAD + body.len();
        let checked = self.checked(kind, body);
        // A record of the wrong length can look right, but what is behind it does not.
        let is_followed = self.may_begin(next);
        Some(match checked {
            Ok(piece) if is_followed => {
                self.at = next;
                piece
            }
            Ok(_) => self.damaged("behind this record there is none", self.behind(next)),
            Err(what) if is_followed => self.damaged(what, next),
            Err(what) => self.damaged(what, self.behind(next)),
        })
    }
}

impl Scan<'_> {
    /// Where to go on when a record's length cannot be trusted.
    fn behind(&self, otherwise: usize) -> usize {
        let next = self.chunk_after(self.at + 1);
        next.unwrap_or_else(|| otherwise.max(self.file.len()))
    }
}

/// Kind and body of the record at a place; nothing if it is not all there.
fn record(bytes: &[u8], at: usize) -> Option<(u8, &[u8])> {
    let (&kind, rest) = bytes.get(at..)?.split_first()?;
    let (length, rest) = rest.split_first_chunk::<8>()?;
    let length = usize::try_from(u64::from_le_bytes(*length)).ok()?;
    Some((kind, rest.get(..length)?))
}

fn parsed(kind: u8, body: &[u8]) -> Result<Piece<'_>, &'static str> {
    match parse_record(kind, body) {
        Ok(record) => Ok(Piece::Record(record)),
        Err(_) => Err("this record cannot be read"),
    }
}

/// Where the index begins, and its checksum.
fn footer(body: &[u8]) -> Option<(u64, u32)> {
    let start = u64::from_le_bytes(*body.first_chunk()?);
    let sum = u32::from_le_bytes(*body.last_chunk()?);
    Some((start, sum))
}

/// 0 says that no sum was made.
fn is_sum(bytes: Option<&[u8]>, sum: u32) -> bool {
    sum == 0 || bytes.is_some_and(|bytes| crc32fast::hash(bytes) == sum)
}

/// The records of a chunk.
fn chunk(body: &[u8]) -> Result<Vec<u8>, &'static str> {
    let Ok(Record::Chunk { header, data }) = parse_record(op::CHUNK, body) else {
        return Err("this chunk cannot be read");
    };
    let length = header.uncompressed_size;
    if length > (data.len() as u64).saturating_mul(LARGEST_RATIO) {
        return Err("this chunk says to be more than 1024 times as long as it is in the file");
    }
    let bytes = match header.compression.as_str() {
        "" => data.into_owned(),
        "zstd" => decompressed(&data, length).ok_or("this chunk cannot be decompressed")?,
        _ => return Err("this chunk is compressed in a way that is not read here"),
    };
    if bytes.len() as u64 != length {
        return Err("this chunk is not as long as it says");
    }
    if !is_sum(Some(&bytes), header.uncompressed_crc) {
        return Err("this chunk's checksum is another one");
    }
    if Records::new(&bytes).any(|record| record.is_err()) {
        return Err("this chunk has something in it that is no record");
    }
    Ok(bytes)
}

/// Of more than `length` bytes one more, no matter how many there are.
fn decompressed(data: &[u8], length: u64) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    let decoder = zstd::stream::read::Decoder::new(data).ok()?;
    let mut decoder = decoder.take(length.saturating_add(1));
    decoder.read_to_end(&mut bytes).ok()?;
    Some(bytes)
}

/// What is no record, or none that a chunk has.
pub(crate) struct NoRecord;

/// The records of a chunk: schemas, channels, messages.
pub(crate) struct Records<'a> {
    bytes: &'a [u8],
}

impl<'a> Records<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes }
    }
}

impl<'a> Iterator for Records<'a> {
    type Item = Result<Record<'a>, NoRecord>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.bytes.is_empty() {
            return None;
        }
        let found = record(self.bytes, 0).filter(|(kind, body)| {
            matches!(*kind, op::SCHEMA | op::CHANNEL | op::MESSAGE) && fits(*kind, body)
        });
        let parsed = found.and_then(|(kind, body)| {
            self.bytes = self.bytes.get(HEAD + body.len()..)?;
            parse_record(kind, body).ok()
        });
        if parsed.is_none() {
            self.bytes = &[];
        }
        Some(parsed.ok_or(NoRecord))
    }
}

/// Looks at every length and every checksum of a log that should be whole. What passes can be handed to any reader.
///
/// # Errors
/// The first [`Damage`]; where the file is cut that is where its last record begins.
pub fn check(file: &[u8]) -> Result<(), Damage> {
    let damage = |at: usize, what| Damage {
        at: at as u64,
        what,
    };
    let Some(scan) = Scan::new(file) else {
        return Err(damage(0, "it does not begin like an MCAP file"));
    };
    let has_end = scan.has_end();
    for piece in scan {
        match piece {
            Piece::Damaged(damage) => return Err(damage),
            Piece::Cut(lost) => {
                let at = file.len().saturating_sub(lost as usize);
                return Err(damage(at, "the file ends in the middle of this record"));
            }
            Piece::Record(_) | Piece::Chunk(_) => {}
        }
    }
    if !has_end {
        return Err(damage(file.len(), "the file has no end"));
    }
    Ok(())
}
