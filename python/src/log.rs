//! Runs as series: of a log in a file or in memory, and the experiments' rows from them.

use std::{collections::BTreeMap, path::PathBuf, sync::OnceLock};

use pyo3::{
    exceptions::{PyKeyError, PyOSError, PyValueError},
    prelude::*,
    types::{PyBytes, PyDict},
};
use wbqp_measures::{
    MeasureError, Recording, RotorLimits, Series, Signals,
    log::{Contents, Log as Inner, ReadError},
};

use crate::{
    arrays::{Length, of_vector, vector},
    config,
};

/// The series of a run, by topic and field; what `wbqp.Recording` is made of.
#[pyclass(frozen, module = "wbqp._wbqp", name = "_Log")]
pub(crate) struct Log {
    log: Option<Inner>,
    signals: OnceLock<Signals>,
}

impl Log {
    pub(crate) fn new(log: Inner) -> Self {
        Self {
            log: Some(log),
            signals: OnceLock::new(),
        }
    }

    /// All series; a log's are read when they are first asked for.
    pub(crate) fn signals(&self) -> PyResult<&Signals> {
        if let Some(signals) = self.signals.get() {
            return Ok(signals);
        }
        let read = match &self.log {
            Some(log) => log.signals().map_err(|error| measure_error(&error))?,
            None => Signals::new(),
        };
        Ok(self.signals.get_or_init(|| read))
    }
}

pub(crate) fn measure_error(error: &MeasureError) -> PyErr {
    match error {
        MeasureError::Topic { .. } | MeasureError::Case { .. } => {
            PyKeyError::new_err(error.to_string())
        }
        _ => PyValueError::new_err(error.to_string()),
    }
}

#[pymethods]
impl Log {
    /// Series that are there already: `{topic: {field: (t, y)}}`, with named instants, limits of rotors
    /// `{name: {"thrust": [min, max], "speed": [min, max], "lag": [rise, fall]}}` and texts of TOML files.
    #[staticmethod]
    #[pyo3(signature = (topics, marks = None, rotors = None, configuration = None))]
    fn of_series(
        topics: &Bound<'_, PyDict>,
        marks: Option<BTreeMap<String, f64>>,
        rotors: Option<BTreeMap<String, BTreeMap<String, [f64; 2]>>>,
        configuration: Option<Vec<String>>,
    ) -> PyResult<Self> {
        let mut signals = Signals::new();
        for (topic, fields) in topics {
            let topic: String = topic.extract()?;
            for (field, series) in fields.cast::<PyDict>()? {
                let field: String = field.extract()?;
                let name = format!("{topic}{field}");
                let (t, y): (Bound<'_, PyAny>, Bound<'_, PyAny>) = series.extract()?;
                let t = vector(&t, &name, Length::Any)?;
                let y = vector(&y, &name, Length::Exactly(t.len()))?;
                signals = signals.with_series(&topic, &field, Series { t, y });
            }
        }
        for (name, time) in marks.unwrap_or_default() {
            signals = signals.with_mark(&name, time);
        }
        for (name, limits) in rotors.unwrap_or_default() {
            let pair = |key: &str| {
                let pair = limits.get(key).copied();
                pair.ok_or_else(|| PyKeyError::new_err(format!("rotor `{name}` has no `{key}`")))
            };
            signals = signals.with_rotor(RotorLimits {
                thrust: pair("thrust")?,
                speed: pair("speed")?,
                lag: pair("lag")?,
                name: name.clone(),
            });
        }
        for text in configuration.unwrap_or_default() {
            let table = text.parse::<toml::Table>();
            let table = table.map_err(|error| PyValueError::new_err(error.to_string()))?;
            signals = signals.with_configuration(table);
        }
        Ok(Self {
            log: None,
            signals: OnceLock::from(signals),
        })
    }

    /// The topics that have messages.
    fn topics(&self) -> Vec<String> {
        let log = self.log.as_ref();
        log.map_or_else(Vec::new, |log| log.topics().map(str::to_owned).collect())
    }

    /// Fields of a topic, as paths `a/b/c`, with their numbers, NaN where a message has none, or texts, None where a
    /// message has none; the times of the messages are `t`.
    fn topic<'py>(&self, py: Python<'py>, topic: &str) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        let signals = self.signals()?;
        let log = self.log.as_ref();
        let contents = log.map_or_else(|| Ok(Contents::default()), |log| log.contents(topic));
        let Contents { numbers, texts, .. } = contents.map_err(|error| measure_error(&error))?;
        let columns = signals.columns(topic, &numbers);
        let columns = columns.map_err(|error| measure_error(&error))?;
        if let Some(first) = columns.first() {
            dict.set_item("t", of_vector(py, &first.t))?;
        }
        for (field, series) in numbers.iter().zip(&columns) {
            dict.set_item(field.trim_start_matches('/'), of_vector(py, &series.y))?;
        }
        for (field, texts) in texts {
            dict.set_item(field.trim_start_matches('/'), texts)?;
        }
        Ok(dict)
    }

    /// The unit of a number, by the names of the objects around it and its own.
    fn unit(&self, topic: &str, path: Vec<String>) -> Option<String> {
        let path: Vec<&str> = path.iter().map(String::as_str).collect();
        Some(self.log.as_ref()?.unit(topic, &path)?.to_owned())
    }

    /// Named instants, s.
    fn marks(&self) -> PyResult<BTreeMap<String, f64>> {
        let signals = self.signals()?;
        let log = self.log.as_ref();
        let names = log.and_then(|log| log.metadata(wbqp_log::Timeline::NAME));
        let names = names.into_iter().flatten();
        Ok(names
            .filter_map(|(name, _)| Some((name.clone(), signals.mark(name).ok()?)))
            .collect())
    }

    /// A table of texts that the log has.
    fn metadata(&self, name: &str) -> BTreeMap<String, String> {
        let log = self.log.as_ref();
        log.and_then(|log| log.metadata(name))
            .cloned()
            .unwrap_or_default()
    }

    /// Names and contents of the attached TOML files.
    fn configuration(&self) -> BTreeMap<String, String> {
        let log = self.log.as_ref();
        let texts = log.into_iter().flat_map(Inner::attached_texts);
        texts
            .map(|(name, text)| (name.to_owned(), text.to_owned()))
            .collect()
    }

    /// Contents of an attachment.
    fn attachment<'py>(&self, py: Python<'py>, name: &str) -> Option<Bound<'py, PyBytes>> {
        let contents = self.log.as_ref()?.attachment(name)?;
        Some(PyBytes::new(py, contents))
    }
}

/// Reads the MCAP file of a run.
#[pyfunction]
pub(crate) fn _read_log(py: Python<'_>, path: PathBuf) -> PyResult<Log> {
    let log = py.detach(|| Inner::open(&path));
    let log = log.map_err(|error| match error {
        ReadError::File { .. } => PyOSError::new_err(error.to_string()),
        _ => PyValueError::new_err(format!("{}: {error}", path.display())),
    })?;
    Ok(Log::new(log))
}

/// A dict as text of TOML, for what is handed over as text.
#[pyfunction]
pub(crate) fn _to_toml(table: &Bound<'_, PyDict>) -> PyResult<String> {
    let value = config::value(table, "", 0)?;
    toml::to_string(&value).map_err(|error| PyValueError::new_err(error.to_string()))
}
