//! A class of Python with the keys of a file: the parameters of its plug-in.

use std::{fmt, sync::Arc};

use pyo3::{
    prelude::*,
    types::{PyDict, PyList},
};
use serde::{Serialize, Serializer, ser::SerializeMap};
use wbqp::{
    error::BindError,
    plugin::{Layout, Setup},
};

use super::{declared::Declared, raised::bind_error, running::Running, setup::PluginSetup};

/// A plug-in's class with the keys of a file.
#[derive(Clone)]
pub(super) struct Parameters {
    pub(super) tag: &'static str,
    pub(super) class: Arc<Py<PyAny>>,
    /// The same table as long as nobody asks for another.
    pub(super) keys: Arc<toml::Table>,
}

impl fmt::Debug for Parameters {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.tag, self.keys)
    }
}

impl Serialize for Parameters {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.keys.len()))?;
        for (key, value) in self.keys.iter() {
            map.serialize_entry(key, value)?;
        }
        map.end()
    }
}

/// A value of a file in Python.
fn python<'py>(py: Python<'py>, value: &toml::Value) -> PyResult<Bound<'py, PyAny>> {
    Ok(match value {
        toml::Value::String(text) => text.into_pyobject(py)?.into_any(),
        toml::Value::Integer(number) => number.into_pyobject(py)?.into_any(),
        toml::Value::Float(number) => number.into_pyobject(py)?.into_any(),
        toml::Value::Boolean(truth) => truth.into_pyobject(py)?.to_owned().into_any(),
        toml::Value::Datetime(date) => date.to_string().into_pyobject(py)?.into_any(),
        toml::Value::Array(items) => {
            let list = PyList::empty(py);
            for item in items {
                list.append(python(py, item)?)?;
            }
            list.into_any()
        }
        toml::Value::Table(table) => dict(py, table)?.into_any(),
    })
}

pub(super) fn dict<'py>(py: Python<'py>, table: &toml::Table) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for (key, value) in table {
        dict.set_item(key, python(py, value)?)?;
    }
    Ok(dict)
}

impl Parameters {
    /// An object of the class; what `wbqp._authoring.make` refuses is raised.
    pub(super) fn object<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let make = py.import("wbqp._authoring")?.getattr("make")?;
        make.call1((self.class.bind(py), dict(py, &self.keys)?))
    }

    pub(super) fn bind(&self, setup: &mut Setup<'_>) -> Result<(Layout, Running), BindError> {
        Python::attach(|py| {
            let object = self.object(py).map_err(|error| bind_error(py, &error))?;
            let seen = PluginSetup::new(py, setup).map_err(|error| bind_error(py, &error))?;
            let seen = Py::new(py, seen).map_err(|error| bind_error(py, &error))?;
            let declared = object
                .call_method1("bind", (&seen,))
                .and_then(|declared| Declared::read(&declared, seen.get(), setup))
                .map_err(|error| bind_error(py, &error))?;
            let mut handles = Vec::new();
            for name in &seen.get().requested() {
                handles.push(setup.frame(name)?);
            }
            let layout = declared.layout();
            Running::new(py, self, object, seen.get(), &declared, handles)
                .map(|running| (layout, running))
                .map_err(|error| bind_error(py, &error))
        })
    }
}
