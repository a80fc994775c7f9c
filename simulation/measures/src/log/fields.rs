//! Numbers of a JSON text by their pointers (RFC 6901), without the rest: a message has a hundred numbers, and a figure
//! wants three of them.

use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde_json::Error;

/// A set of pointers, as a tree of their names.
#[derive(Clone, Debug, Default)]
pub(super) struct Fields {
    root: Node,
}

/// What pointers have in common.
#[derive(Clone, Debug, Default)]
struct Node {
    /// Which of the pointers end here.
    here: Vec<usize>,
    inner: Vec<(String, Node)>,
}

impl Fields {
    /// Of the pointers in their order; one that does not begin with `/` leads nowhere.
    pub(super) fn new(pointers: &[String]) -> Self {
        let mut root = Node::default();
        for (index, pointer) in pointers.iter().enumerate() {
            let mut node = &mut root;
            let mut names = pointer.split('/');
            // Before the first `/` there is nothing.
            if names.next() != Some("") {
                continue;
            }
            for name in names {
                node = node.inner(&name.replace("~1", "/").replace("~0", "~"));
            }
            node.here.push(index);
        }
        Self { root }
    }

    /// Writes the numbers of a text, true as 1 and false as 0, what is no number as NaN. What is not there stays.
    ///
    /// # Errors
    /// A text that is not JSON.
    pub(super) fn read(&self, text: &[u8], out: &mut [f64]) -> Result<(), Error> {
        let mut source = serde_json::Deserializer::from_slice(text);
        Found {
            node: &self.root,
            out,
        }
        .deserialize(&mut source)?;
        source.end()
    }
}

impl Node {
    fn inner(&mut self, name: &str) -> &mut Self {
        let at = self.inner.iter().position(|(other, _)| other == name);
        let at = at.unwrap_or_else(|| {
            self.inner.push((name.to_owned(), Self::default()));
            self.inner.len() - 1
        });
        &mut self.inner[at].1
    }

    fn get(&self, name: &str) -> Option<&Self> {
        let mut inner = self.inner.iter();
        inner.find(|(other, _)| other == name).map(|(_, node)| node)
    }
}

/// The value at a node.
struct Found<'n, 'o> {
    node: &'n Node,
    out: &'o mut [f64],
}

impl Found<'_, '_> {
    fn set(self, value: f64) {
        for &index in &self.node.here {
            self.out[index] = value;
        }
    }
}

impl<'de> DeserializeSeed<'de> for Found<'_, '_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, source: D) -> Result<(), D::Error> {
        source.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Found<'_, '_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a value")
    }

    fn visit_bool<E>(self, value: bool) -> Result<(), E> {
        self.set(f64::from(u8::from(value)));
        Ok(())
    }

    fn visit_i64<E>(self, value: i64) -> Result<(), E> {
        self.set(value as f64);
        Ok(())
    }

    fn visit_u64<E>(self, value: u64) -> Result<(), E> {
        self.set(value as f64);
        Ok(())
    }

    fn visit_f64<E>(self, value: f64) -> Result<(), E> {
        self.set(value);
        Ok(())
    }

    fn visit_str<E>(self, _: &str) -> Result<(), E> {
        self.set(f64::NAN);
        Ok(())
    }

    fn visit_unit<E>(self) -> Result<(), E> {
        self.set(f64::NAN);
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        while let Some(node) = map.next_key_seed(Name { of: self.node })? {
            match node {
                None => {
                    map.next_value::<IgnoredAny>()?;
                }
                Some(node) => {
                    let out = &mut *self.out;
                    map.next_value_seed(Found { node, out })?;
                }
            }
        }
        self.set(f64::NAN);
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<(), A::Error> {
        for index in 0_usize.. {
            let node = if self.node.inner.is_empty() {
                None
            } else {
                self.node.get(&index.to_string())
            };
            let more = match node {
                None => seq.next_element::<IgnoredAny>()?.is_some(),
                Some(node) => {
                    let out = &mut *self.out;
                    seq.next_element_seed(Found { node, out })?.is_some()
                }
            };
            if !more {
                break;
            }
        }
        self.set(f64::NAN);
        Ok(())
    }
}

/// A key, as the node that it leads to.
struct Name<'n> {
    of: &'n Node,
}

impl<'de, 'n> DeserializeSeed<'de> for Name<'n> {
    type Value = Option<&'n Node>;

    fn deserialize<D: Deserializer<'de>>(self, source: D) -> Result<Self::Value, D::Error> {
        source.deserialize_str(self)
    }
}

impl<'n> Visitor<'_> for Name<'n> {
    type Value = Option<&'n Node>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a key")
    }

    fn visit_str<E>(self, name: &str) -> Result<Self::Value, E> {
        Ok(self.of.get(name))
    }
}

#[cfg(test)]
mod tests {
    use serde_json::Value;

    use super::Fields;

    /// What `serde_json` finds by the same pointers in the whole value.
    #[test]
    fn numbers_are_those_of_the_whole_value() {
        let pointers = [
            "", "/", "/a", "/a/b", "/a/b/c", "/a/0", "/a/1", "/a/01", "/a/-", "/a~1b", "/a~0b",
            "/é", "a", "/a/b/", "/a",
        ];
        let pointers = pointers.map(str::to_owned);
        let fields = Fields::new(&pointers);
        for text in [
            "3.5",
            "{}",
            r#"{"a": 1e-3, "": 7, "a/b": -2, "a~b": true, "é": 18446744073709551615}"#,
            r#"{"a": {"b": 0.1, "0": false, "1": null}, "other": {"a": 5}}"#,
            r#"{"other": [1, {"a": 2}], "a": {"b": {"c": -7, "": 1e300}}}"#,
            r#"{"a": [1.25, [2], "x"], "": "text"}"#,
            r#"{"a": [[], -0.0], "\u00e9": 2}"#,
            r#"{"a": "1", "a/b": [], "a~b": {}}"#,
            "[1, 2]",
        ] {
            let value: Value = serde_json::from_str(text).unwrap();
            let mut numbers = vec![f64::NAN; pointers.len()];
            fields.read(text.as_bytes(), &mut numbers).unwrap();
            for (pointer, number) in pointers.iter().zip(&numbers) {
                let expected = match value.pointer(pointer) {
                    Some(Value::Bool(is)) => f64::from(u8::from(*is)),
                    other => other.and_then(Value::as_f64).unwrap_or(f64::NAN),
                };
                assert_eq!(number.to_bits(), expected.to_bits(), "{pointer} of {text}");
            }
        }
        for text in ["", "{", "{\"a\": 1} x", "{\"a\": nan}"] {
            let mut numbers = vec![f64::NAN; pointers.len()];
            assert!(
                fields.read(text.as_bytes(), &mut numbers).is_err(),
                "{text}"
            );
        }
    }
}
