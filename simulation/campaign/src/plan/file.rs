//! What a plan's file may contain.

use std::{collections::BTreeMap, ops::Range, path::PathBuf};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use toml::Spanned;
use wbqp::config::in_words;
use wbqp_sim::{ScenarioError, Variation};

use super::{design::Design, distribution::Distribution};

/// A plan: which closed loops of a scenario are run, and what is measured of each.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Keys {
    /// The plan's name, of letters, digits, `_`, `-` and, inside, `.`: jobs and files are called so.
    #[schemars(with = "String")]
    pub(super) name: Spanned<String>,
    /// The scenario's file; relative paths count from this file's folder.
    #[schemars(with = "PathBuf")]
    pub(super) scenario: Spanned<PathBuf>,
    /// Which points of the factors' space are run.
    #[schemars(with = "Design")]
    pub(super) design: Spanned<Design>,
    /// Seed of the design and of the first run's sensors; default 0.
    #[serde(default)]
    pub(super) seed: u32,
    /// Runs of each point, each with other noise; default 1.
    #[serde(default)]
    #[schemars(with = "u32", range(min = 1))]
    pub(super) repetitions: Option<Spanned<u32>>,
    /// Which of the experiment's rows are measured.
    #[serde(default)]
    #[schemars(with = "Rows")]
    pub(super) rows: Option<Spanned<Rows>>,
    /// The measures that count as failure where they do not hold; default: all that are judged.
    #[serde(default)]
    #[schemars(with = "Option<Vec<String>>")]
    pub(super) failure: Option<Spanned<Vec<String>>>,
    /// Values put into the scenario's file in all variants, as in its cases.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub(super) change: Option<Spanned<toml::Table>>,
    /// Values put into the controller's file in all variants.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub(super) set: Option<Spanned<toml::Table>>,
    /// What is compared: each point is run in every variant, with the same noise. Default: each case of the scenario.
    #[serde(default, rename = "variant")]
    #[schemars(with = "Vec<VariantKeys>")]
    pub(super) variants: Vec<Spanned<VariantKeys>>,
    /// What is varied.
    #[serde(default, rename = "factor")]
    #[schemars(with = "Vec<FactorKeys>")]
    pub(super) factors: Vec<Spanned<FactorKeys>>,
    /// What is measured besides the experiment's rows.
    #[serde(default, rename = "measure")]
    #[schemars(with = "Vec<MeasureKeys>")]
    pub(super) measures: Vec<Spanned<MeasureKeys>>,
}

impl Keys {
    /// What a scenario is likely to be refused for: values that the plan puts into it or its controller, or itself.
    pub(super) fn cause(&self, error: &ScenarioError) -> Range<usize> {
        let values = match error {
            ScenarioError::Config { .. } | ScenarioError::Controller { .. } => &self.set,
            // So it calls a value that is not its own.
            error if error.to_string().contains(": variation `") => &self.change,
            _ => &None,
        };
        let scenario = || self.scenario.span();
        values.as_ref().map_or_else(scenario, Spanned::span)
    }
}

/// Which of the experiment's rows are measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Rows {
    /// None: the plan's own measures alone.
    #[default]
    None,
    /// Those that are to hold whatever the controller does not know.
    Robust,
    /// All of the experiment; every variant then has all cases that these need.
    All,
}

/// One of the things that are compared: cases of the scenario, and what is changed in them.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct VariantKeys {
    /// Unique.
    pub(super) name: String,
    /// Cases of the scenario; rows of an experiment want them in its order.
    pub(super) cases: Vec<String>,
    /// Values put into the scenario's file, as in its cases.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub(super) change: Option<Spanned<toml::Table>>,
    /// Values put into the controller's file, as in the scenario's cases.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub(super) set: Option<Spanned<toml::Table>>,
}

/// A table of values, with its place.
type Values = Option<Spanned<toml::Table>>;

