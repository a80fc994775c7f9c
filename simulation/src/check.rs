//! Collects what is to be said of a configuration, by key.

use wbqp::{config::plausible, model::Model, suggestion::suggestion};

/// The smallest number that may have to be divided by.
const SMALLEST: f64 = 1e-100;

/// What is wrong, and what can hardly be meant, one line per key.
#[derive(Debug, Default)]
pub(crate) struct Problems {
    refused: Vec<String>,
    warnings: Vec<String>,
}

impl Problems {
    /// Notes a problem with a key.
    pub(crate) fn add(&mut self, key: &str, what: &str) {
        self.refused.push(format!("{key}: {what}"));
    }

    /// A name that logs and messages can have on a line.
    pub(crate) fn name(&mut self, key: &str, name: &str) {
        if let Err(what) = plausible::check_name(name) {
            self.add(key, what);
        }
    }

    /// A finite number above zero.
    pub(crate) fn positive(&mut self, key: &str, value: f64, unit: &str) {
        if value.is_finite() {
            self.above_zero(key, value, unit);
        } else {
            self.add(key, &format!("is {value}, must be positive and finite"));
        }
    }

    /// A number above zero, or infinity for no limit.
    pub(crate) fn limit(&mut self, key: &str, value: f64, unit: &str) {
        if value.is_nan() || value <= 0.0 {
            self.add(key, &format!("is {value}, must be positive"));
        } else if value.is_finite() {
            self.above_zero(key, value, unit);
        }
    }

    fn above_zero(&mut self, key: &str, value: f64, unit: &str) {
        if value <= 0.0 {
            self.add(key, &format!("is {value}, must be positive and finite"));
        } else if value < SMALLEST {
            let what = format!("is {value:e}, must not be smaller than {SMALLEST:e}");
            self.add(key, &what);
        } else {
            self.size(key, value, unit);
        }
    }

    /// A finite number, zero or above.
    pub(crate) fn not_negative(&mut self, key: &str, value: f64, unit: &str) {
        if !value.is_finite() || value < 0.0 {
            self.add(key, &format!("is {value}, must be finite and not negative"));
        } else {
            self.size(key, value, unit);
        }
    }

    /// A finite number.
    pub(crate) fn number(&mut self, key: &str, value: f64, unit: &str) {
        if value.is_finite() {
            self.size(key, value, unit);
        } else {
            self.add(key, &format!("is {value}, must be finite"));
        }
    }

    /// Finite numbers.
    pub(crate) fn finite(&mut self, key: &str, values: &[f64], unit: &str) {
        if values.iter().all(|x| x.is_finite()) {
            for (index, value) in values.iter().enumerate() {
                self.size(&format!("{key}[{index}]"), *value, unit);
            }
        } else {
            self.add(key, &format!("is {values:?}, must be finite"));
        }
    }

    /// Whether a number can be meant.
    fn size(&mut self, key: &str, value: f64, unit: &str) {
        let name = key.rsplit([' ', '.']).next().unwrap_or(key);
        match plausible::check(name, value, unit) {
            Ok(None) => {}
            Ok(Some(what)) => self.warnings.push(format!("{key}: {what}")),
            Err(what) => self.add(key, &what),
        }
    }

    /// What can hardly be meant.
    pub(crate) fn into_warnings(self) -> Vec<String> {
        self.warnings
    }

    /// All problems, or none.
    pub(crate) fn into_result<E>(self, error: impl FnOnce(Vec<String>) -> E) -> Result<(), E> {
        if self.refused.is_empty() {
            Ok(())
        } else {
            Err(error(self.refused))
        }
    }
}

/// What is said of a frame that the robot does not have.
pub(crate) fn unknown_frame(model: &Model, name: &str) -> String {
    let known: Vec<&str> = model.frames().iter().map(|f| f.name.as_str()).collect();
    let hint = suggestion(name, &known);
    format!("robot `{}` has no frame `{name}`{hint}", model.name())
}
