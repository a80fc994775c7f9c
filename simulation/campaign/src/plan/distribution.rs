//! Which values a factor takes.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, Normal};
use wbqp_sim::exact::numbers;

/// A set of values, with a measure: a number of the unit interval picks one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Distribution {
    /// All numbers of an interval alike: `uniform = [lowest, highest]`.
    Uniform(#[serde(deserialize_with = "numbers")] [f64; 2]),
    /// All orders of magnitude of an interval alike: `log_uniform = [lowest, highest]`, both above 0.
    LogUniform(#[serde(deserialize_with = "numbers")] [f64; 2]),
    /// Gaussian: `normal = { mean = 0.0, sd = 1.0 }`.
    Normal {
        /// Mean.
        mean: f64,
        /// Standard deviation, above 0.
        sd: f64,
    },
    /// These values alike.
    Values(Vec<f64>),
    /// All whole numbers from the first to the second alike, both included.
    Integers(#[serde(deserialize_with = "numbers")] [i64; 2]),
    /// Values at the same distance from one another.
    Range {
        /// The first.
        from: f64,
        /// The last.
        to: f64,
        /// How many, at least 2.
        count: u32,
    },
}

/// The most values that a list stands for.
const MOST_LEVELS: u64 = 1_000_000;

impl Distribution {
    /// What is wrong with it, if something is.
    pub(super) fn problem(&self) -> Option<String> {
        let finite = |numbers: &[f64]| numbers.iter().all(|x| x.is_finite());
        match self {
            Self::Uniform(ends) | Self::LogUniform(ends) if !finite(ends) || ends[0] >= ends[1] => {
                Some(format!(
                    "the range from {} to {} is empty: the first must be finite and below the second",
                    ends[0], ends[1]
                ))
            }
            Self::LogUniform(ends) if ends[0] <= 0.0 => Some(format!(
                "a logarithmic range begins above 0, not at {}",
                ends[0]
            )),
            Self::Normal { mean, sd } if !finite(&[*mean, *sd]) || *sd <= 0.0 => Some(format!(
                "a standard deviation of {sd} around {mean} makes no distribution: it must be finite and above 0"
            )),
            Self::Values(values) if values.is_empty() => {
                Some("the list of values is empty".to_owned())
            }
            Self::Values(values) if !finite(values) => Some("a value is not finite".to_owned()),
            Self::Integers(ends) if ends[0] > ends[1] => Some(format!(
                "the range from {} to {} is empty: the first must not be above the second",
                ends[0], ends[1]
            )),
            Self::Integers(ends) if ends[1].abs_diff(ends[0]) >= MOST_LEVELS => {
                Some(format!("more than {MOST_LEVELS} whole numbers"))
            }
            Self::Range { from, to, count }
                if !finite(&[*from, *to]) || from >= to || *count < 2 =>
            {
                Some(format!(
                    "the range of {count} values from {from} to {to} is empty: the first must be below the last, and \
                     there must be two at least"
                ))
            }
            Self::Range { count, .. } if u64::from(*count) > MOST_LEVELS => {
                Some(format!("more than {MOST_LEVELS} values"))
            }
            _ => None,
        }
    }

    /// How many values there are; nothing if they are not counted.
    pub(super) fn levels(&self) -> Option<usize> {
        match self {
            Self::Uniform(_) | Self::LogUniform(_) | Self::Normal { .. } => None,
            Self::Values(values) => Some(values.len()),
            Self::Integers([first, last]) => Some(last.abs_diff(*first) as usize + 1),
            Self::Range { count, .. } => Some(*count as usize),
        }
    }

    /// A value that is counted, from 0.
    pub(super) fn level(&self, index: usize) -> f64 {
        match self {
            Self::Values(values) => values.get(index).copied().unwrap_or(f64::NAN),
            Self::Integers([first, _]) => (*first as f64) + index as f64,
            Self::Range { from, to, count } => {
                let steps = f64::from(count.saturating_sub(1).max(1));
                from + (to - from) * (index as f64 / steps)
            }
            Self::Uniform(_) | Self::LogUniform(_) | Self::Normal { .. } => f64::NAN,
        }
    }

    /// The value below which a share `u` of the distribution lies, 0 ≤ u < 1.
    pub(crate) fn quantile(&self, u: f64) -> f64 {
        match self {
            Self::Uniform([low, high]) => low + (high - low) * u,
            Self::LogUniform([low, high]) => (low.ln() + (high / low).ln() * u).exp(),
            Self::Normal { mean, sd } => {
                // The ends of the interval are at infinity.
                let u = u.clamp(f64::EPSILON, 1.0 - f64::EPSILON);
                Normal::new(*mean, *sd).map_or(*mean, |normal| normal.inverse_cdf(u))
            }
            Self::Values(_) | Self::Integers(_) | Self::Range { .. } => {
                let levels = self.levels().unwrap_or(1);
                self.level(((u * levels as f64) as usize).min(levels.saturating_sub(1)))
            }
        }
    }

    /// The smallest and the largest value; of a Gaussian, which has none, three standard deviations from the mean.
    pub(crate) fn ends(&self) -> [f64; 2] {
        match self {
            Self::Uniform(ends) | Self::LogUniform(ends) => *ends,
            Self::Normal { mean, sd } => [mean - 3.0 * sd, mean + 3.0 * sd],
            Self::Values(values) => {
                let least = values.iter().copied().fold(f64::INFINITY, f64::min);
                let largest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                [least, largest]
            }
            Self::Integers([first, last]) => [*first as f64, *last as f64],
            Self::Range { from, to, .. } => [*from, *to],
        }
    }

    /// Whether all values are whole numbers.
    pub(super) fn is_whole(&self) -> bool {
        match self {
            Self::Integers(_) => true,
            Self::Values(values) => values.iter().all(|v| v.fract() == 0.0),
            _ => false,
        }
    }
}
