//! Feedback gains: one number for all axes, or one per axis.

use std::fmt;

use wbqp::{
    error::BindError,
    nalgebra::Vector3,
    schemars::JsonSchema,
    serde::{Deserialize, Deserializer, Serialize, de},
};

use crate::check;

/// A diagonal gain matrix: one number for all axes, or a list with one per axis.
///
/// ```
/// use wbqp::serde_json;
/// use wbqp_tasks::Gain;
/// assert_eq!(serde_json::from_str::<Gain>("25")?, Gain::from(25.0));
/// assert_eq!(serde_json::from_str::<Gain>("[1, 2.5]")?, Gain::from([1.0, 2.5]));
/// # Ok::<(), serde_json::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(crate = "wbqp::serde", untagged)]
#[schemars(crate = "wbqp::schemars")]
pub enum Gain {
    /// The same for every axis.
    Uniform(f64),
    /// One per axis.
    PerAxis(Vec<f64>),
}

impl Gain {
    /// Gain of an axis; zero for one that is missing.
    pub fn axis(&self, index: usize) -> f64 {
        match self {
            Self::Uniform(k) => *k,
            Self::PerAxis(k) => k.get(index).copied().unwrap_or(0.0),
        }
    }

    /// The gain matrix times a 3-vector.
    pub fn times(&self, x: &Vector3<f64>) -> Vector3<f64> {
        Vector3::from_fn(|i, _| self.axis(i) * x[i])
    }

    /// All values given.
    pub fn values(&self) -> &[f64] {
        match self {
            Self::Uniform(k) => std::slice::from_ref(k),
            Self::PerAxis(k) => k,
        }
    }

    /// Checks the numbers: finite, not negative, and one per axis if they are a list.
    ///
    /// # Errors
    /// [`BindError`] naming `key`.
    pub fn validate(&self, key: &str, axes: usize) -> Result<(), BindError> {
        if let Self::PerAxis(k) = self
            && k.len() != axes
        {
            let expected = format!("{axes}, one per axis, or one number for all");
            return Err(BindError::length(key, k.len(), expected));
        }
        for (axis, k) in self.values().iter().enumerate() {
            let key = match self {
                Self::Uniform(_) => key.to_owned(),
                Self::PerAxis(_) => format!("{key}[{axis}]"),
            };
            check::not_negative(&key, *k)?;
        }
        Ok(())
    }
}

impl From<f64> for Gain {
    fn from(k: f64) -> Self {
        Self::Uniform(k)
    }
}

impl From<Vec<f64>> for Gain {
    fn from(k: Vec<f64>) -> Self {
        Self::PerAxis(k)
    }
}

impl<const N: usize> From<[f64; N]> for Gain {
    fn from(k: [f64; N]) -> Self {
        Self::PerAxis(k.to_vec())
    }
}

// Written by hand because `untagged` would say only "did not match any variant".
impl<'de> Deserialize<'de> for Gain {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl<'de> de::Visitor<'de> for Visitor {
            type Value = Gain;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number or a list of numbers, one per axis")
            }

            fn visit_f64<E>(self, k: f64) -> Result<Gain, E> {
                Ok(Gain::Uniform(k))
            }

            fn visit_i64<E>(self, k: i64) -> Result<Gain, E> {
                Ok(Gain::Uniform(k as f64))
            }

            fn visit_u64<E>(self, k: u64) -> Result<Gain, E> {
                Ok(Gain::Uniform(k as f64))
            }

            fn visit_seq<A: de::SeqAccess<'de>>(self, mut seq: A) -> Result<Gain, A::Error> {
                let mut axes = Vec::new();
                while let Some(k) = seq.next_element()? {
                    axes.push(k);
                }
                Ok(Gain::PerAxis(axes))
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

#[cfg(test)]
mod tests {
    use wbqp::serde_json;

    use super::*;

    #[test]
    fn numbers_and_lists_survive_a_round_trip() {
        for text in ["25.0", "[1.0,2.5,0.0]"] {
            let gain: Gain = serde_json::from_str(text).unwrap();
            assert_eq!(serde_json::to_string(&gain).unwrap(), text);
        }
        assert_eq!(serde_json::from_str::<Gain>("7").unwrap(), Gain::from(7.0));
        assert_eq!(
            serde_json::from_str::<Gain>("-7").unwrap(),
            Gain::from(-7.0)
        );
    }

    #[test]
    fn anything_else_is_refused_in_words() {
        for text in ["\"soft\"", "true", "{}"] {
            let error = serde_json::from_str::<Gain>(text).unwrap_err().to_string();
            assert!(
                error.contains("expected a number or a list of numbers"),
                "{error}"
            );
        }
        let error = serde_json::from_str::<Gain>("[1, \"a\"]")
            .unwrap_err()
            .to_string();
        assert!(error.contains("expected f64"), "{error}");
    }

    #[test]
    fn validation_names_the_key() {
        assert!(Gain::from(3.0).validate("kp", 7).is_ok());
        assert!(Gain::from([1.0, 0.0]).validate("kp", 2).is_ok());
        for bad in [
            Gain::from([1.0, 2.0, 3.0]),
            Gain::from([]),
            Gain::from([1.0, -2.0]),
            Gain::from(-1.0),
            Gain::from(f64::NAN),
            Gain::from(f64::INFINITY),
        ] {
            let error = bad.validate("kp", 2).unwrap_err().to_string();
            assert!(error.starts_with("`kp"), "{error}");
        }
    }

    #[test]
    fn a_missing_axis_has_no_gain() {
        let gain = Gain::from([1.0, 2.0]);
        assert_eq!(
            gain.times(&Vector3::new(1.0, 1.0, 1.0)),
            Vector3::new(1.0, 2.0, 0.0)
        );
    }
}