/// The values of two tables as a case has them; or what is wrong, and where.
pub(super) fn variation(
    change: &Values,
    set: &Values,
) -> Result<Variation, (Range<usize>, String)> {
    let mut variation = Variation::new();
    for (key, values) in [("change", change), ("set", set)] {
        let Some(values) = values else {
            continue;
        };
        let table = toml::Table::from_iter([(key.to_owned(), values.get_ref().clone().into())]);
        // Where it is in this text says nothing.
        let one: Variation = table.try_into().map_err(|error: toml::de::Error| {
            let message = format!("{key}: {}", in_words(error.message()));
            (values.span(), message)
        })?;
        variation = variation.then(&one);
    }
    Ok(variation)
}

/// A quantity that is varied.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct FactorKeys {
    /// Unique: names the column of the table.
    pub(super) name: String,
    /// Path of the value, as a case of the scenario has it: `change.plant.mismatch.mass_scale`, `set.task.com.kp`; with
    /// `[i]` behind it, an entry of a list, from 0. Several paths get the same.
    pub(super) path: Paths,
    /// The value itself.
    #[serde(default)]
    pub(super) value: Option<Distribution>,
    /// Times the scenario's own value, every entry of a list.
    #[serde(default)]
    pub(super) scale: Option<Distribution>,
    /// Added to the scenario's own value, to every entry of a list.
    #[serde(default)]
    pub(super) shift: Option<Distribution>,
}

/// One path or several.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(super) enum Paths {
    One(String),
    Several(Vec<String>),
}

/// A measure of one's own: a number from the channels of a run.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct MeasureKeys {
    /// Unique: names the column of the table.
    pub(super) name: String,
    /// Of which of the variant's cases, from 1; default the first.
    #[serde(default = "first")]
    pub(super) case: usize,
    /// Names for channels of the log: `/contact/tip.measured.z` is the field `measured.z` of the topic `/contact/tip`.
    /// All of one measure are of one topic, or of topics with the same times.
    pub(super) signals: BTreeMap<String, String>,
    /// What is computed at every time from the signals; default: the only signal.
    #[serde(default)]
    pub(super) expression: Option<String>,
    /// What becomes of the values over time.
    pub(super) reduce: Reduction,
    /// What becomes of ticks of the window in which a signal has no value, as references, tasks and planned forces in a
    /// tick without a solution; default: the measure has no value, and the run does not hold.
    #[serde(default)]
    pub(super) gaps: Gaps,
    /// From this time on, s: a number, or an expression with the names of marks; default: the beginning.
    #[serde(default)]
    pub(super) from: Option<Time>,
    /// Until this time, s; default: the end.
    #[serde(default)]
    pub(super) until: Option<Time>,
    /// Unit of the result.
    #[serde(default)]
    pub(super) unit: String,
    /// Holds if the result is at most this.
    #[serde(default)]
    pub(super) at_most: Option<f64>,
    /// Holds if the result is at least this.
    #[serde(default)]
    pub(super) at_least: Option<f64>,
}

fn first() -> usize {
    1
}

/// A time, s.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(super) enum Time {
    Number(f64),
    Expression(String),
}

/// What becomes of ticks of a measure's window in which a signal has no value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Gaps {
    /// With one such tick the measure has no value; one that is `last` asks for the last tick alone.
    #[default]
    NoValue,
    /// The signal's last value goes on; the table says which share of the window is without.
    Hold,
    /// They are left out; the table says which share of the window is left.
    Skip,
}

/// From values over time to one number.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Reduction {
    /// Arithmetic mean.
    Mean,
    /// Root of the mean square.
    Rms,
    /// Largest value.
    Max,
    /// Smallest value.
    Min,
    /// Largest magnitude.
    MaxAbs,
    /// Last value.
    Last,
    /// Mean of the values' signs above zero: the share of time in which the expression is positive.
    Share,
    /// The value below which this share of the samples lies, 0 to 1.
    Quantile(f64),
}
