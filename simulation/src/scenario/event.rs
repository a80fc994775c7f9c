//! What changes at a given time of a run.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use wbqp::{
    config::in_words,
    controller::Controller,
    plugin::{AnyReference, PerRow},
};

/// Weights beyond these, and zero, are refused as in a controller's file.
const WEIGHTS: std::ops::RangeInclusive<f64> = 1e-100..=1e100;
/// No robot's reference has such a number: larger than anything that is taken with a warning in a controller's file.
const LARGEST_VALUE: f64 = 1e14;

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
            check_weight(name, weight)?;
        }
        for (task, value) in &self.follow {
            if !value.is_table() {
                return Err(format!(
                    "follow.{task}: must be a table with a `type`, found {}",
                    value.type_str()
                ));
            }
            let reference = <Box<dyn AnyReference>>::deserialize(value.clone())
                .map_err(|e| format!("follow.{task}: {}", in_words(e.message())))?;
            let values = check_values(task, &*reference);
            controller.follow(task, reference).map_err(text)?;
            values?;
        }
        Ok(())
    }
}

fn check_weight(name: &str, weight: &PerRow) -> Result<(), String> {
    let mut values = weight.values().iter();
    let odd = values.find(|w| **w != 0.0 && !WEIGHTS.contains(*w));
    let [least, most] = [WEIGHTS.start(), WEIGHTS.end()];
    odd.map_or(Ok(()), |w| {
        Err(format!(
            "weight.{name}: is {w:e}, must be 0 or between {least:e} and {most:e}"
        ))
    })
}

fn check_values(task: &str, reference: &dyn AnyReference) -> Result<(), String> {
    for (key, values) in reference.named_values() {
        if let Some(odd) = values.iter().find(|x| x.abs() > LARGEST_VALUE) {
            return Err(format!(
                "follow.{task}.{key}: has {odd:e}: check the digits"
            ));
        }
    }
    Ok(())
}
