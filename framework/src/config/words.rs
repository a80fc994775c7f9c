//! Serde's messages in the words of the format.

use crate::suggestion::suggestion;

/// What serde says of a value, in the words of the format: `expected f64` is `expected a number`.
pub fn in_words(message: &str) -> String {
    let mut text = message.trim_end().to_owned();
    if let Some(words) = of_unknown_key(&text) {
        return words;
    }
    if let Some(key) = text
        .strip_prefix("missing field `")
        .and_then(|rest| rest.strip_suffix('`'))
    {
        return format!("key `{key}` is missing");
    }
    if ["number overflowed", "` as i128", "` as u128"]
        .iter()
        .any(|said| text.contains(said))
    {
        return "is a whole number of more than 64 bits: write it with an exponent, as 1e20"
            .to_owned();
    }
    for (rust, words) in [
        ("unknown variant `", "unknown value `"),
        ("invalid type: floating point `", "invalid type: number `"),
        ("invalid type: sequence", "invalid type: list"),
        ("invalid type: map", "invalid type: table"),
        ("an array of length ", "a list of length "),
        ("expected a sequence", "expected a list"),
        ("expected a map", "expected a table"),
        ("expected f64", "expected a number"),
        ("expected struct ", "expected a table: "),
        (
            "wanted string or table",
            "must be a name, as a string: `\"name\"`",
        ),
        (
            "invalid type: unit variant, expected newtype variant",
            "is a name without a value, and wants one: `{ name = value }`",
        ),
        (
            "invalid type: newtype variant, expected unit variant",
            "is a name with a value, and wants none: `\"name\"`",
        ),
    ] {
        text = text.replace(rust, words);
    }
    // Of one that is not too small there is more to say.
    if text.starts_with("invalid value: integer `") && !text.contains("`-") {
        for (integer, most) in [
            ("u8", u32::from(u8::MAX)),
            ("u16", u32::from(u16::MAX)),
            ("u32", u32::MAX),
        ] {
            text = text.replace(
                &format!("expected {integer}"),
                &format!("expected an integer from 0 to {most}"),
            );
        }
    }
    for integer in ["u8", "u16", "u32", "u64", "usize"] {
        text = text.replace(
            &format!("expected {integer}"),
            "expected an integer, 0 or more",
        );
    }
    for integer in ["i8", "i16", "i32", "i64", "isize"] {
        text = text.replace(&format!("expected {integer}"), "expected an integer");
    }
    text
}

/// Of a key that is not there: which are, and which was meant.
fn of_unknown_key(message: &str) -> Option<String> {
    let (name, expected) = message
        .strip_prefix("unknown field `")?
        .split_once("`, expected ")?;
    let mut known: Vec<&str> = expected.split('`').skip(1).step_by(2).collect();
    known.sort_unstable();
    Some(format!("unknown key `{name}`{}", suggestion(name, &known)))
}
