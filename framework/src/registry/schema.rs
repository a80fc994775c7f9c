//! The keys that a JSON Schema allows, and where in it plug-ins are nested.

use serde_json::{Map, Value};

/// The weight that a plug-in declares.
pub(crate) const WEIGHT: &str = "x-weight";
/// The key of a stiffness, at that of its damping.
pub(crate) const CRITICAL: &str = "x-critical";

/// `$ref`s are followed this far; schemas of plain data are shallower.
const MAX_REFS: usize = 16;

/// A place in a JSON Schema.
#[derive(Clone, Copy)]
pub(crate) struct Node<'s> {
    root: &'s Value,
    here: &'s Value,
}

/// Keys of a table that takes no others, sorted.
pub(crate) struct Keys<'s> {
    pub(crate) known: Vec<&'s str>,
    pub(crate) required: Vec<&'s str>,
}

impl<'s> Node<'s> {
    pub(crate) fn root(schema: &'s Value) -> Self {
        Self {
            root: schema,
            here: schema,
        }
        .resolved()
    }

    /// Follows `$ref` and the two branches of an optional value.
    fn resolved(mut self) -> Self {
        for _ in 0..MAX_REFS {
            let target = if let Some(reference) = self.here.get("$ref").and_then(Value::as_str) {
                reference
                    .strip_prefix('#')
                    .and_then(|pointer| self.root.pointer(pointer))
            } else {
                self.only_branch()
            };
            match target {
                Some(here) => self.here = here,
                None => break,
            }
        }
        self
    }

    /// The branch of an `anyOf` whose others are `null`, or of an `allOf` of one.
    fn only_branch(self) -> Option<&'s Value> {
        let branches = ["anyOf", "oneOf", "allOf"]
            .iter()
            .find_map(|key| self.here.get(key))?
            .as_array()?;
        let mut real = branches
            .iter()
            .filter(|branch| branch.get("type").and_then(Value::as_str) != Some("null"));
        match (real.next(), real.next()) {
            (Some(branch), None) if self.here.get("properties").is_none() => Some(branch),
            _ => None,
        }
    }

    /// The schema's text at this place.
    pub(crate) fn value(self) -> &'s Value {
        self.here
    }

    /// Another place of the same schema, with references followed.
    pub(crate) fn at(self, here: &'s Value) -> Self {
        Self { here, ..self }.resolved()
    }

    pub(crate) fn properties(self) -> Option<&'s Map<String, Value>> {
        self.here.get("properties").and_then(Value::as_object)
    }

    /// The kind of plug-in that belongs here, if one does.
    pub(crate) fn plugin(self) -> Option<&'s str> {
        self.here.get("x-plugin").and_then(Value::as_str)
    }

    /// All property names, also of a table that takes others as well.
    pub(crate) fn property_names(self) -> impl Iterator<Item = &'s str> {
        self.properties()
            .into_iter()
            .flat_map(|properties| properties.keys().map(String::as_str))
    }

    /// The keys, if this is a table that takes no others.
    pub(crate) fn keys(self) -> Option<Keys<'s>> {
        let is_object = match self.here.get("type") {
            Some(Value::String(name)) => name == "object",
            Some(Value::Array(names)) => names.iter().any(|name| name == "object"),
            _ => false,
        };
        let others = self
            .here
            .get("additionalProperties")
            .is_some_and(|others| others != &Value::Bool(false))
            || ["anyOf", "oneOf", "allOf", "patternProperties"]
                .iter()
                .any(|key| self.here.get(key).is_some());
        if !is_object || others {
            return None;
        }
        let required = self.here.get("required").and_then(Value::as_array);
        Some(Keys {
            known: self.property_names().collect(),
            required: required
                .into_iter()
                .flatten()
                .filter_map(Value::as_str)
                .collect(),
        })
    }

    /// What the value of a key must be.
    pub(crate) fn property(self, key: &str) -> Option<Self> {
        let here = self
            .properties()
            .and_then(|properties| properties.get(key))
            .or_else(|| self.here.get("additionalProperties"))?;
        Some(self.at(here))
    }

    /// What the value of a key is, as a part of a sentence: the first of its description, and the words that it may be.
    pub(crate) fn meaning(self, key: &str) -> Option<String> {
        let here = self.properties()?.get(key)?;
        let value = self.at(here);
        let described = [here, value.here].into_iter();
        let mut described = described.filter_map(|at| at.get("description")?.as_str());
        let text = described.next()?;
        let sentence = text.split_once(". ").map_or(text, |(first, _)| first);
        let sentence = sentence.trim_end_matches('.');
        let mut letters = sentence.chars();
        let first = letters.next()?;
        // A name or a symbol keeps its first letter.
        let is_word = letters.next().is_some_and(char::is_lowercase);
        let mut out: String = if is_word {
            let rest = sentence.chars().skip(1);
            first.to_lowercase().chain(rest).collect()
        } else {
            sentence.to_owned()
        };
        let words = value.words();
        if !words.is_empty() {
            out += &format!(" (one of {})", words.join(", "));
        }
        Some(out)
    }

    /// The words that a value may be, if it is a choice.
    fn words(self) -> Vec<String> {
        let listed = self.here.get("enum").and_then(Value::as_array);
        let branches = self.here.get("oneOf").and_then(Value::as_array);
        let consts = branches
            .into_iter()
            .flatten()
            .map(|branch| branch.get("const"));
        let all: Option<Vec<&Value>> = match listed {
            Some(listed) => Some(listed.iter().collect()),
            None => consts.collect(),
        };
        let words = all.into_iter().flatten().filter_map(Value::as_str);
        words.map(|word| format!("\"{word}\"")).collect()
    }

    /// Whether this is a table and nothing else.
    pub(crate) fn is_table(self) -> bool {
        self.here.get("type").and_then(Value::as_str) == Some("object")
    }

    /// How many elements a list may have, if that is fixed.
    pub(crate) fn most_elements(self) -> Option<usize> {
        let is_list = self.here.get("type").and_then(Value::as_str) == Some("array");
        let most = self.here.get("maxItems").and_then(Value::as_u64);
        most.filter(|_| is_list)
            .and_then(|most| usize::try_from(most).ok())
    }

    /// What the elements of a list must be.
    pub(crate) fn element(self) -> Option<Self> {
        self.here.get("items").map(|here| self.at(here))
    }
}
