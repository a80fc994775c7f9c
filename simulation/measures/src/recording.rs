//! What the measures ask of a run.

use crate::{MeasureError, Series};

/// A finished run, as the measures see it: numbers over time, by topic and field.
///
/// Topics are those of a log, `/contact/tip` for example; a field is a JSON pointer into a topic's messages,
/// `/measured/z`. Times are in seconds; units are those of the log.
pub trait Recording {
    /// Whether there is anything of a topic.
    fn has(&self, topic: &str) -> bool;

    /// Fields of a topic, all with the same times: a series for each. Where a message lacks a field, its sample is NaN.
    ///
    /// # Errors
    /// [`MeasureError::Topic`] or [`MeasureError::Unreadable`].
    fn columns(&self, topic: &str, fields: &[String]) -> Result<Vec<Series>, MeasureError>;

    /// What there is inside an object of a topic's messages, `/rows` for example; nothing if there is no such object.
    /// The names are not escaped: see [`escaped`].
    ///
    /// # Errors
    /// [`MeasureError::Topic`] or [`MeasureError::Unreadable`].
    fn names(&self, topic: &str, object: &str) -> Result<Vec<String>, MeasureError>;

    /// Time of the last sample of all, s.
    fn end(&self) -> f64;

    /// A named instant, s.
    ///
    /// # Errors
    /// [`MeasureError::Mark`] if the run had none of that name.
    fn mark(&self, name: &str) -> Result<f64, MeasureError>;

    /// Limits of the rotors, in the order of their names.
    ///
    /// # Errors
    /// [`MeasureError::Metadata`].
    fn rotors(&self) -> Result<Vec<RotorLimits>, MeasureError>;

    /// The first file of the run's configuration that has this key at its top: `task` is in a controller's, `plant` in
    /// a scenario's.
    ///
    /// # Errors
    /// [`MeasureError::Attachment`].
    fn configuration(&self, key: &str) -> Result<toml::Table, MeasureError>;

    /// One field over time; true is 1 and false is 0. Where a message lacks it, its sample is NaN.
    ///
    /// # Errors
    /// [`MeasureError::Topic`] or [`MeasureError::Unreadable`].
    fn series(&self, topic: &str, field: &str) -> Result<Series, MeasureError> {
        let columns = self.columns(topic, &[field.to_owned()])?;
        Ok(columns.into_iter().next().unwrap_or_default())
    }
}

/// A name as part of a field: `~` and `/` mean something in a JSON pointer.
pub fn escaped(name: &str) -> String {
    name.replace('~', "~0").replace('/', "~1")
}

/// Limits of a rotor.
#[derive(Clone, Debug, PartialEq)]
pub struct RotorLimits {
    /// Its name.
    pub name: String,
    /// Smallest and largest thrust, N.
    pub thrust: [f64; 2],
    /// Speeds at these, rad/s.
    pub speed: [f64; 2],
    /// Time constants of the thrust, rising and falling, s.
    pub lag: [f64; 2],
}

impl RotorLimits {
    /// Whether a thrust in N is at a bound: within 1 % of the range.
    pub fn at_a_bound(&self, thrust: f64) -> bool {
        let [low, high] = self.thrust;
        (thrust - low).abs().min((thrust - high).abs()) <= 0.01 * (high - low)
    }
}
