//! What an XML text may have, looked at before it is parsed, and what is said of one that cannot be.
//!
//! A parser compares each attribute of an element with all others of that element, and carries the namespaces of an
//! element over to the elements in it: both take time and memory with the square of what the text has of them. Each
//! element and each text beside it takes some 70 bytes, which is much more than the shortest of them has.

use roxmltree::{Document, ParsingOptions};
use wbqp::robot::{RobotError, SourceLocation};

use crate::source::Source;

/// Deepest nesting of elements. URDF itself needs six.
pub(crate) const DEEPEST: usize = 64;
/// The most attributes of an element. URDF itself needs six.
const MOST_ATTRIBUTES: usize = 64;
/// So many elements any text may have; of a longer one, each has at least [`SHORTEST`] bytes on average.
const FEW: usize = 10_000;
/// Bytes. `<link name="a"/>` has as many.
const SHORTEST: usize = 16;

/// Refuses elements with more attributes than any robot has, and nested deeper.
pub(crate) fn check(source: &Source<'_>) -> Result<(), RobotError> {
    match excess(source.text) {
        None => Ok(()),
        Some((offset, what)) => Err(RobotError::Syntax {
            place: source.place(offset),
            what,
        }),
    }
}

/// The tree of a text, with or without a document type; entities of its own, which can be made to grow without end, are
/// in no robot's.
pub(crate) fn parse(text: &str) -> Result<Document<'_>, roxmltree::Error> {
    let options = ParsingOptions {
        allow_dtd: !text.contains("<!ENTITY"),
        ..ParsingOptions::default()
    };
    Document::parse_with_options(text, options)
}

/// What roxmltree says of a text that is no XML.
pub(crate) fn parse_error(source: &Source<'_>, error: &roxmltree::Error) -> RobotError {
    use roxmltree::Error;
    let at = error.pos();
    let place = SourceLocation::at(source.file, at.row as usize, at.col as usize);
    let (place, what) = match error {
        Error::DtdDetected => {
            let entity = source.text.find("<!ENTITY").unwrap_or_default();
            let what = "has entities of its own (<!ENTITY …>), which can grow without end: write out what they are";
            (source.place(entity), what.to_owned())
        }
        // The parser says this without a place.
        Error::UnexpectedEndOfStream | Error::UnclosedRootNode
            if !source.text.trim().is_empty() =>
        {
            let end = source.text.trim_end().len();
            let what = format!(
                "malformed XML: {}; is the file cut?",
                without_position(error)
            );
            (source.place(end), what)
        }
        _ => (place, format!("malformed XML: {}", without_position(error))),
    };
    RobotError::Syntax { place, what }
}

/// The text with what other readers of URDFs forgive taken out, byte for byte in the same places: an XML declaration
/// that does not come first, the colon of prefixes whose namespace nothing declares, and zeros behind the end.
pub(crate) fn forgiving(text: &str) -> String {
    let mut mended = text.trim_end_matches('\0').to_owned();
    if let Some(start) = mended.find("<?xml").filter(|&start| start > 0)
        && let Some(length) = mended[start..].find("?>")
    {
        let blank = " ".repeat(length + 2);
        mended.replace_range(start..start + length + 2, &blank);
    }
    // More prefixes than these are no robot's.
    for _ in 0..32 {
        let Err(roxmltree::Error::UnknownNamespace(prefix, _)) = parse(&mended) else {
            break;
        };
        for lead in ["<", "</", " ", "\t", "\n"] {
            let from = format!("{lead}{prefix}:");
            mended = mended.replace(&from, &format!("{lead}{prefix}_"));
        }
    }
    mended
}

/// What roxmltree says, without the place that it says at the end: ours begin with it.
fn without_position(error: &roxmltree::Error) -> String {
    let said = error.to_string();
    let place = format!(" at {}", error.pos());
    said.strip_suffix(&place)
        .map_or(said.clone(), str::to_owned)
}

