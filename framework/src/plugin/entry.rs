//! The framework's entry around a plug-in: name, weight, activation, transition, hardness.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::plugin::{AnyConstraint, AnyTask, PerRow};

/// The framework's keys of a task or constraint beside `type`; no plug-in may have them.
pub(crate) const ENTRY_KEYS: [&str; 6] = [
    "name",
    "weight",
    "active",
    "transition",
    "hardness",
    "level",
];

/// A task or constraint with what the framework needs to know about it.
#[derive(Debug)]
pub struct Entry<P: ?Sized> {
    /// Unique name: how logs, reports, errors and events call it.
    pub name: String,
    /// Weight of the rows, **linear**: cost `w r²`, unit 1/unit(row)². Hard equality rows have it only while they
    /// ramp, as a cost that becomes hard at the end.
    pub weight: PerRow,
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
    pub fn new(name: &str, weight: impl Into<PerRow>, hardness: Hardness, plugin: Box<P>) -> Self {
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
    pub fn task(name: &str, weight: impl Into<PerRow>, task: impl AnyTask) -> Self {
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
        weight: impl Into<PerRow>,
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

/// How far the plug-in's entry is switched on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EntryState {
    /// Ramp from 0 (off) to 1 (on); the framework has applied it to the weight already.
    pub(crate) alpha: f64,
    /// Time of the tick of the last switch, s; −∞ before.
    pub(crate) since: f64,
}

impl EntryState {
    /// On, as if ever since.
    pub(crate) const ON: Self = Self {
        alpha: 1.0,
        since: f64::NEG_INFINITY,
    };
}
