//! Whether a surface is touched, from the measured normal force.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error::BindError;

/// A threshold with hysteresis and dwell: touching when the normal force has stayed above `on` for `dwell`,
/// not touching when it has stayed below `off` for as long.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Detector {
    /// The contact.
    pub contact: String,
    /// Touching above this normal force, N.
    #[serde(default = "default_on")]
    pub on: f64,
    /// Released below this normal force, N.
    #[serde(default = "default_off")]
    pub off: f64,
    /// How long the force must stay beyond a threshold, s.
    #[serde(default = "default_dwell")]
    pub dwell: f64,
    #[serde(skip)]
    touching: bool,
    /// Since when the force has been beyond the threshold that would change the answer.
    #[serde(skip)]
    beyond_since: Option<f64>,
}

fn default_on() -> f64 {
    1.0
}
fn default_off() -> f64 {
    0.3
}
fn default_dwell() -> f64 {
    0.02
}

impl Detector {
    /// With the default thresholds: on at 1.0 N, off at 0.3 N, after 20 ms.
    pub fn new(contact: &str) -> Self {
        Self {
            contact: contact.to_owned(),
            on: default_on(),
            off: default_off(),
            dwell: default_dwell(),
            touching: false,
            beyond_since: None,
        }
    }

    /// Checks the thresholds.
    ///
    /// # Errors
    /// [`BindError::Value`] naming the key.
    pub fn validate(&self) -> Result<(), BindError> {
        if !(self.on.is_finite() && self.off.is_finite() && self.on > self.off) {
            let problem = format!("is {} N, must be above off = {} N", self.on, self.off);
            return Err(BindError::value("on", problem));
        }
        if self.off < 0.0 {
            let problem = format!(
                "is {} N, must not be negative: in the air a sensor that was tared says zero, and noise",
                self.off
            );
            return Err(BindError::value("off", problem));
        }
        if !(self.dwell.is_finite() && self.dwell >= 0.0) {
            let problem = format!("is {} s, must be finite and not negative", self.dwell);
            return Err(BindError::value("dwell", problem));
        }
        Ok(())
    }

    /// Whether the surface counts as touched.
    pub fn is_touching(&self) -> bool {
        self.touching
    }

    /// Takes a measured normal force (N) at a time (s) and says whether the answer of
    /// [`is_touching`](Self::is_touching) has changed. After a time that is earlier than the last one `dwell` counts
    /// anew; one that is not a number is passed over.
    #[must_use]
    pub fn update(&mut self, time: f64, normal_force: f64) -> bool {
        if !time.is_finite() {
            return false;
        }
        let beyond = if self.touching {
            normal_force < self.off
        } else {
            normal_force > self.on
        };
        if !beyond {
            self.beyond_since = None;
            return false;
        }
        let since = self.beyond_since.filter(|since| *since <= time);
        let since = *self.beyond_since.insert(since.unwrap_or(time));
        // Half a nanosecond of slack: sums of sampling periods are not exact.
        if time - since + 5e-10 < self.dwell {
            return false;
        }
        self.beyond_since = None;
        self.touching = !self.touching;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::Detector;

    #[test]
    fn a_short_peak_is_no_contact_and_hysteresis_holds() {
        let mut d = Detector::new("tip");
        let period = 0.004;
        let mut changes = Vec::new();
        // 12 ms peak, pause, then firm contact that sags to 0.5 N, then release.
        let force = |k: usize| match k {
            5..8 => 3.0,
            20..100 => 5.0,
            100..150 => 0.5,
            150.. => 0.1,
            _ => 0.0,
        };
        for k in 0..200 {
            if d.update(k as f64 * period, force(k)) {
                changes.push((k, d.is_touching()));
            }
        }
        assert_eq!(changes, [(25, true), (155, false)]);
    }

    #[test]
    fn a_clock_that_was_set_back_counts_from_there() {
        let mut d = Detector::new("tip");
        assert!(!d.update(1000.0, 5.0) && !d.update(f64::NAN, 5.0));
        let touch = (0..10).find(|k| d.update(900.0 + 0.004 * f64::from(*k), 5.0));
        assert_eq!(touch, Some(5), "20 ms after the first one of the new clock");
    }
}
