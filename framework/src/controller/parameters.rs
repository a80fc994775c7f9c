//! The parameters of a running plug-in as the keys of a file.

use std::any::Any;

use super::running::RunningPlugin;
use crate::{
    error::BindError,
    plugin::{AnyConstraint, AnyTask, Setup},
    problem::BoundEntry,
};

impl RunningPlugin {
    /// Its keys with their present values, as its file would have them.
    pub(super) fn parameters(&self) -> Result<toml::Table, BindError> {
        match self.plugin.table() {
            Ok(toml::Value::Table(table)) => Ok(table),
            Ok(_) => Ok(toml::Table::new()),
            Err(error) => Err(BindError::Other(error.to_string())),
        }
    }

    /// Replaces keys, all or none, checked as those of a file are.
    ///
    /// # Errors
    /// The plug-in has no such key, or refuses what it would have become; it is what it was then.
    pub(super) fn set(
        &mut self,
        keys: toml::Table,
        entry: &BoundEntry,
        setup: &mut Setup<'_>,
    ) -> Result<(), BindError> {
        let mut table = self.parameters()?;
        let is_plugin = |value: &toml::Value| value.get("type").is_some();
        for (key, value) in keys {
            if key == "type" || is_plugin(&value) || table.get(&key).is_some_and(is_plugin) {
                let problem = "cannot be changed here: a reference is replaced by `follow`, \
                               an entry of another type needs a new controller";
                return Err(BindError::value(&key, problem));
            }
            table.insert(key, value);
        }
        let table = toml::Value::Table(table);
        let parameters: Result<Box<dyn Any>, toml::de::Error> = if entry.is_task {
            let task = table.try_into::<Box<dyn AnyTask>>();
            task.map(|task| task as Box<dyn Any>)
        } else {
            let constraint = table.try_into::<Box<dyn AnyConstraint>>();
            constraint.map(|constraint| constraint as Box<dyn Any>)
        };
        let parameters =
            parameters.map_err(|error| BindError::Other(error.message().to_owned()))?;
        self.plugin.take(parameters, setup, &entry.layout)
    }
}
