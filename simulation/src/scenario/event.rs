//! What changes at a given time of a run.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use wbqp::{
    controller::Controller,
    plugin::{AnyReference, PerRow},
};

/// Everything that happens at one time. Actions are applied in the order of the fields.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Event {
    /// When, s: before the first tick at or after this time, which must not be after the run's end.
    pub at: f64,
    /// Name under which the log's timeline keeps the time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mark: Option<String>,
    /// Contacts whose force-torque sensor says zero now.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tare: Vec<String>,
    /// Contacts to switch off.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub deactivate_contact: Vec<String>,
    /// Contacts to switch on.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub activate_contact: Vec<String>,
    /// Tasks and constraints to switch off.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub deactivate: Vec<String>,
    /// Tasks and constraints to switch on.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub activate: Vec<String>,
    /// New weights by entry.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub weight: BTreeMap<String, PerRow>,
    /// New references by task; their times count from the event.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    #[schemars(with = "BTreeMap<String, Box<dyn AnyReference>>")]
    pub follow: BTreeMap<String, toml::Value>,
}

impl Event {
    /// Does everything to a controller.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn apply(&self, controller: &mut Controller) -> Result<(), String> {
        if !(self.at.is_finite() && self.at >= 0.0) {
            return Err("`at` must be finite and not negative".into());
        }
        let text = |e: wbqp::controller::RequestError| e.to_string();
        for name in &self.tare {
            controller.tare(name).map_err(text)?;
        }
        for name in &self.deactivate_contact {
            controller.deactivate_contact(name).map_err(text)?;
        }
        for name in &self.activate_contact {
            controller.activate_contact(name).map_err(text)?;
        }
        for name in &self.deactivate {
            controller.deactivate(name).map_err(text)?;
        }
        for name in &self.activate {
            controller.activate(name).map_err(text)?;
        }
        for (name, weight) in &self.weight {
            controller.reweight(name, weight.clone()).map_err(text)?;
        }
        for (task, value) in &self.follow {
            if !value.is_table() {
                return Err(format!(
                    "follow.{task}: must be a table with a `type`, found {}",
                    value.type_str()
                ));
            }
            let reference = <Box<dyn AnyReference>>::deserialize(value.clone())
                .map_err(|e| format!("follow.{task}: {}", e.message().trim_end()))?;
            controller.follow(task, reference).map_err(text)?;
        }
        Ok(())
    }
}
