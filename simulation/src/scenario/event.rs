//! What changes at a given time of a run.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use wbqp::{
    config::in_words,
    controller::{Controller, RequestError},
    plugin::{AnyReference, PerRow},
};

/// Weights beyond these, and zero, are refused as in a controller's file.
const WEIGHTS: std::ops::RangeInclusive<f64> = 1e-100..=1e100;
/// No robot's reference has such a number: larger than anything that is taken with a warning in a controller's file.
const LARGEST_VALUE: f64 = 1e14;

/// What is done to something of a controller that has a name.
type Act = fn(&mut Controller, &str) -> Result<(), RequestError>;

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
    /// What is wrong, in words, behind the key.
    pub fn apply(&self, controller: &mut Controller) -> Result<(), String> {
        if !(self.at.is_finite() && self.at >= 0.0) {
            return Err("at: must be finite and not negative".into());
        }
        let switches: [(_, _, Act); 5] = [
            ("tare", &self.tare, Controller::tare),
            (
                "deactivate_contact",
                &self.deactivate_contact,
                Controller::deactivate_contact,
            ),
            (
                "activate_contact",
                &self.activate_contact,
                Controller::activate_contact,
            ),
            ("deactivate", &self.deactivate, Controller::deactivate),
            ("activate", &self.activate, Controller::activate),
        ];
        for (key, names, act) in switches {
            for name in names {
                act(controller, name).map_err(|e| format!("{key}: {e}"))?;
            }
        }
        for (name, weight) in &self.weight {
            let done = controller.reweight(name, weight.clone());
            done.map_err(|e| format!("weight.{name}: {}", without_name(e)))?;
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
            let done = controller.follow(task, reference);
            done.map_err(|e| format!("follow.{task}: {}", without_name(e)))?;
            values?;
        }
        Ok(())
    }

    /// Whether nothing happens, and nothing is told, at its time.
    pub(super) fn is_idle(&self) -> bool {
        let Self {
            at: _,
            mark,
            tare,
            deactivate_contact,
            activate_contact,
            deactivate,
            activate,
            weight,
            follow,
        } = self;
        let lists = [
            tare,
            deactivate_contact,
            activate_contact,
            deactivate,
            activate,
        ];
        let is_silent = lists.into_iter().all(Vec::is_empty);
        mark.is_none() && is_silent && weight.is_empty() && follow.is_empty()
    }
}

/// What is wrong, behind a key that names the entry already.
fn without_name(error: RequestError) -> String {
    match error {
        RequestError::Value { source, .. } => source.to_string(),
        other => other.to_string(),
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
