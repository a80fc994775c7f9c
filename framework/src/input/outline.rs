//! What stands in a TOML text, seen in one pass that keeps next to nothing: a tree of it takes many times its size.
//!
//! Texts with mistakes have an outline as well, up to a point: whoever reads them says what is wrong.

use toml_parser::{
    Source,
    lexer::{Token, TokenKind},
};

/// The deepest nesting that is followed; parsers of the format refuse more.
const DEEPEST: usize = 80;

/// Something in a text, in its order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark<'t> {
    /// `[a.b]` or `[[a.b]]`: what stands between the brackets.
    Header(&'t str),
    /// `a.b = …` in a table with a header, or at the top: what stands before the sign, and whether the value is a
    /// string.
    Key(&'t str, IsText),
    /// A key in an inline table.
    InlineKey,
    /// `{`.
    InlineTable,
    /// The end of an element of a list.
    Element,
}

/// Whether a value begins as a string does.
pub type IsText = bool;

/// Where a token stands.
enum Place {
    /// From the beginning of a line, or of what follows a value.
    Key(usize),
    /// From behind the first bracket.
    Header(usize),
    /// Behind the sign of this key.
    Sign(usize, usize),
    /// Within a value.
    Value,
}

/// Calls `see` for every mark of a text, until it says that it has seen enough.
pub fn outline<'t>(text: &'t str, mut see: impl FnMut(usize, Mark<'t>) -> Enough) -> Enough {
    let mut place = Place::Key(0);
    // Whether each open bracket is that of an inline table.
    let mut open: Vec<bool> = Vec::new();
    for token in Source::new(text).lex() {
        let (start, end) = (token.span().start(), token.span().end());
        let kind = token.kind();
        let mark = match place {
            Place::Key(from) => match kind {
                TokenKind::LeftSquareBracket if is_blank(text, from, start) => {
                    place = Place::Header(end);
                    None
                }
                TokenKind::Equals => {
                    place = Place::Sign(from, start);
                    None
                }
                TokenKind::Newline => {
                    place = Place::Key(end);
                    None
                }
                _ => None,
            },
            Place::Header(from) => match kind {
                TokenKind::RightSquareBracket | TokenKind::Newline => {
                    let name = between(text, from, start).trim_start_matches('[');
                    place = match kind {
                        TokenKind::Newline => Place::Key(end),
                        _ => Place::Value,
                    };
                    Some((from, Mark::Header(name.trim())))
                }
                _ => None,
            },
            Place::Sign(from, sign) if kind != TokenKind::Whitespace => {
                let key = between(text, from, sign).trim();
                let mark = Mark::Key(key, is_text(&token));
                place = match kind {
                    TokenKind::Newline => Place::Key(end),
                    _ => Place::Value,
                };
                if see(from, mark) == Enough::Yes {
                    return Enough::Yes;
                }
                value(kind, &mut open).map(|mark| (start, mark))
            }
            Place::Sign(..) => None,
            Place::Value if kind == TokenKind::Newline && open.is_empty() => {
                place = Place::Key(end);
                None
            }
            Place::Value => value(kind, &mut open).map(|mark| (start, mark)),
        };
        if let Some((at, mark)) = mark
            && see(at, mark) == Enough::Yes
        {
            return Enough::Yes;
        }
    }
    Enough::No
}

/// Whether a caller has seen what it wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Enough {
    /// It has.
    Yes,
    /// There may be more.
    No,
}

/// What a token within a value is.
fn value<'t>(kind: TokenKind, open: &mut Vec<bool>) -> Option<Mark<'t>> {
    let in_table = open.last().copied();
    match kind {
        TokenKind::LeftSquareBracket | TokenKind::LeftCurlyBracket => {
            let is_table = kind == TokenKind::LeftCurlyBracket;
            if open.len() < DEEPEST {
                open.push(is_table);
            }
            is_table.then_some(Mark::InlineTable)
        }
        TokenKind::RightSquareBracket => (open.pop() == Some(false)).then_some(Mark::Element),
        TokenKind::RightCurlyBracket => {
            open.pop();
            None
        }
        TokenKind::Comma if in_table == Some(false) => Some(Mark::Element),
        TokenKind::Equals if in_table == Some(true) => Some(Mark::InlineKey),
        _ => None,
    }
}

fn is_text(token: &Token) -> IsText {
    matches!(
        token.kind(),
        TokenKind::LiteralString
            | TokenKind::BasicString
            | TokenKind::MlLiteralString
            | TokenKind::MlBasicString
    )
}

fn between(text: &str, from: usize, to: usize) -> &str {
    text.get(from..to).unwrap_or_default()
}

fn is_blank(text: &str, from: usize, to: usize) -> bool {
    between(text, from, to).trim().is_empty()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(text: &str) -> Vec<Mark<'_>> {
        let mut marks = Vec::new();
        outline(text, |_, mark| {
            marks.push(mark);
            Enough::No
        });
        marks
    }

    #[test]
    fn tables_keys_and_elements_are_seen_in_their_order() {
        let text = "a = 'x' # [not]\nb.c = [1.5, [2], { d = 3, e = [\n4\n] }]\n[f.g]\n\
                    \x20 [[ h ]] # end\ni=\"\"\"\n[j]\n\"\"\"\n";
        let expected = [
            Mark::Key("a", true),
            Mark::Key("b.c", false),
            Mark::Element,
            Mark::Element,
            Mark::Element,
            Mark::InlineTable,
            Mark::InlineKey,
            Mark::InlineKey,
            Mark::Element,
            Mark::Element,
            Mark::Header("f.g"),
            Mark::Header("h"),
            Mark::Key("i", true),
        ];
        assert_eq!(all(text), expected);
    }

    #[test]
    fn broken_texts_have_an_outline_too() {
        for text in [
            "[",
            "[[",
            "a",
            "a =",
            "= 1",
            "[a\nb = [[[\n[c]",
            "}]\n]a = 1",
            "'''",
        ] {
            let marks = all(text);
            assert!(marks.len() < 5, "{text}: {marks:?}");
        }
        let deep = format!("x = {}{}\ny = 1\n", "[".repeat(100), "]".repeat(100));
        assert_eq!(all(&deep).last(), Some(&Mark::Key("y", false)));
    }

    #[test]
    fn a_caller_that_has_seen_enough_sees_no_more() {
        let mut seen = 0;
        let enough = outline("a = 1\nb = 2\n", |_, _| {
            seen += 1;
            Enough::Yes
        });
        assert_eq!((seen, enough), (1, Enough::Yes));
    }
}
