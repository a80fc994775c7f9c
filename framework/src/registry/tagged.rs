//! Plug-ins inside other values: found by their `type` in the registry, so that those are found that were added.

use std::fmt;

use serde::{
    Deserialize, Deserializer,
    de::{self, MapAccess, SeqAccess, Visitor},
};
use toml::{Table, Value, de::ValueDeserializer};

use super::{PluginKind, find};
use crate::{
    plugin::{AnyConstraint, AnyReference, AnyTask},
    suggestion::suggestion,
};

macro_rules! by_type {
    ($($kind:ident),*) => {
        $(
            impl<'de> Deserialize<'de> for Box<dyn $kind> {
                fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                    load(deserializer)
                }
            }
        )*
    };
}

by_type!(AnyTask, AnyConstraint, AnyReference);

fn load<'de, P: PluginKind + ?Sized, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Box<P>, D::Error> {
    let Some(Value::Table(mut keys)) = Tree::deserialize(deserializer)?.0 else {
        let message = format!("expected a table that names a {}", P::NAME);
        return Err(de::Error::custom(message));
    };
    let Some(Value::String(tag)) = keys.remove("type") else {
        return Err(de::Error::missing_field("type"));
    };
    let plugin = find::<P>(&tag).ok_or_else(|| {
        let known: Vec<_> = P::plugins().iter().map(|plugin| plugin.tag).collect();
        let hint = suggestion(&tag, &known);
        de::Error::custom(format!("unknown {} type `{tag}`{hint}", P::NAME))
    })?;
    let text = Value::Table(keys).to_string();
    let keys = ValueDeserializer::parse(&text).map_err(de::Error::custom)?;
    (plugin.load)(keys).map_err(|error| de::Error::custom(error.message()))
}

/// A value of any format; nothing where the format says `null`, which TOML cannot.
struct Tree(Option<Value>);

impl<'de> Deserialize<'de> for Tree {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(TreeVisitor).map(Self)
    }
}

struct TreeVisitor;

impl<'de> Visitor<'de> for TreeVisitor {
    type Value = Option<Value>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a value")
    }

    fn visit_bool<E>(self, value: bool) -> Result<Self::Value, E> {
        Ok(Some(value.into()))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Self::Value, E> {
        Ok(Some(value.into()))
    }

    fn visit_u64<E: de::Error>(self, value: u64) -> Result<Self::Value, E> {
        let value = i64::try_from(value).map_err(E::custom)?;
        Ok(Some(value.into()))
    }

    fn visit_f64<E>(self, value: f64) -> Result<Self::Value, E> {
        Ok(Some(value.into()))
    }

    fn visit_str<E>(self, value: &str) -> Result<Self::Value, E> {
        Ok(Some(value.into()))
    }

    fn visit_none<E>(self) -> Result<Self::Value, E> {
        Ok(None)
    }

    fn visit_unit<E>(self) -> Result<Self::Value, E> {
        Ok(None)
    }

    fn visit_some<D: Deserializer<'de>>(self, inner: D) -> Result<Self::Value, D::Error> {
        inner.deserialize_any(self)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Self::Value, A::Error> {
        let mut list = Vec::new();
        while let Some(Tree(item)) = items.next_element()? {
            list.push(item.ok_or_else(|| de::Error::custom("null in a list"))?);
        }
        Ok(Some(Value::Array(list)))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Self::Value, A::Error> {
        let mut table = Table::new();
        while let Some((key, Tree(value))) = entries.next_entry::<String, Tree>()? {
            if let Some(value) = value {
                table.insert(key, value);
            }
        }
        Ok(Some(Value::Table(table)))
    }
}
