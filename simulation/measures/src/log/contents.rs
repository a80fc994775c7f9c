//! What a topic's messages have.

use std::collections::{BTreeMap, HashSet};

use serde_json::Value;

use super::Log;
use crate::{MeasureError, escaped};

/// What a topic's messages have, of all of them: a contact that is off says less than one that is on.
#[derive(Clone, Debug, Default)]
pub struct Contents {
    /// Times of the messages, s.
    pub times: Vec<f64>,
    /// Pointers (RFC 6901) to numbers, truth values and what is `null` everywhere, in the order of the messages.
    pub numbers: Vec<String>,
    /// Pointers to texts, and the text of each message.
    pub texts: BTreeMap<String, Vec<Option<String>>>,
}

impl Contents {
    /// Of a topic.
    ///
    /// # Errors
    /// [`MeasureError::Topic`], [`MeasureError::Unreadable`].
    pub(super) fn of(log: &Log, topic: &str) -> Result<Self, MeasureError> {
        let mut contents = Self::default();
        let mut known = HashSet::new();
        for (index, message) in log.messages(topic)?.enumerate() {
            let (time, message) = message?;
            contents.times.push(time);
            let mut see = |path: &str, value: &Value| match value {
                Value::String(text) => {
                    if !contents.texts.contains_key(path) {
                        contents.texts.insert(path.to_owned(), Vec::new());
                    }
                    if let Some(texts) = contents.texts.get_mut(path) {
                        texts.resize(index, None);
                        texts.push(Some(text.clone()));
                    }
                }
                _ if !known.contains(path) => {
                    known.insert(path.to_owned());
                    contents.numbers.push(path.to_owned());
                }
                _ => {}
            };
            leaves(&message, &mut String::new(), &mut see);
        }
        let Self {
            times,
            numbers,
            texts,
        } = &mut contents;
        for texts in texts.values_mut() {
            texts.resize(times.len(), None);
        }
        // `null` where there is no text.
        numbers.retain(|path| !texts.contains_key(path));
        Ok(contents)
    }
}

/// Shows every number, text, truth value and `null` with the pointer to it.
fn leaves(value: &Value, path: &mut String, see: &mut impl FnMut(&str, &Value)) {
    match value {
        Value::Object(object) => {
            let length = path.len();
            for (name, inner) in object {
                path.push('/');
                path.push_str(&escaped(name));
                leaves(inner, path, see);
                path.truncate(length);
            }
        }
        Value::Array(items) => {
            let length = path.len();
            for (i, inner) in items.iter().enumerate() {
                path.push('/');
                path.push_str(&i.to_string());
                leaves(inner, path, see);
                path.truncate(length);
            }
        }
        leaf => see(path, leaf),
    }
}
