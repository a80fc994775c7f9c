//! Which rows of the acceptance table are promised, and which are missed and why: `promised_rows.toml`.
//!
//! The exit code of `replicate`, the acceptance tests, the report and `docs/replication.md` all follow this file.

use std::{collections::BTreeMap, fmt, sync::LazyLock};

use serde::Deserialize;

use crate::{Row, experiments};

/// The file, as it was when this crate was built.
const FILE: &str = include_str!("../promised_rows.toml");

/// Names a row: its id alone may stand for several.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Key {
    /// Row of the acceptance table.
    pub id: String,
    /// What is measured.
    pub quantity: String,
}

impl Key {
    /// The key of a row.
    pub fn of(row: &Row) -> Self {
        Self {
            id: row.id.clone(),
            quantity: row.quantity.clone(),
        }
    }

    fn is_of(&self, row: &Row) -> bool {
        self.id == row.id && self.quantity == row.quantity
    }
}

impl fmt::Display for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} \"{}\"", self.id, self.quantity)
    }
}

/// A row that is not met.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Missed {
    /// Row of the acceptance table.
    pub id: String,
    /// What is measured.
    pub quantity: String,
    /// Why it is not met.
    pub reason: String,
}

/// What is said about a row.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Remark {
    /// Row of the acceptance table.
    pub id: String,
    /// What is measured.
    pub quantity: String,
    /// What is said.
    pub text: String,
}

impl Missed {
    /// The row's key.
    pub fn key(&self) -> Key {
        Key {
            id: self.id.clone(),
            quantity: self.quantity.clone(),
        }
    }
}

impl Remark {
    /// The row's key.
    pub fn key(&self) -> Key {
        Key {
            id: self.id.clone(),
            quantity: self.quantity.clone(),
        }
    }
}

/// What is promised of one experiment.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Promises {
    /// Rows that must be met.
    pub promised: Vec<Key>,
    /// Rows that are not met, each with its reason. One that is met after all must move to the promised ones.
    pub missed: Vec<Missed>,
    /// What else there is to say about a row, where it differs from the paper.
    pub remark: Vec<Remark>,
}

/// Why measured rows are not what is promised.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Breach {
    /// A promised row is not met.
    #[error("{key} is promised but missed: measured {measured}, accepted {tolerance}")]
    Missed {
        /// The row.
        key: Key,
        /// Its value in its unit, in words.
        measured: String,
        /// What is accepted.
        tolerance: String,
    },
    /// A row that is listed as missed is met.
    #[error("{0} is listed as missed but met: move it to the promised rows")]
    Met(Key),
    /// A judged row is in no list.
    #[error("{0} is judged but neither promised nor listed as missed")]
    Unlisted(Key),
    /// A row of a list is not there.
    #[error("{0} is listed but not measured")]
    Unmeasured(Key),
    /// A row that only informs is promised or listed as missed.
    #[error("{0} is listed but only informs")]
    Informative(Key),
    /// Two measured rows have one name.
    #[error("{0} is measured twice")]
    Twice(Key),
}

/// Why the file is refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PromiseError {
    /// It is not TOML of this shape.
    #[error("promised_rows.toml: {0}")]
    Syntax(#[from] toml::de::Error),
    /// An experiment that does not exist.
    #[error("promised_rows.toml: there is no experiment `{name}`; known: {known}")]
    Experiment {
        /// Its name.
        name: String,
        /// All experiments.
        known: String,
    },
    /// One row in two places.
    #[error("promised_rows.toml: {experiment}: {key} is listed twice")]
    Twice {
        /// The experiment.
        experiment: String,
        /// The row.
        key: Key,
    },
    /// A row without reason, or a remark without words.
    #[error("promised_rows.toml: {experiment}: {key} has no text")]
    Silent {
        /// The experiment.
        experiment: String,
        /// The row.
        key: Key,
    },
}

/// Reads a text in the form of `promised_rows.toml`. `known` are the experiments' names.
///
/// # Errors
/// [`PromiseError`].
pub fn parse(text: &str, known: &[&str]) -> Result<BTreeMap<String, Promises>, PromiseError> {
    let all: BTreeMap<String, Promises> = toml::from_str(text)?;
    for (name, promises) in &all {
        if !known.contains(&name.as_str()) {
            return Err(PromiseError::Experiment {
                name: name.clone(),
                known: known.join(", "),
            });
        }
        let experiment = || name.clone();
        let mut listed: Vec<Key> = promises.listed().collect();
        listed.sort_unstable();
        if let Some(pair) = listed.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(PromiseError::Twice {
                experiment: experiment(),
                key: pair[0].clone(),
            });
        }
        let reasons = promises.missed.iter().map(|m| (m.key(), &m.reason));
        let remarks = promises.remark.iter().map(|r| (r.key(), &r.text));
        let silent = reasons.chain(remarks).find(|(_, t)| t.trim().is_empty());
        if let Some((key, _)) = silent {
            return Err(PromiseError::Silent {
                experiment: experiment(),
                key,
            });
        }
    }
    Ok(all)
}

