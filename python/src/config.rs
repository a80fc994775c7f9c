//! Configurations from Python: a file, a text, or a dict, which becomes a TOML document, so that the same loader reads
//! it.

use std::path::PathBuf;

use pyo3::{
    exceptions::{PyTypeError, PyValueError},
    prelude::*,
    types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString},
};
use wbqp::{
    ControllerConfig,
    config::{ConfigErrors, Overrides},
    plugin::{AnyReference, PerRow},
};

use crate::{
    arrays::{Length, vector},
    plugin,
};

/// What messages call a configuration that is no file.
const DICT: &str = "<dict>";

/// How deep a configuration may be nested.
const DEEPEST: usize = 32;

/// A TOML value from Python's. `None` leaves a key out.
///
/// # Errors
/// `TypeError` naming the place of what no configuration can hold.
pub(crate) fn value(object: &Bound<'_, PyAny>, place: &str, depth: usize) -> PyResult<toml::Value> {
    if depth > DEEPEST {
        return Err(PyValueError::new_err(format!("{place}: nested too deeply")));
    }
    if let Ok(plugin) = object.getattr("_wbqp_table") {
        return value(&plugin.call0()?, place, depth + 1);
    }
    if object.is_instance_of::<PyBool>() {
        return Ok(toml::Value::Boolean(object.extract()?));
    }
    if object.is_instance_of::<PyInt>() {
        let integer = object.extract::<i64>();
        return integer.map(toml::Value::Integer).map_err(|_| {
            PyValueError::new_err(format!("{place}: the integer does not fit in 64 bits"))
        });
    }
    if object.is_instance_of::<PyFloat>() {
        return Ok(toml::Value::Float(object.extract()?));
    }
    if object.is_instance_of::<PyString>() {
        return Ok(toml::Value::String(object.extract()?));
    }
    if let Ok(dict) = object.cast::<PyDict>() {
        return Ok(toml::Value::Table(table(dict, place, depth)?));
    }
    if let Ok(path) = object.call_method0("__fspath__") {
        return value(&path, place, depth + 1);
    }
    // Numpy's numbers and arrays.
    if let Ok(list) = object.call_method0("tolist") {
        return value(&list, place, depth + 1);
    }
    let is_sequence =
        object.is_instance_of::<PyList>() || object.is_instance_of::<pyo3::types::PyTuple>();
    if is_sequence {
        let items = object.try_iter()?.enumerate();
        let items = items.map(|(i, item)| value(&item?, &format!("{place}[{i}]"), depth + 1));
        return Ok(toml::Value::Array(items.collect::<PyResult<_>>()?));
    }
    let kind = object.get_type().name()?;
    Err(PyTypeError::new_err(format!(
        "{place}: a configuration cannot hold a {kind}; it holds numbers, texts, True and False, lists and dicts"
    )))
}

fn table(dict: &Bound<'_, PyDict>, place: &str, depth: usize) -> PyResult<toml::Table> {
    let mut table = toml::Table::new();
    for (key, item) in dict {
        if item.is_none() {
            continue;
        }
        let key: String = key
            .extract()
            .map_err(|_| PyTypeError::new_err(format!("{place}: the key {key} is not a text")))?;
        let place = if place.is_empty() {
            key.clone()
        } else {
            format!("{place}.{key}")
        };
        let item = value(&item, &place, depth + 1)?;
        table.insert(key, item);
    }
    Ok(table)
}

/// A configuration that was given in Python, to be loaded once or many times, with or without the interpreter's lock.
pub(crate) struct Source {
    origin: Origin,
    overrides: Overrides,
}

enum Origin {
    File(PathBuf),
    Text {
        text: String,
        name: String,
        directory: PathBuf,
    },
}

impl Source {
    /// A dict with the tables of a controller's file.
    ///
    /// # Errors
    /// `TypeError` for what no file can hold.
    pub(crate) fn dict(
        dict: &Bound<'_, PyDict>,
        directory: Option<PathBuf>,
        set: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let text = toml::to_string(&table(dict, "", 0)?)
            .map_err(|error| PyValueError::new_err(format!("the configuration: {error}")))?;
        Self::text(text, DICT, directory, set)
    }

    /// The text of a controller's file; relative paths count from `directory`.
    ///
    /// # Errors
    /// `ValueError` for values of `set` that are in no file.
    pub(crate) fn text(
        text: String,
        name: &str,
        directory: Option<PathBuf>,
        set: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let directory = directory.unwrap_or_default();
        let name = name.to_owned();
        Ok(Self {
            origin: Origin::Text {
                text,
                name,
                directory,
            },
            overrides: overrides(set)?,
        })
    }

