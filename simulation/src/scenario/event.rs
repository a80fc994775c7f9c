//! What changes at a given time of a run.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use wbqp::{
    config::{check_reference, in_words, plausible::WEIGHTS},
    controller::{Controller, RequestError},
    plugin::{AnyReference, PerRow},
};

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
            let done = controller.follow(task, reference);
            done.map_err(|e| format!("follow.{task}: {}", without_name(e)))?;
        }
        Ok(())
    }

    /// Looks at its weights and references as a controller's file would be looked at. Gives back what can hardly be
    /// meant.
    ///
    /// # Errors
    /// What cannot be meant, in words, behind the key.
    pub(super) fn check_numbers(&self, controller: &Controller) -> Result<Vec<String>, String> {
        for (name, weight) in &self.weight {
            let mut values = weight.values().iter();
            if let Some(weight) = values.find(|w| **w != 0.0 && !WEIGHTS.contains(*w)) {
                let [least, most] = [WEIGHTS.start(), WEIGHTS.end()];
                return Err(format!(
                    "weight.{name}: is {weight:e}, must be 0 or between {least:e} and {most:e}"
                ));
            }
        }
        let mut warnings = Vec::new();
        for (name, reference) in &self.follow {
            let mut layouts = controller.task_names().zip(controller.task_layouts());
            let found = layouts.find(|(task, _)| task == name);
            // Another task, or something else than a table, is refused where it is applied.
            let Some(((_, layout), reference)) = found.zip(reference.as_table()) else {
                continue;
            };
            let named = |what: String| format!("follow.{name}.{what}");
            let own = check_reference(reference, layout.unit_of_error()).map_err(named)?;
            warnings.extend(own.into_iter().map(named));
        }
        Ok(warnings)
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
