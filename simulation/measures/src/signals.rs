//! A run's series, in memory.

use std::collections::BTreeMap;

use crate::{MeasureError, Recording, RotorLimits, Series};

/// A run as time series that are in memory, from whatever has them: a simulation of one's own, an array of Python.
///
/// ```
/// use wbqp_measures::{Recording, Series, Signals};
///
/// let force = Series { t: vec![0.0, 0.004], y: vec![4.9, 5.1] };
/// let run = Signals::new()
///     .with_series("/contact/tip", "/measured/z", force)
///     .with_mark("slide_start", 0.0);
/// assert_eq!(run.series("/contact/tip", "/measured/z")?.mean(), Some(5.0));
/// assert_eq!(run.mark("slide_start")?, 0.0);
/// # Ok::<(), wbqp_measures::MeasureError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Signals {
    /// By topic, then by field.
    topics: BTreeMap<String, BTreeMap<String, Series>>,
    marks: BTreeMap<String, f64>,
    /// In the order of their names; without any, nothing is known of rotors.
    rotors: Vec<RotorLimits>,
    configuration: Vec<toml::Table>,
}

impl Signals {
    /// Nothing yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// With a field of a topic. Fields of one topic have the same times.
    pub fn with_series(mut self, topic: &str, field: &str, series: Series) -> Self {
        let fields = self.topics.entry(topic.to_owned()).or_default();
        fields.insert(field.to_owned(), series);
        self
    }

    /// With a named instant, s.
    pub fn with_mark(mut self, name: &str, time: f64) -> Self {
        self.marks.insert(name.to_owned(), time);
        self
    }

    /// With the limits of a rotor.
    pub fn with_rotor(mut self, limits: RotorLimits) -> Self {
        let at = self.rotors.partition_point(|r| r.name < limits.name);
        self.rotors.insert(at, limits);
        self
    }

    /// With a file of the run's configuration: the controller's, the scenario's.
    pub fn with_configuration(mut self, file: toml::Table) -> Self {
        self.configuration.push(file);
        self
    }

    fn topic(&self, topic: &str) -> Result<&BTreeMap<String, Series>, MeasureError> {
        self.topics.get(topic).ok_or_else(|| MeasureError::Topic {
            topic: topic.to_owned(),
            known: self.topics.keys().cloned().collect::<Vec<_>>().join(", "),
        })
    }
}

impl Recording for Signals {
    fn has(&self, topic: &str) -> bool {
        self.topics.contains_key(topic)
    }

    fn columns(&self, topic: &str, fields: &[String]) -> Result<Vec<Series>, MeasureError> {
        let known = self.topic(topic)?;
        let absent = || {
            let any = known.values().next();
            any.map_or_else(Series::default, |any| any.map(|_| f64::NAN))
        };
        let column = |field: &String| known.get(field).cloned().unwrap_or_else(absent);
        Ok(fields.iter().map(column).collect())
    }

    fn names(&self, topic: &str, object: &str) -> Result<Vec<String>, MeasureError> {
        let inside = |field: &String| {
            let rest = field.strip_prefix(object)?.strip_prefix('/')?;
            let name = rest.split('/').next().unwrap_or(rest);
            Some(name.replace("~1", "/").replace("~0", "~"))
        };
        let mut names: Vec<String> = self.topic(topic)?.keys().filter_map(inside).collect();
        names.sort_unstable();
        names.dedup();
        Ok(names)
    }

    fn end(&self) -> f64 {
        let series = self.topics.values().flat_map(BTreeMap::values);
        let last = series.filter_map(|series| series.t.last());
        last.copied().fold(0.0, f64::max)
    }

    fn mark(&self, name: &str) -> Result<f64, MeasureError> {
        let mark = self.marks.get(name).copied();
        mark.ok_or_else(|| MeasureError::Mark {
            name: name.to_owned(),
            known: self.marks.keys().cloned().collect(),
        })
    }

    fn rotors(&self) -> Result<Vec<RotorLimits>, MeasureError> {
        if self.rotors.is_empty() {
            return Err(MeasureError::Metadata {
                name: "rotors".to_owned(),
                key: "*.min".to_owned(),
            });
        }
        Ok(self.rotors.clone())
    }

    fn configuration(&self, key: &str) -> Result<toml::Table, MeasureError> {
        let found = self.configuration.iter().find(|f| f.contains_key(key));
        let found = found.cloned();
        found.ok_or_else(|| MeasureError::Attachment(key.to_owned()))
    }
}
