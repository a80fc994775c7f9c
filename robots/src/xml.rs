//! What an XML text may have, looked at before it is parsed.
//!
//! A parser compares each attribute of an element with all others of that element, and carries the namespaces of an
//! element over to the elements in it: both take time and memory with the square of what the text has of them.

use wbqp::robot::RobotError;

use crate::source::Source;

/// Deepest nesting of elements. URDF itself needs six.
pub(crate) const DEEPEST: usize = 64;
/// The most attributes of an element. URDF itself needs six.
const MOST_ATTRIBUTES: usize = 64;

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

/// Where there is too much of something, and of what. A text that is no XML has a parser that says so.
fn excess(text: &str) -> Option<(usize, String)> {
    let mut depth = 0_usize;
    let mut at = 0;
    loop {
        let start = at + text.get(at..)?.find('<')?;
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
