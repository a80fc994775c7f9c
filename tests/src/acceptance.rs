//! An experiment as it ships against its table.

use std::{env, fs, path::PathBuf, process};

use wbqp_examples::{cli::Common, experiment::Experiment};

/// A row that is missed: id, quantity and reason. It must be missed: one that is met leaves the list.
pub type Missed = (&'static str, &'static str, &'static str);

/// A directory that goes away with its owner.
struct Temporary(PathBuf);

impl Drop for Temporary {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Runs an experiment with seed 1. Every judged row is met but those listed, at least `judged` of them, and logs of
/// these cases, figures and results are there.
///
/// # Panics
/// If not.
pub fn assert_every_row(experiment: &Experiment, missed: &[Missed], judged: usize, cases: &[&str]) {
    let name = experiment.name;
    let out = Temporary(env::temp_dir().join(format!("wbqp-{name}-{}", process::id())));
    let args = Common {
        out: out.0.clone(),
        seed: 1,
        scenario: None,
    };
    let outcome = experiment.run(&args).expect("runs");
    assert!(outcome.completed(), "diverged: {:?}", outcome.diverged);
    let judged_rows = outcome.rows.iter().filter(|r| r.pass.is_some());
    assert!(judged_rows.count() >= judged, "too few rows are judged");
    let wrong = outcome.rows.iter().filter(|row| {
        let is_missed = |m: &Missed| m.0 == row.id && m.1 == row.quantity;
        let expected = !missed.iter().any(is_missed);
        row.pass.is_some_and(|pass| pass != expected)
    });
    let wrong: Vec<String> = wrong.map(|row| format!("{row:?}")).collect();
    assert!(wrong.is_empty(), "not as promised:\n{}", wrong.join("\n"));
    let logs = cases.iter().map(|case| format!("{case}.mcap"));
    let figures = outcome.pictures.iter().map(|p| p.file.clone());
    for file in logs.chain(figures).chain(["results.json".to_owned()]) {
        let path = out.0.join(name).join(&file);
        assert!(path.metadata().is_ok_and(|m| m.len() > 0), "{file}");
    }
}
