//! Experiment E as it ships: every row of its table.

use std::{env, fs, path::PathBuf, process};

use wbqp_examples::{cli::Common, under_actuated};

/// Rows that are missed, each with its reason. They must be missed: one that is met leaves this list.
const MISSED: &[(&str, &str, &str)] = &[];

/// A directory that goes away with its owner.
struct Temporary(PathBuf);

impl Drop for Temporary {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

#[test]
fn every_row_is_met() {
    let out = Temporary(env::temp_dir().join(format!("wbqp-under-actuated-{}", process::id())));
    let args = Common {
        out: out.0.clone(),
        seed: 1,
        scenario: None,
    };
    let outcome = under_actuated::EXPERIMENT.run(&args).expect("runs");
    assert!(outcome.completed(), "diverged: {:?}", outcome.diverged);
    let judged = outcome.rows.iter().filter(|r| r.pass.is_some());
    // The weights, and three rows of each case.
    assert_eq!(judged.count(), 12);
    let wrong = outcome.rows.iter().filter(|row| {
        let missed = |m: &(&str, &str, &str)| m.0 == row.id && m.1 == row.quantity;
        let expected = !MISSED.iter().any(missed);
        row.pass.is_some_and(|pass| pass != expected)
    });
    let wrong: Vec<String> = wrong.map(|row| format!("{row:?}")).collect();
    assert!(wrong.is_empty(), "not as promised:\n{}", wrong.join("\n"));
    // The approach is calm: the tip touches and stays.
    for row in outcome
        .rows
        .iter()
        .filter(|r| r.quantity.contains("times that contact"))
    {
        assert_eq!(row.measured, Some(1.0), "{row:?}");
    }
    for file in ["literal.mcap", "attitude_reference.mcap", "results.json"] {
        let path = out.0.join(under_actuated::EXPERIMENT.name).join(file);
        assert!(path.metadata().is_ok_and(|m| m.len() > 0), "{file}");
    }
}
