//! The same rows as MuJoCo has them: `mujoco_rows.json`, which `python -m wbqp.experiments --plant mujoco` writes with
//! `--record FILE`. It is measured there and shown here.

use std::{collections::BTreeMap, sync::LazyLock};

use serde::Deserialize;
use wbqp::serde_json;
use wbqp_measures::Row;

/// The file, as it was when this crate was built.
const FILE: &str = include_str!("../mujoco_rows.json");

/// What was measured in MuJoCo.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mujoco {
    /// The engine with its version.
    pub engine: String,
    /// Its integration step, s.
    pub step: f64,
    /// Of the sensors' noise.
    pub seed: u64,
    /// Rows by experiment.
    pub experiments: BTreeMap<String, Vec<Measured>>,
}

/// A row.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measured {
    /// Row of the acceptance table.
    pub id: String,
    /// What is measured.
    pub quantity: String,
    /// The value; nothing if it could not be measured.
    pub measured: Option<f64>,
    /// Whether it is met; nothing for one that only informs.
    pub pass: Option<bool>,
}

impl Mujoco {
    /// What ships with this crate; nothing if the file is not what it should be.
    pub fn shipped() -> Option<&'static Self> {
        static READ: LazyLock<Option<Mujoco>> = LazyLock::new(|| serde_json::from_str(FILE).ok());
        READ.as_ref()
    }

    /// The same row.
    pub fn row(&self, experiment: &str, row: &Row) -> Option<&Measured> {
        let rows = self.experiments.get(experiment)?;
        rows.iter()
            .find(|other| other.id == row.id && other.quantity == row.quantity)
    }
}

/// The value for a table: with a mark if it is judged.
pub fn cell(measured: Option<&Measured>, number: impl Fn(f64) -> String) -> String {
    let Some(row) = measured else {
        return "–".to_owned();
    };
    let value = row.measured.map_or_else(|| "–".to_owned(), number);
    match row.pass {
        Some(true) => format!("{value} ✓"),
        Some(false) => format!("{value} ✗"),
        None => value,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_file_has_every_experiment() {
        let shipped = Mujoco::shipped().expect("the file is read");
        for experiment in wbqp_measures::experiments::ALL {
            let rows = shipped.experiments.get(experiment.name);
            assert!(
                rows.is_some_and(|rows| !rows.is_empty()),
                "{}",
                experiment.name
            );
        }
    }

    #[test]
    fn a_cell_says_whether_the_row_is_met() {
        let row = |pass| Measured {
            id: "B4".into(),
            quantity: "error".into(),
            measured: Some(0.25),
            pass,
        };
        let text = |pass| cell(Some(&row(pass)), |x| x.to_string());
        assert_eq!(text(Some(true)), "0.25 ✓");
        assert_eq!(text(Some(false)), "0.25 ✗");
        assert_eq!(text(None), "0.25");
        assert_eq!(cell(None, |x| x.to_string()), "–");
    }
}
