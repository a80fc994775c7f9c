//! Values given on the command line: `--set key=value`.

use std::str::FromStr;

use anyhow::{Context, Result, bail};
use wbqp::{
    config::{Overrides, key_path},
    suggestion::suggestion,
};
use wbqp_sim::Variation;

/// One `key=value`.
///
/// A key is one of the controller's file, as in a case's `set`: `task.com.kp`, `contact.tip.friction`,
/// `controller.rate`. With `change.` before it, it is one of the scenario's file, as in a case's `change`:
/// `change.duration`, `change.plant.mismatch.mass_scale`. The value is TOML; what is no TOML value is a text, so that
/// quotation marks can be left out.
#[derive(Clone, Debug, PartialEq)]
pub struct Assignment {
    key: String,
    value: toml::Value,
}

const OF_A_SCENARIO: &str = "change.";

impl FromStr for Assignment {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let Some((key, value)) = text.split_once('=') else {
            return Err("must be KEY=VALUE".to_owned());
        };
        let (key, value) = (key.trim(), value.trim());
        let keys = key_path(key).ok_or_else(|| format!("`{key}` is not a key of a TOML file"))?;
        let first = keys.first().map_or("", String::as_str);
        if !key.starts_with(OF_A_SCENARIO) && !Overrides::TABLES.contains(&first) {
            let hint = match first {
                "duration" | "initial" | "plant" | "sensors" | "detector" | "event" => {
                    format!("; what is the scenario's begins with `change.`: `change.{key}`")
                }
                _ => suggestion(first, &Overrides::TABLES),
            };
            return Err(format!("a controller's file has no table `{first}`{hint}"));
        }
        if is_too_large(value) {
            return Err(format!("{value}: is larger than any number of 64 bits"));
        }
        let table = format!("value = {value}").parse::<toml::Table>().ok();
        if table.as_ref().is_some_and(|table| table.len() > 1) {
            return Err(format!(
                "{key}: more than one value: give each its own option"
            ));
        }
        let value = table
            .and_then(|mut table| table.remove("value"))
            .unwrap_or_else(|| value.into());
        Ok(Self {
            key: key.to_owned(),
            value,
        })
    }
}

/// Whether a text is a number that TOML has no room for: taken for a text, it would be refused as one.
fn is_too_large(value: &str) -> bool {
    let digits = value.trim_start_matches(['+', '-']);
    let is_whole = digits.chars().all(|c| c.is_ascii_digit()) && !digits.starts_with('0');
    let number = value.parse::<f64>();
    digits.starts_with(|c: char| c.is_ascii_digit())
        && (number.is_ok_and(f64::is_infinite) || is_whole && value.parse::<i64>().is_err())
}

impl Assignment {
    /// The value of a key, for what another option stands for.
    pub fn new(key: &str, value: impl Into<toml::Value>) -> Self {
        Self {
            key: key.to_owned(),
            value: value.into(),
        }
    }

    /// Whether it is a value of the scenario's file.
    pub fn is_of_scenario(&self) -> bool {
        self.key.starts_with(OF_A_SCENARIO)
    }

    /// Whether it is this key, or a value inside this table.
    pub fn is_of(&self, key: &str) -> bool {
        let rest = self.key.strip_prefix(key);
        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
    }

    /// Key and value of one of the table `[robot]`.
    pub fn robot_key(&self) -> Option<(&str, &toml::Value)> {
        Some((self.key.strip_prefix("robot.")?, &self.value))
    }

    /// What they change in a scenario; of two for one key the later counts.
    ///
    /// # Errors
    /// A key that is none of a controller's or a scenario's file.
    pub fn variation(list: &[Self]) -> Result<Variation> {
        let all = list.iter().try_fold(Variation::new(), |all, each| {
            let Self { key, value } = each;
            let prefix = if each.is_of_scenario() { "" } else { "set." };
            let one = Variation::from_toml(&format!("{prefix}{key} = {value}"))
                .with_context(|| format!("--set {key}"))?;
            anyhow::Ok(all.then(&one))
        })?;
        Ok(all.given_by("--set"))
    }

    /// What they change in a controller's file.
    ///
    /// # Errors
    /// A key that is not one of a controller's file.
    pub fn overrides(list: &[Self]) -> Result<Overrides> {
        let mut overrides = Overrides::new();
        for each in list {
            let Self { key, value } = each;
            if each.is_of_scenario() {
                bail!("--set {key}: there is no scenario to change, only a controller");
            }
            let one: Overrides = toml::from_str(&format!("{key} = {value}"))
                .with_context(|| format!("--set {key}"))?;
            overrides.append(&one);
        }
        Ok(overrides)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Assignment {
        text.parse().unwrap()
    }

    #[test]
    fn without_a_prefix_it_is_the_controllers_with_one_the_scenarios() {
        let list = [
            read("task.com.kp=50"),
            read("change.duration = 2"),
            read("task.com.kp=60"),
            read("task.force.feedback=off"),
        ];
        let expected = Variation::new()
            .set("task.com.kp", 60)
            .change("duration", 2)
            .set("task.force.feedback", "off");
        let found = Assignment::variation(&list).unwrap();
        // An override that is replaced stays in the list, so they are compared as they are applied.
        let twice = Variation::new().set("task.com.kp", 50).then(&expected);
        let twice = twice.given_by("--set");
        assert_eq!(found, twice);
        assert!(Assignment::overrides(&list).is_err());
    }

    #[test]
    fn keys_that_are_nowhere_are_refused_with_a_hint() {
        let refused = |text: &str| Assignment::from_str(text).unwrap_err();
        assert!(refused("duration=2").contains("`change.duration`"));
        for value in ["1e400", "-1e400", "99999999999999999999"] {
            let words = refused(&format!("task.com.kp={value}"));
            assert!(words.contains("is larger than any number"), "{words}");
        }
        for value in ["1e300", "inf", "0x10", "9223372036854775807", "a1"] {
            read(&format!("task.com.kp={value}"));
        }
        assert!(refused("tsk.com.kp=2").contains("did you mean `task`"));
        assert!(refused("task.com.kp=2\nweight=3").contains("more than one value"));
        read("task.com.kp=[1,\n2]");
        assert!(refused("task com=2").contains("not a key"));
        assert!(refused("task.com.kp").contains("KEY=VALUE"));
    }
}
