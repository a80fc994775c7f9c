//! Collects everything that is wrong with a configuration, by key.

use wbqp::{model::Model, suggestion::suggestion};

/// Nothing that is simulated is larger, and squares of it do not overflow.
const LARGEST: f64 = 1e100;

/// What is wrong, one line per key.
#[derive(Debug, Default)]
pub(crate) struct Problems(Vec<String>);

impl Problems {
    /// Notes a problem with a key.
    pub(crate) fn add(&mut self, key: &str, what: &str) {
        self.0.push(format!("{key}: {what}"));
    }

    /// A number above zero; infinite only if `infinite` says that it means "no limit".
    pub(crate) fn positive(&mut self, key: &str, value: f64, infinite: bool) {
        if value.is_nan() || value <= 0.0 || (!infinite && value.is_infinite()) {
            let finite = if infinite { "" } else { " and finite" };
            self.add(key, &format!("is {value}, must be positive{finite}"));
        } else if value < 1.0 / LARGEST {
            self.add(
                key,
                &format!("is {value:e}, must not be smaller than {:e}", 1.0 / LARGEST),
            );
        } else if value.is_finite() {
            self.size(key, value);
        }
    }

    /// A finite number, zero or above.
    pub(crate) fn not_negative(&mut self, key: &str, value: f64) {
        if !value.is_finite() || value < 0.0 {
            self.add(key, &format!("is {value}, must be finite and not negative"));
        } else {
            self.size(key, value);
        }
    }

    /// A finite number.
    pub(crate) fn number(&mut self, key: &str, value: f64) {
        if value.is_finite() {
            self.size(key, value);
        } else {
            self.add(key, &format!("is {value}, must be finite"));
        }
    }

    /// Finite numbers.
    pub(crate) fn finite(&mut self, key: &str, values: &[f64]) {
        if !values.iter().all(|x| x.is_finite()) {
            self.add(key, &format!("is {values:?}, must be finite"));
        } else if let Some(largest) = values.iter().find(|x| x.abs() > LARGEST) {
            self.size(key, *largest);
        }
    }

    fn size(&mut self, key: &str, value: f64) {
        if value.abs() > LARGEST {
            self.add(
                key,
                &format!("is {value:e}, must not be larger than {LARGEST:e}"),
            );
        }
    }

    /// All problems, or none.
    pub(crate) fn into_result<E>(self, error: impl FnOnce(Vec<String>) -> E) -> Result<(), E> {
        if self.0.is_empty() {
            Ok(())
        } else {
            Err(error(self.0))
        }
    }
}

/// What is said of a frame that the robot does not have.
pub(crate) fn unknown_frame(model: &Model, name: &str) -> String {
    let known: Vec<&str> = model.frames().iter().map(|f| f.name.as_str()).collect();
    let hint = suggestion(name, &known);
    format!("robot `{}` has no frame `{name}`{hint}", model.name())
}
