//! An experiment as it ships against what is promised of it.

use std::{env, fs, path::PathBuf, process};

use wbqp_replication::{Common, experiment::Experiment, markdown};

const DOCUMENTED: &str = include_str!("../../docs/replication.md");

/// A directory that goes away with its owner.
struct Temporary(PathBuf);

impl Drop for Temporary {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Runs an experiment with seed 1. Its rows are as `promised_rows.toml` has them and as
/// `docs/replication.md` says, and logs of all cases, figures and
/// results are there.
///
/// # Panics
/// If not.
pub fn assert_as_promised(experiment: &Experiment) {
    let name = experiment.measures.name;
    let out = Temporary(env::temp_dir().join(format!("wbqp-{name}-{}", process::id())));
    let args = Common {
        out: out.0.clone(),
        seed: 1,
    };
    let outcome = experiment.run(&args).expect("runs");
    let diverged = outcome.runs.diverged();
    assert!(diverged.is_empty(), "diverged: {diverged:?}");
    let breaches: Vec<String> = outcome.breaches.iter().map(ToString::to_string).collect();
    assert!(breaches.is_empty(), "{}", breaches.join("\n"));
    let section = markdown::section(&outcome).expect("promises are good");
    assert!(
        DOCUMENTED.contains(&section),
        "docs/replication.md is not what is measured; `cargo run --release -- --docs` writes it anew:\n{section}"
    );
    let logs = outcome.runs.cases().map(|case| format!("{case}.mcap"));
    let figures = outcome.pictures.iter().map(|p| p.file.clone());
    for file in logs.chain(figures).chain(["results.json".to_owned()]) {
        let path = out.0.join(name).join(&file);
        assert!(path.metadata().is_ok_and(|m| m.len() > 0), "{file}");
    }
}
