//! Whose a place in a rotor parameter file is, for messages about what its structures refuse.

use std::collections::BTreeMap;

use serde::Deserialize;
use toml::{Spanned, Value};
use wbqp::{robot::RobotError, suggestion::suggestion};

use crate::source::Source;

type Keys = BTreeMap<Spanned<String>, Spanned<Value>>;

/// A file's keys, whatever they are and have as values.
#[derive(Deserialize)]
struct Loose {
    #[serde(default)]
    defaults: Keys,
    #[serde(default)]
    rotor: Vec<Spanned<Keys>>,
}

/// The error of a file that is no rotor parameter file, with the rotor and the key that it is about.
pub(crate) fn refused(source: &Source<'_>, error: &toml::de::Error) -> Option<RobotError> {
    let at = error.span()?.start;
    let loose: Loose = toml::from_str(source.text).ok()?;
    let has_key = |(key, value): &(&Spanned<String>, &Spanned<Value>)| {
        key.span().contains(&at) || value.span().contains(&at)
    };
    // The span of a table may be its header's alone.
    let is_there =
        |r: &&Spanned<Keys>| r.span().contains(&at) || r.get_ref().iter().any(|k| has_key(&k));
    let rotor = loose.rotor.iter().find(is_there);
    let (element, keys) = if let Some(rotor) = rotor {
        let keys = rotor.get_ref();
        let name = keys.iter().find(|(key, _)| key.get_ref() == "name");
        let name = name.and_then(|(_, value)| value.get_ref().as_str());
        let element = name.map_or_else(
            || "a rotor without a name".to_owned(),
            |name| format!("rotor `{name}`"),
        );
        (element, keys)
    } else {
        loose.defaults.iter().find(has_key)?;
        ("[defaults]".to_owned(), &loose.defaults)
    };
    let message = error.message();
    let what = match keys.iter().find(has_key) {
        Some((key, _)) if key.span().contains(&at) => unknown(key.get_ref(), message),
        Some((key, _)) => format!("`{}`: {message}", key.get_ref()),
        None => message.to_owned(),
    };
    Some(source.error(at, &element, what))
}

/// Words for a key that its table does not have; the message ends with a list, in backticks, of those that it has.
fn unknown(key: &str, message: &str) -> String {
    let list = message.rsplit(", expected ").next().unwrap_or_default();
    let known: Vec<&str> = list.split('`').skip(1).step_by(2).collect();
    format!("unknown field `{key}`{}", suggestion(key, &known))
}
