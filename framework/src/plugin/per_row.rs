//! How numbers of which each row of a task may have its own are given and checked.

use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, de};

use crate::error::BindError;

/// One number for all rows, or a list with one per row: a weight, or a diagonal gain matrix.
///
/// ```
/// use wbqp::{plugin::PerRow, serde_json};
/// assert_eq!(serde_json::from_str::<PerRow>("25")?, PerRow::from(25.0));
/// assert_eq!(serde_json::from_str::<PerRow>("[1, 2.5]")?, PerRow::from([1.0, 2.5]));
/// # Ok::<(), serde_json::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum PerRow {
    /// The same for every row.
    Uniform(f64),
    /// One per row.
    Each(Vec<f64>),
}

impl PerRow {
    /// All numbers given.
    pub fn values(&self) -> &[f64] {
        match self {
            Self::Uniform(x) => std::slice::from_ref(x),
            Self::Each(x) => x,
        }
    }

    /// Checks gains: finite, not negative, and one per row if they are a list.
    ///
    /// # Errors
    /// [`BindError`] naming `key`.
    pub fn validate(&self, key: &str, rows: usize) -> Result<(), BindError> {
        if let Self::Each(x) = self
            && x.len() != rows
        {
            let expected = format!("{rows}, one per row, or one number for all");
            return Err(BindError::length(key, x.len(), expected));
        }
        let bad = |x: &f64| !(x.is_finite() && *x >= 0.0);
        match self.values().iter().position(bad) {
            None => Ok(()),
            Some(row) => {
                let key = match self {
                    Self::Uniform(_) => key.to_owned(),
                    Self::Each(_) => format!("{key}[{row}]"),
                };
                let problem = format!("is {}, must be finite and not negative", self.row(row));
                Err(BindError::value(&key, problem))
            }
        }
    }
}

impl From<f64> for PerRow {
    fn from(x: f64) -> Self {
        Self::Uniform(x)
    }
}

impl From<Vec<f64>> for PerRow {
    fn from(x: Vec<f64>) -> Self {
        Self::Each(x)
    }
}

impl<const N: usize> From<[f64; N]> for PerRow {
    fn from(x: [f64; N]) -> Self {
        Self::Each(x.to_vec())
    }
}

// Written by hand because `untagged` would say only "did not match any variant".
impl<'de> Deserialize<'de> for PerRow {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl<'de> de::Visitor<'de> for Visitor {
            type Value = PerRow;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number or a list of numbers, one per row")
            }

            fn visit_f64<E>(self, w: f64) -> Result<PerRow, E> {
                Ok(PerRow::Uniform(w))
            }

            fn visit_i64<E>(self, w: i64) -> Result<PerRow, E> {
                Ok(PerRow::Uniform(w as f64))
            }

            fn visit_u64<E>(self, w: u64) -> Result<PerRow, E> {
                Ok(PerRow::Uniform(w as f64))
            }

            fn visit_seq<A: de::SeqAccess<'de>>(self, mut seq: A) -> Result<PerRow, A::Error> {
                let mut rows = Vec::new();
                while let Some(w) = seq.next_element()? {
                    rows.push(w);
                }
                Ok(PerRow::Each(rows))
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;

    #[test]
    fn numbers_and_lists_survive_a_round_trip() {
        for text in ["25.0", "[1.0,2.5,0.0]"] {
            let gains: PerRow = serde_json::from_str(text).unwrap();
            assert_eq!(serde_json::to_string(&gains).unwrap(), text);
        }
        assert_eq!(
            serde_json::from_str::<PerRow>("7").unwrap(),
            PerRow::from(7.0)
        );
        assert_eq!(
            serde_json::from_str::<PerRow>("-7").unwrap(),
            PerRow::from(-7.0)
        );
    }

    #[test]
    fn anything_else_is_refused_in_words() {
        for text in ["\"soft\"", "true", "{}"] {
            let error = serde_json::from_str::<PerRow>(text)
                .unwrap_err()
                .to_string();
            assert!(
                error.contains("expected a number or a list of numbers"),
                "{error}"
            );
        }
        let error = serde_json::from_str::<PerRow>("[1, \"a\"]")
            .unwrap_err()
            .to_string();
        assert!(error.contains("expected f64"), "{error}");
    }

    #[test]
    fn validation_names_the_key() {
        assert!(PerRow::from(3.0).validate("kp", 7).is_ok());
        assert!(PerRow::from([1.0, 0.0]).validate("kp", 2).is_ok());
        for bad in [
            PerRow::from([1.0, 2.0, 3.0]),
            PerRow::from([]),
            PerRow::from([1.0, -2.0]),
            PerRow::from(-1.0),
            PerRow::from(f64::NAN),
            PerRow::from(f64::INFINITY),
        ] {
            let error = bad.validate("kp", 2).unwrap_err().to_string();
            assert!(error.starts_with("`kp"), "{error}");
        }
    }

    #[test]
    fn a_missing_axis_has_no_gain() {
        let gains = PerRow::from([1.0, 2.0]);
        assert_eq!(
            gains.times(&Vector3::new(1.0, 1.0, 1.0)),
            Vector3::new(1.0, 2.0, 0.0)
        );
    }
}
