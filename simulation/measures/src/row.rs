//! A row of results: what the paper says, what was measured, whether it is within tolerance.

use serde::{Deserialize, Serialize};

use crate::tick_time;

/// One figure of an experiment. `results.json` is a list of these, with exactly these keys.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// Row of the acceptance table, for example `B3`.
    pub id: String,
    /// What is measured, and over which window.
    pub quantity: String,
    /// Its unit.
    pub unit: String,
    /// The paper's value, where it has one.
    pub paper: Option<f64>,
    /// The value from the log; `null` if the log does not have it.
    pub measured: Option<f64>,
    /// What is accepted, in words.
    pub tolerance: String,
    /// Whether it is met; `null` for rows that only inform.
    pub pass: Option<bool>,
}

impl Row {
    /// A row that passes if the measured value exists and `accept` agrees.
    pub fn judged(
        id: &str,
        (quantity, unit): (&str, &str),
        paper: impl Into<Option<f64>>,
        measured: Option<f64>,
        tolerance: &str,
        accept: impl FnOnce(f64) -> bool,
    ) -> Self {
        Self {
            pass: Some(measured.is_some_and(accept)),
            ..Self::informative(id, (quantity, unit), paper, measured, tolerance)
        }
    }

    /// The measured value with its unit.
    pub fn measured_text(&self) -> String {
        match (self.measured, self.unit.as_str()) {
            (None, _) => "nothing".to_owned(),
            (Some(value), "1") => number(value),
            (Some(value), unit) => format!("{} {unit}", number(value)),
        }
    }

    /// Whether it is a time of the wall clock, which differs from run to run.
    pub fn is_wall_clock(&self) -> bool {
        self.id == tick_time::ID
    }

    /// A row that neither passes nor fails.
    pub fn informative(
        id: &str,
        (quantity, unit): (&str, &str),
        paper: impl Into<Option<f64>>,
        measured: Option<f64>,
        tolerance: &str,
    ) -> Self {
        Self {
            id: id.to_owned(),
            quantity: quantity.to_owned(),
            unit: unit.to_owned(),
            paper: paper.into(),
            measured: measured.filter(|m| m.is_finite()),
            tolerance: tolerance.to_owned(),
            pass: None,
        }
    }
}

/// Four significant digits, without trailing zeros.
pub fn number(value: f64) -> String {
    rounded(value, 4)
}

/// So many significant digits, without trailing zeros. What is below 1e-9 in any unit here is rounding: 0.
pub fn rounded(value: f64, digits: usize) -> String {
    if value.abs() < 1e-9 {
        return "0".to_owned();
    }
    let last = digits.saturating_sub(1);
    // Rounding first: 9.9996 has one digit more before the point.
    let scientific = format!("{value:.last$e}");
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: isize = exponent.parse().unwrap_or(0);
    let short = |text: &str| {
        if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            text.to_owned()
        }
    };
    if (-4..6).contains(&exponent) {
        let decimals = last.saturating_add_signed(-exponent);
        short(&format!("{value:.decimals$}"))
    } else {
        format!("{}e{exponent}", short(mantissa))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn serialises_with_exactly_the_promised_keys() {
        let row = Row::judged("B1", ("set point", "N"), 5.0, Some(5.0), "5 N", |m| {
            m == 5.0
        });
        assert_eq!(
            serde_json::to_string(&row).unwrap(),
            r#"{"id":"B1","quantity":"set point","unit":"N","paper":5.0,"measured":5.0,"tolerance":"5 N","pass":true}"#
        );
        let missing = Row::judged("B1", ("x", "N"), None, None, "", |_| true);
        assert_eq!((missing.pass, missing.paper), (Some(false), None));
        let not_finite = Row::judged("B1", ("x", "N"), None, Some(f64::NAN), "", |m| m < 1.0);
        assert_eq!((not_finite.pass, not_finite.measured), (Some(false), None));
    }

    #[test]
    fn numbers_are_short() {
        for (value, text) in [
            (5.0, "5"),
            (0.123456, "0.1235"),
            (1e-5, "1e-5"),
            (1.2346e-5, "1.235e-5"),
            (-1.2e-12, "0"),
            (9.99996, "10"),
            (0.99996, "1"),
            (-12.3456, "-12.35"),
            (1500.0, "1500"),
            (0.0, "0"),
        ] {
            assert_eq!(number(value), text);
        }
        assert_eq!(rounded(0.99951, 3), "1");
        assert_eq!(rounded(1234.6, 3), "1235");
    }
}
