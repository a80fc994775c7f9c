//! Plug-ins written in Python: tasks, constraints and references that are registered while the program runs.
//!
//! The parameters are the class and the keys of the file; `bind` makes an object of the class, and that is what runs.
//! What an `update` sees and writes are arrays over one memory, made once. What it raises becomes a number that is no
//! number in its rows, so that the tick falls back; the traceback is kept for the report.

mod change;
mod check;
mod constraint;
mod declared;
mod parameters;
mod raised;
mod reference;
mod running;
mod setup;
mod task;

use std::{
    collections::BTreeSet,
    sync::{Arc, Mutex, PoisonError},
};

use pyo3::{exceptions::PyValueError, prelude::*};
use wbqp::{
    plugin::{AnyConstraint, AnyReference, AnyTask},
    registry::{self, Load, Plugin},
    schemars::Schema,
    serde::Deserialize,
    serde_json::Value,
    toml::{self, de::ValueDeserializer},
};

use constraint::PythonConstraint;
use parameters::Parameters;
use reference::PythonReference;
use task::PythonTask;

pub(crate) use change::set;
pub(crate) use check::_check;
pub(crate) use raised::{Call, cause, interrupt, traceback};
pub(crate) use setup::PluginSetup;

/// A tag for as long as the program: a plug-in says its own as a constant would. Kept once, however often a cell that
/// registers it runs.
fn lasting(tag: &str) -> &'static str {
    static TAGS: Mutex<BTreeSet<&str>> = Mutex::new(BTreeSet::new());
    let mut tags = TAGS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = tags.get(tag) {
        return known;
    }
    let tag: &str = tag.to_owned().leak();
    tags.insert(tag);
    tag
}

/// What makes a plug-in, for as long as the program.
fn leaked<P: ?Sized + 'static>(
    load: impl Fn(ValueDeserializer<'_>) -> Result<Box<P>, toml::de::Error> + Sync + 'static,
) -> &'static Load<P> {
    Box::leak(Box::new(load))
}

/// Registers a class: `kind` is `task`, `constraint` or `reference`. One with the same `definition`, the qualified name
/// of a class, takes the place of an earlier one.
#[pyfunction]
pub(crate) fn _register(
    kind: &str,
    tag: &str,
    class_: Py<PyAny>,
    schema: &str,
    origin: String,
    definition: String,
) -> PyResult<()> {
    let schema: Value = wbqp::serde_json::from_str(schema)
        .map_err(|error| PyValueError::new_err(error.to_string()))?;
    let schema = Schema::try_from(schema).map_err(|e| PyValueError::new_err(e.to_string()))?;
    let class = Arc::new(class_);
    let tag = lasting(tag);
    let origin = origin.leak();
    let definition = Some(&*definition.leak());
    let schema = Box::leak(Box::new(move || schema.clone()));
    let parameters = move |value: ValueDeserializer<'_>| {
        let keys = Arc::new(toml::Table::deserialize(value)?);
        let parameters = Parameters {
            tag,
            class: Arc::clone(&class),
            keys,
        };
        let made = Python::attach(|py| match parameters.object(py) {
            Ok(_) => Ok(()),
            Err(error) => Err(error.value(py).to_string()),
        });
        match made {
            Ok(()) => Ok(parameters),
            Err(problem) => Err(serde::de::Error::custom(problem)),
        }
    };
    let added = match kind {
        "task" => registry::add(Plugin {
            tag,
            origin,
            definition,
            schema,
            load: leaked::<dyn AnyTask>(move |value| Ok(Box::new(PythonTask(parameters(value)?)))),
        }),
        "constraint" => registry::add(Plugin {
            tag,
            origin,
            definition,
            schema,
            load: leaked::<dyn AnyConstraint>(move |value| {
                Ok(Box::new(PythonConstraint(parameters(value)?)))
            }),
        }),
        _ => registry::add(Plugin {
            tag,
            origin,
            definition,
            schema,
            load: leaked::<dyn AnyReference>(move |value| {
                Ok(Box::new(PythonReference(parameters(value)?)))
            }),
        }),
    };
    added.map_err(|error| PyValueError::new_err(error.to_string()))
}