/// Where there is too much of something, and of what. A text that is no XML has a parser that says so.
fn excess(text: &str) -> Option<(usize, String)> {
    let most = FEW + text.len() / SHORTEST;
    let (mut depth, mut elements) = (0_usize, 0);
    let mut at = 0;
    loop {
        let start = at + text.get(at..)?.find('<')?;
        elements += usize::from(!text.get(start..)?.starts_with("</"));
        if elements > most {
            let what = format!(
                "there are more than {most} elements, comments and so on in so short a text"
            );
            return Some((start, what));
        }
        let rest = text.get(start..)?;
        let quoted = [
            ("<!--", "-->"),
            ("<![CDATA[", "]]>"),
            ("<?", "?>"),
            ("<!", ">"),
        ];
        let known = quoted.into_iter().find(|(open, _)| rest.starts_with(open));
        if let Some((open, close)) = known {
            let inside = rest.get(open.len()..)?;
            at = start + open.len() + inside.find(close)? + close.len();
        } else if rest.starts_with("</") {
            depth = depth.saturating_sub(1);
            at = start + rest.find('>')? + 1;
        } else {
            let Tag {
                length,
                attributes,
                is_closed,
            } = Tag::read(rest)?;
            if attributes > MOST_ATTRIBUTES {
                let what = format!("an element has more than {MOST_ATTRIBUTES} attributes");
                return Some((start, what));
            }
            if depth >= DEEPEST {
                let what = format!("elements are nested more than {DEEPEST} deep");
                return Some((start, what));
            }
            depth += usize::from(!is_closed);
            at = start + length;
        }
    }
}

/// `<name key="value" …>`.
struct Tag {
    /// Bytes.
    length: usize,
    attributes: usize,
    /// Whether it ends with `/>`.
    is_closed: bool,
}

impl Tag {
    fn read(text: &str) -> Option<Self> {
        let mut attributes = 0;
        let mut quote = None;
        let mut before = 0;
        for (index, byte) in text.bytes().enumerate() {
            match (quote, byte) {
                (Some(open), _) => quote = quote.filter(|_| open != byte),
                (None, b'"' | b'\'') => quote = Some(byte),
                (None, b'=') => attributes += 1,
                (None, b'>') => {
                    return Some(Self {
                        length: index + 1,
                        attributes,
                        is_closed: before == b'/',
                    });
                }
                (None, _) => {}
            }
            before = byte;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn attributes(count: usize) -> String {
        let keys = (0..count).map(|index| format!(" a{index}=\"= > /\""));
        format!(
            "<!-- <a <a --><?xml?><r>\n<l{}/></r>",
            keys.collect::<String>()
        )
    }

    fn empty(count: usize) -> String {
        format!("<r>{}</r>", "<x/>a".repeat(count))
    }

    fn nested(depth: usize) -> String {
        let (open, close) = ("<a b='>'>".repeat(depth), "</a>".repeat(depth));
        format!("{open}<![CDATA[<a><a>]]>{close}{open}{close}")
    }

    #[test]
    fn as_many_as_are_allowed_are_allowed() {
        assert_eq!(excess(&attributes(MOST_ATTRIBUTES)), None);
        let (offset, what) = excess(&attributes(MOST_ATTRIBUTES + 1)).expect("one more");
        assert_eq!(offset, "<!-- <a <a --><?xml?><r>\n".len());
        assert_eq!(what, "an element has more than 64 attributes");
        assert_eq!(excess(&empty(FEW)), None);
        // n elements and <r>, of 10 + 5 n bytes.
        let count = (FEW * SHORTEST) / (SHORTEST - 5) + 1;
        let (offset, what) = excess(&empty(count)).expect("more of them");
        assert!(offset > 3 && what.contains("elements"), "{what}");
        assert_eq!(excess(&nested(DEEPEST)), None);
        let (offset, _) = excess(&nested(DEEPEST + 1)).expect("one more");
        assert_eq!(offset, "<a b='>'>".len() * DEEPEST);
    }

    #[test]
    fn what_is_no_xml_is_none_of_its_business() {
        for text in ["", "<", "<a", "<!--", "</", "a > b", "<a b='", "<\u{e9}"] {
            assert_eq!(excess(text), None);
        }
    }
}
