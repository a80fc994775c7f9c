//! An experiment as it ships against what is promised of it.

use wbqp_replication::{Common, experiment::Experiment, markdown};

use crate::files::Temporary;

const DOCUMENTED: &str = include_str!("../../docs/replication.md");

/// Runs an experiment with seed 1. Its rows are as `promised_rows.toml` has them and as
/// `docs/replication.md` says, and logs of all cases, figures and
/// results are there.
///
/// # Panics
/// If not.
pub fn assert_as_promised(experiment: &Experiment) {
    let name = experiment.measures.name;
    let out = Temporary::new(name);
    let args = Common {
        out: out.path().to_owned(),
        seed: 1,
        live: None,
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
        let path = out.file(name).join(&file);
        assert!(path.metadata().is_ok_and(|m| m.len() > 0), "{file}");
    }
}