/// What is promised of an experiment; nothing if the file does not name it.
///
/// # Errors
/// [`PromiseError`] if the file is wrong.
pub fn of(experiment: &str) -> Result<&'static Promises, PromiseError> {
    static ALL: LazyLock<Result<BTreeMap<String, Promises>, PromiseError>> = LazyLock::new(|| {
        let known: Vec<&str> = experiments::ALL.iter().map(|e| e.name).collect();
        parse(FILE, &known)
    });
    static NOTHING: Promises = Promises {
        promised: Vec::new(),
        missed: Vec::new(),
        remark: Vec::new(),
    };
    let all = ALL.as_ref().map_err(Clone::clone)?;
    Ok(all.get(experiment).unwrap_or(&NOTHING))
}

impl Promises {
    /// Promised and missed rows.
    fn listed(&self) -> impl Iterator<Item = Key> {
        let missed = self.missed.iter().map(Missed::key);
        self.promised.iter().cloned().chain(missed)
    }

    /// Why a row may be missed, if it may.
    pub fn reason(&self, row: &Row) -> Option<&str> {
        let missed = self.missed.iter().find(|m| m.key().is_of(row))?;
        Some(&missed.reason)
    }

    /// In what the measured rows differ from what is promised.
    pub fn breaches(&self, rows: &[Row]) -> Vec<Breach> {
        let mut breaches = Vec::new();
        for (i, row) in rows.iter().enumerate() {
            let key = Key::of(row);
            if rows[..i].iter().any(|r| key.is_of(r)) {
                breaches.push(Breach::Twice(key.clone()));
            }
            let promised = self.promised.contains(&key);
            let listed = promised || self.reason(row).is_some();
            match row.pass {
                Some(_) if !listed => breaches.push(Breach::Unlisted(key)),
                Some(false) if promised => breaches.push(Breach::Missed {
                    key,
                    measured: row.measured_text(),
                    tolerance: row.tolerance.clone(),
                }),
                Some(true) if !promised => breaches.push(Breach::Met(key)),
                None if listed => breaches.push(Breach::Informative(key)),
                _ => {}
            }
        }
        let remarks = self.remark.iter().map(Remark::key);
        let lost = self
            .listed()
            .chain(remarks)
            .filter(|key| !rows.iter().any(|row| key.is_of(row)));
        breaches.extend(lost.map(Breach::Unmeasured));
        breaches
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r#"
        [push]
        promised = [{ id = "B1", quantity = "force" }, { id = "B1", quantity = "time" }]
        [[push.missed]]
        id = "B2"
        quantity = "pitch"
        reason = "the plant is honest"
    "#;

    fn row(id: &str, quantity: &str, pass: Option<bool>) -> Row {
        Row {
            pass,
            ..Row::informative(id, (quantity, "N"), None, Some(1.0), "0 N")
        }
    }

    fn breaches(rows: &[Row]) -> Vec<String> {
        let all = parse(TEXT, &["push"]).unwrap();
        let breaches = all["push"].breaches(rows);
        breaches.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn rows_as_promised_breach_nothing() {
        let mut rows = vec![
            row("B1", "force", Some(true)),
            row("B1", "time", Some(true)),
            row("B2", "pitch", Some(false)),
            row("B3", "clock", None),
        ];
        assert_eq!(breaches(&rows), [""; 0]);
        rows[0].pass = Some(false);
        rows[2].pass = Some(true);
        rows[3].pass = Some(true);
        assert_eq!(
            breaches(&rows),
            [
                "B1 \"force\" is promised but missed: measured 1 N, accepted 0 N",
                "B2 \"pitch\" is listed as missed but met: move it to the promised rows",
                "B3 \"clock\" is judged but neither promised nor listed as missed",
            ]
        );
    }

    #[test]
    fn rows_that_are_gone_or_no_longer_judged_are_named() {
        let rows = [
            row("B1", "force", None),
            row("B1", "time", Some(true)),
            row("B1", "time", Some(true)),
        ];
        assert_eq!(
            breaches(&rows),
            [
                "B1 \"force\" is listed but only informs",
                "B1 \"time\" is measured twice",
                "B2 \"pitch\" is listed but not measured",
            ]
        );
    }

    #[test]
    fn a_wrong_file_is_refused() {
        let wrong = |text: &str| parse(text, &["push"]).unwrap_err().to_string();
        assert!(wrong("[pull]").contains("there is no experiment `pull`; known: push"));
        let twice = TEXT.replace("quantity = \"time\"", "quantity = \"force\"");
        assert!(wrong(&twice).contains("B1 \"force\" is listed twice"));
        let silent = TEXT.replace("the plant is honest", " ");
        assert!(wrong(&silent).contains("B2 \"pitch\" has no text"));
        assert!(wrong(&TEXT.replace("reason", "because")).contains("unknown field `because`"));
    }

    #[test]
    fn the_file_that_ships_is_good_and_has_every_experiment() {
        for experiment in experiments::ALL {
            let promises = of(experiment.name).unwrap();
            assert!(!promises.promised.is_empty(), "{}", experiment.name);
        }
    }
}
