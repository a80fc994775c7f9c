//! What a plan's file may contain.

use std::{collections::BTreeMap, path::PathBuf};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use toml::Spanned;
use wbqp_sim::Variation;

use super::{design::Design, distribution::Distribution};

/// A plan: which closed loops of a scenario are run, and what is measured of each.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Keys {
    /// The plan's name, of letters, digits, `_`, `-` and, inside, `.`: jobs and files are called so.
    #[schemars(with = "String")]
    pub(super) name: Spanned<String>,
    /// The scenario's file; relative paths count from this file's folder.
    pub(super) scenario: PathBuf,
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
    pub(super) change: toml::Table,
    /// Values put into the controller's file in all variants.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub(super) set: toml::Table,
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
    pub(super) change: toml::Table,
    /// Values put into the controller's file, as in the scenario's cases.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub(super) set: toml::Table,
}

/// The values of two tables as a case has them.
pub(super) fn variation(change: &toml::Table, set: &toml::Table) -> Result<Variation, String> {
    let mut table = toml::Table::new();
    table.insert("change".into(), change.clone().into());
    table.insert("set".into(), set.clone().into());
    Variation::from_toml(&table.to_string()).map_err(|error| error.to_string())
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
