//! Changes of keys while a controller runs: a class that was defined anew since is not that of the controller.

use std::sync::Arc;

use pyo3::prelude::*;
use wbqp::{Controller, controller::RequestError, error::BindError};

use super::{constraint::PythonConstraint, parameters::Parameters, task::PythonTask};

/// [`Controller::set`], for entries written in Python with the class that the controller was made with.
///
/// # Errors
/// As there.
pub(crate) fn set(
    controller: &mut Controller,
    entry: &str,
    keys: toml::Table,
) -> Result<(), RequestError> {
    if let Ok(task) = controller.parameters_mut::<PythonTask>(entry) {
        let changed = changed(&task.0, keys);
        let changed = changed.map_err(|source| refused(entry, source))?;
        controller.change(entry, |task: &mut PythonTask| task.0 = changed)
    } else if let Ok(constraint) = controller.parameters_mut::<PythonConstraint>(entry) {
        let changed = changed(&constraint.0, keys);
        let changed = changed.map_err(|source| refused(entry, source))?;
        controller.change(entry, |constraint: &mut PythonConstraint| {
            constraint.0 = changed;
        })
    } else {
        controller.set(entry, keys)
    }
}

fn refused(entry: &str, source: BindError) -> RequestError {
    RequestError::Value {
        name: entry.to_owned(),
        source,
    }
}

/// Parameters with some keys replaced, if their class takes them.
fn changed(parameters: &Parameters, keys: toml::Table) -> Result<Parameters, BindError> {
    let mut table = (*parameters.keys).clone();
    if keys.contains_key("type") {
        let problem = "cannot be changed here: an entry of another type needs a new controller";
        return Err(BindError::value("type", problem));
    }
    table.extend(keys);
    let changed = Parameters {
        keys: Arc::new(table),
        ..parameters.clone()
    };
    Python::attach(|py| match changed.object(py) {
        Ok(_) => Ok(()),
        Err(error) => Err(BindError::Other(error.value(py).to_string())),
    })?;
    Ok(changed)
}
