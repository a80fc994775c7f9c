//! What becomes of a run.

use serde::{Deserialize, Serialize};

use crate::plan::Gaps;

/// A measure of a campaign: a column of its table.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Column {
    /// Its name, unique in the campaign.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// What is accepted, in words.
    pub tolerance: String,
    /// Whether it is judged at all.
    pub is_judged: bool,
    /// Whether a run fails in which it does not hold.
    pub counts: bool,
    /// What becomes of ticks in which a signal of it has no value; the experiment's own have nothing else to say.
    #[serde(default, skip_serializing_if = "is_default")]
    pub gaps: Gaps,
}

/// What became of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Outcome {
    /// Its number.
    pub run: u64,
    /// How it ended.
    pub status: Status,
    /// Why it did not reach its end, or why one of the plan's measures has no value.
    pub reason: Option<String>,
    /// Whether it reached its end and every measure that counts holds; nothing if it was refused: it was never
    /// simulated, and says nothing of the controller.
    pub holds: Option<bool>,
    /// Control periods of all its cases.
    pub ticks: u64,
    /// Ticks whose command was not that tick's optimum.
    pub held_ticks: u64,
    /// By column; nothing where the run has no such value.
    pub measured: Vec<Option<f64>>,
    /// By column; nothing for columns that are not judged, or not reached.
    pub verdicts: Vec<Option<bool>>,
    /// By column: share of the window's ticks in which all signals have a value of their own; nothing for measures that
    /// have no value otherwise. Empty if there are no others.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub covered: Vec<Option<f64>>,
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// All its cases reached their end.
    Completed,
    /// The plant diverged.
    Diverged,
    /// The scenario was refused with these values, and nothing was simulated: a task asks for more than the plant can,
    /// for example.
    Refused,
    /// The run could not go on: an event, a measure, or a panic.
    Failed,
}

impl Status {
    /// In one word, as tables have it.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Completed => "completed",
            Self::Diverged => "diverged",
            Self::Refused => "refused",
            Self::Failed => "failed",
        }
    }
}