    /// What a constructor was given: a path, a dict, or the tables as keywords.
    ///
    /// # Errors
    /// `TypeError` if it is none of them.
    pub(crate) fn given(
        py: Python<'_>,
        config: Option<&Bound<'_, PyAny>>,
        directory: Option<PathBuf>,
        set: Option<&Bound<'_, PyDict>>,
        tables: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let tables = tables.filter(|tables| !tables.is_empty());
        match (config, tables) {
            (Some(_), Some(_)) => Err(PyTypeError::new_err(
                "give a file or a dict, or the tables as keywords, not both; `set` changes single values",
            )),
            (None, None) => Err(PyTypeError::new_err(
                "give a file, a dict, or the tables as keywords: robot=…, tasks=[…], rate=…",
            )),
            (None, Some(tables)) => {
                let document = py.import("wbqp._config")?.getattr("document")?;
                let document = document.call((), Some(tables))?;
                Self::dict(document.cast()?, directory, set)
            }
            (Some(config), None) => {
                if let Ok(dict) = config.cast::<PyDict>() {
                    return Self::dict(dict, directory, set);
                }
                let path = config.extract().map_err(|_| {
                    PyTypeError::new_err("the configuration must be a path or a dict")
                })?;
                Ok(Self {
                    origin: Origin::File(path),
                    overrides: overrides(set)?,
                })
            }
        }
    }

    /// Loads it.
    ///
    /// # Errors
    /// All mistakes.
    pub(crate) fn load(&self) -> Result<ControllerConfig, ConfigErrors> {
        match &self.origin {
            Origin::File(path) => ControllerConfig::from_file_with(path, &self.overrides),
            Origin::Text {
                text,
                name,
                directory,
            } => ControllerConfig::from_str_with(text, name, directory, &self.overrides),
        }
    }

    /// Makes a controller of it.
    ///
    /// # Errors
    /// `ConfigError` with all mistakes.
    pub(crate) fn controller(&self, py: Python<'_>) -> PyResult<wbqp::Controller> {
        // What nobody asked for until now is of something else.
        let _ = plugin::cause();
        let controller = self.load().and_then(wbqp::Controller::new);
        controller.map_err(|error| refused(py, &error))
    }
}

/// What replaces values of a file: `{"task": {"com": {"kp": 40.0}}, "controller": {"rate": 500.0}}`.
pub(crate) fn overrides(set: Option<&Bound<'_, PyDict>>) -> PyResult<Overrides> {
    let Some(set) = set else {
        return Ok(Overrides::default());
    };
    let table = table(set, "", 0)?;
    table.try_into().map_err(|error: toml::de::Error| {
        PyValueError::new_err(format!("set: {}", error.message()))
    })
}

/// Keys of a plug-in.
pub(crate) fn keys(keys: Option<&Bound<'_, PyDict>>) -> PyResult<toml::Table> {
    keys.map_or_else(|| Ok(toml::Table::new()), |keys| table(keys, "", 0))
}

/// A number, or one per row.
pub(crate) fn weight(weight: &Bound<'_, PyAny>) -> PyResult<PerRow> {
    Ok(match weight.extract::<f64>() {
        Ok(weight) => PerRow::from(weight),
        Err(_) => PerRow::Each(vector(weight, "weight", Length::Any)?),
    })
}

/// An object of `wbqp.references`, or its table.
pub(crate) fn reference(reference: &Bound<'_, PyAny>) -> PyResult<Box<dyn AnyReference>> {
    let value = value(reference, "reference", 0)?;
    value.try_into().map_err(|error: toml::de::Error| {
        let message = format!("reference: {}", error.message());
        refused_text(reference.py(), &message)
    })
}

/// `ConfigError` with everything that is wrong.
pub(crate) fn refused(py: Python<'_>, errors: &ConfigErrors) -> PyErr {
    list(py, errors)
        .and_then(|errors| raise(py, &errors))
        .unwrap_or_else(|error| error)
}

/// `ConfigError` with one message per line of a text.
pub(crate) fn refused_text(py: Python<'_>, text: &str) -> PyErr {
    let errors = lines(py, text).and_then(|errors| raise(py, &errors));
    errors.unwrap_or_else(|error| error)
}

fn raise(py: Python<'_>, errors: &Bound<'_, PyList>) -> PyResult<PyErr> {
    let class = py.import("wbqp._errors")?.getattr("ConfigError")?;
    let error = PyErr::from_value(class.call1((errors,))?);
    // With the traceback of a plug-in written in Python.
    error.set_cause(py, plugin::cause());
    Ok(error)
}

fn message<'py>(
    py: Python<'py>,
    place: Option<(String, Option<u64>, Option<u64>)>,
    subject: &str,
    message: &str,
) -> PyResult<Bound<'py, PyAny>> {
    let class = py.import("wbqp._errors")?.getattr("Mistake")?;
    let (file, line, column) = match place {
        Some((file, ..)) if file == DICT => (None, None, None),
        Some((file, line, column)) => (Some(file), line, column),
        None => (None, None, None),
    };
    class.call1((file, line, column, subject, message))
}

fn lines<'py>(py: Python<'py>, text: &str) -> PyResult<Bound<'py, PyList>> {
    let list = PyList::empty(py);
    for line in text.lines() {
        list.append(message(py, None, "", line)?)?;
    }
    Ok(list)
}

fn list<'py>(py: Python<'py>, errors: &ConfigErrors) -> PyResult<Bound<'py, PyList>> {
    let list = PyList::empty(py);
    for error in errors {
        let place = error.place.as_ref().map(|place| {
            let position = place.position;
            (
                place.file.clone(),
                position.map(|(line, _)| line as u64),
                position.map(|(_, column)| column as u64),
            )
        });
        list.append(message(py, place, &error.subject, &error.message)?)?;
    }
    Ok(list)
}
