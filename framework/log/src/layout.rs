//! Whether the lengths inside a record are those of a record that is all there. Reading one whose text says to be 4 GB
//! long would allocate that much first.

use mcap::records::op;

/// What a record is made of, in its order.
#[derive(Clone, Copy)]
enum Part {
    /// So many bytes.
    Fixed(usize),
    /// Behind its length in four bytes.
    Text,
    /// Behind its length in eight bytes.
    Long,
    /// Pairs of texts, behind their length in four bytes.
    Map,
}

use Part::{Fixed, Long, Map, Text};

/// Nothing for a kind that is none.
fn parts(kind: u8) -> Option<&'static [Part]> {
    Some(match kind {
        op::HEADER => &[Text, Text],
        op::FOOTER => &[Fixed(20)],
        op::SCHEMA => &[Fixed(2), Text, Text, Text],
        op::CHANNEL => &[Fixed(4), Text, Text, Map],
        op::MESSAGE => &[Fixed(22)],
        op::CHUNK => &[Fixed(28), Text, Long],
        op::MESSAGE_INDEX => &[Fixed(2), Text],
        op::CHUNK_INDEX => &[Fixed(32), Text, Fixed(8), Text, Fixed(16)],
        op::ATTACHMENT => &[Fixed(16), Text, Text, Long, Fixed(4)],
        op::STATISTICS => &[Fixed(42), Text],
        op::METADATA => &[Text, Map],
        op::METADATA_INDEX => &[Fixed(16), Text],
        op::ATTACHMENT_INDEX => &[Fixed(40), Text, Text],
        op::SUMMARY_OFFSET => &[Fixed(17)],
        op::DATA_END => &[Fixed(4)],
        // Kinds that other programs define.
        0x80.. => &[],
        _ => return None,
    })
}

/// Whether there are records of this kind.
pub(crate) fn is_kind(kind: u8) -> bool {
    parts(kind).is_some()
}

/// Whether a record's lengths fit into it. Only a message and what other programs define go on behind their parts.
pub(crate) fn fits(kind: u8, body: &[u8]) -> bool {
    let Some(parts) = parts(kind) else {
        return false;
    };
    let rest = parts
        .iter()
        .try_fold(body, |rest, part| behind(*part, rest));
    let goes_on = kind == op::MESSAGE || kind >= 0x80;
    rest.is_some_and(|rest| rest.is_empty() || goes_on)
}

/// What is behind a part; nothing if it is not all there.
fn behind(part: Part, bytes: &[u8]) -> Option<&[u8]> {
    match part {
        Fixed(length) => bytes.get(length..),
        Text => Some(text(bytes)?.1),
        Long => {
            let (length, rest) = bytes.split_first_chunk::<8>()?;
            rest.get(usize::try_from(u64::from_le_bytes(*length)).ok()?..)
        }
        Map => {
            let (mut pairs, rest) = text(bytes)?;
            while !pairs.is_empty() {
                pairs = text(text(pairs)?.1)?.1;
            }
            Some(rest)
        }
    }
}

/// What a length in four bytes is that of, and what is behind it.
fn text(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let (length, rest) = bytes.split_first_chunk::<4>()?;
    rest.split_at_checked(usize::try_from(u32::from_le_bytes(*length)).ok()?)
}
