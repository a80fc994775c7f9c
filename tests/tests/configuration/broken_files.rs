//! What is said of files with mistakes: each message must be understandable alone. The files are in `fixtures/broken`,
//! the messages in `snapshots`; `INSTA_UPDATE=always cargo test -p wbqp-tests --test configuration broken_files` writes
//! them anew.

use std::collections::BTreeSet;

use wbqp_robots as _;
use wbqp_sim::Scenario;
use wbqp_tasks as _;
use wbqp_tests::{
    files::{texts, workspace},
    said,
};

/// Of the repository, with the files of a kind.
fn folder(kind: &str) -> String {
    format!("tests/fixtures/broken/{kind}")
}

/// Loads and binds a controller; what is said.
fn controller(name: &str, text: &str) -> Option<String> {
    said::of_controller(text, name, &workspace(&folder("controller")))
}

fn scenario(name: &str, text: &str) -> Option<String> {
    let scenario = Scenario::from_text(text, name, &workspace(&folder("scenario")));
    scenario.err().map(|error| error.to_string())
}

/// Compares what is said of every file with its snapshot; gives the number of files.
fn check(kind: &str, said: impl Fn(&str, &str) -> Option<String>) -> usize {
    let files = texts(&folder(kind), ".toml");
    let here = workspace("tests/").display().to_string();
    let mut known = BTreeSet::new();
    for (name, text) in &files {
        let stem = name.trim_end_matches(".toml");
        let message = said(name, text).unwrap_or_else(|| panic!("{name} is accepted"));
        // Where the checkout is differs.
        let message = message.replace(&here, "");
        let snapshot = format!("{kind}__{stem}");
        insta::with_settings!({
            omit_expression => true,
            prepend_module_to_snapshot => false,
            description => text.as_str(),
        }, {
            insta::assert_snapshot!(snapshot.as_str(), message);
        });
        known.insert(format!("{snapshot}.snap"));
    }
    for (name, _) in texts("tests/tests/configuration/snapshots", ".snap") {
        assert!(
            !name.starts_with(&format!("{kind}__")) || known.contains(&name),
            "{name} is of a file that is gone"
        );
    }
    files.len()
}

#[test]
fn controllers() {
    assert!(check("controller", controller) >= 30);
}

#[test]
fn scenarios() {
    assert!(check("scenario", scenario) >= 10);
}
