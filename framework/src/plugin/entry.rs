//! The framework's entry around a plug-in: name, weight, activation, transition, hardness.

use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, de};

use crate::plugin::{AnyConstraint, AnyTask};

/// A task or constraint with what the framework needs to know about it.
#[derive(Debug)]
pub struct Entry<P: ?Sized> {
    /// Unique name: how logs, reports, errors and events call it.
    pub name: String,
    /// Weight of the rows, **linear**: cost `w r²`, unit 1/unit(row)². Hard equality rows have it only while they
    /// ramp, as a cost that becomes hard at the end.
    pub weight: Weight,
    /// Whether it is on at the start.
    pub active: bool,
    /// Duration of the weight's ramp when it is switched or given another weight, s.
    pub transition: f64,
    /// Hard or soft.
    pub hardness: Hardness,
    /// The plug-in.
    pub plugin: Box<P>,
}

impl<P: ?Sized> Entry<P> {
    /// An active entry without ramp; tasks are usually [`Hardness::Soft`], constraints [`Hardness::Hard`].
    pub fn new(name: &str, weight: impl Into<Weight>, hardness: Hardness, plugin: Box<P>) -> Self {
        Self {
            name: name.to_owned(),
            weight: weight.into(),
            active: true,
            transition: 0.0,
            hardness,
            plugin,
        }
    }
}

impl Entry<dyn AnyTask> {
    /// A task whose rows cost `w r²`.
    pub fn task(name: &str, weight: impl Into<Weight>, task: impl AnyTask) -> Self {
        Self::new(name, weight, Hardness::Soft, Box::new(task))
    }

    /// A task that must be fulfilled: strict priority over all soft ones.
    pub fn hard_task(name: &str, task: impl AnyTask) -> Self {
        Self::new(name, 1.0, Hardness::Hard, Box::new(task))
    }
}

impl Entry<dyn AnyConstraint> {
    /// A constraint that must hold.
    pub fn constraint(name: &str, constraint: impl AnyConstraint) -> Self {
        Self::new(name, 1.0, Hardness::Hard, Box::new(constraint))
    }

    /// A constraint that may be violated at a price: equalities cost `w r²`, inequalities `w s²` with their slack `s`.
    pub fn soft_constraint(
        name: &str,
        weight: impl Into<Weight>,
        constraint: impl AnyConstraint,
    ) -> Self {
        Self::new(name, weight, Hardness::Soft, Box::new(constraint))
    }
}

impl<P: ?Sized> Entry<P> {
    /// Off at the start.
    pub fn inactive(self) -> Self {
        Self {
            active: false,
            ..self
        }
    }

    /// With a ramp of this duration, s, when it is switched or given another weight.
    pub fn with_transition(self, transition: f64) -> Self {
        Self { transition, ..self }
    }

    /// With this hardness.
    pub fn with_hardness(self, hardness: Hardness) -> Self {
        Self { hardness, ..self }
    }
}

/// One weight for all rows, or one per row.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Weight {
    /// The same for every row.
    Uniform(f64),
    /// One per row.
    PerRow(Vec<f64>),
}

impl Weight {
    /// Weight of a row.
    pub fn row(&self, index: usize) -> f64 {
        match self {
            Self::Uniform(w) => *w,
            Self::PerRow(w) => w.get(index).copied().unwrap_or(0.0),
        }
    }

    /// All values given.
    pub fn values(&self) -> &[f64] {
        match self {
            Self::Uniform(w) => std::slice::from_ref(w),
            Self::PerRow(w) => w,
        }
    }
}

impl From<f64> for Weight {
    fn from(w: f64) -> Self {
        Self::Uniform(w)
    }
}

impl From<Vec<f64>> for Weight {
    fn from(w: Vec<f64>) -> Self {
        Self::PerRow(w)
    }
}

// Written by hand because `untagged` would say only "did not match any variant".
impl<'de> Deserialize<'de> for Weight {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl<'de> de::Visitor<'de> for Visitor {
            type Value = Weight;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number or a list of numbers, one per row")
            }

            fn visit_f64<E>(self, w: f64) -> Result<Weight, E> {
                Ok(Weight::Uniform(w))
            }

            fn visit_i64<E>(self, w: i64) -> Result<Weight, E> {
                Ok(Weight::Uniform(w as f64))
            }

            fn visit_u64<E>(self, w: u64) -> Result<Weight, E> {
                Ok(Weight::Uniform(w as f64))
            }

            fn visit_seq<A: de::SeqAccess<'de>>(self, mut seq: A) -> Result<Weight, A::Error> {
                let mut rows = Vec::new();
                while let Some(w) = seq.next_element()? {
                    rows.push(w);
                }
                Ok(Weight::PerRow(rows))
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

/// Whether rows must hold or are paid for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Hardness {
    /// Rows hold wherever the problem is feasible. A hard task is a strict priority.
    Hard,
    /// Equality rows cost `w r²`; each group of inequality rows shares a slack `s ≥ 0` that costs `w s²`.
    #[default]
    Soft,
    /// Inequality rows share a slack that costs `w s² + λ s`; exact (never violated when it can be helped)
    /// for λ above the largest multiplier.
    Exact(f64),
}
