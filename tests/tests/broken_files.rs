//! What is said of files with mistakes: each message must be understandable alone. The files are in `fixtures/broken`,
//! the messages in `tests/snapshots`; `INSTA_UPDATE=always cargo test --test broken_files` writes them anew.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

use wbqp::{ControllerConfig, controller::Controller};
use wbqp_robots as _;
use wbqp_sim::Scenario;
use wbqp_tasks as _;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn folder(kind: &str) -> PathBuf {
    root().join("fixtures/broken").join(kind)
}

/// Stems and texts of a folder's files, sorted.
fn files(kind: &str) -> Vec<(String, String)> {
    let entries = fs::read_dir(folder(kind)).expect("the folder is there");
    let mut files: Vec<_> = entries
        .map(|entry| {
            let path = entry.expect("can be listed").path();
            let stem = path.file_stem().expect("is a file").to_string_lossy();
            let text = fs::read_to_string(&path).expect("is text");
            (stem.into_owned(), text)
        })
        .collect();
    files.sort();
    files
}

/// Loads and binds a controller; what is said.
fn controller(name: &str, text: &str) -> Option<String> {
    match ControllerConfig::from_str(text, name, folder("controller")) {
        Err(errors) => Some(errors.to_string()),
        Ok(config) => Controller::new(config).err().map(|error| error.to_string()),
    }
}

fn scenario(name: &str, text: &str) -> Option<String> {
    let scenario = Scenario::from_text(text, name, &folder("scenario"));
    scenario.err().map(|error| error.to_string())
}

/// Compares what is said of every file with its snapshot; gives the number of files.
fn check(kind: &str, said: impl Fn(&str, &str) -> Option<String>) -> usize {
    let files = files(kind);
    let mut known = BTreeSet::new();
    for (stem, text) in &files {
        let name = format!("{stem}.toml");
        let message = said(&name, text).unwrap_or_else(|| panic!("{name} is accepted"));
        // Where the checkout is differs.
        let message = message.replace(&format!("{}/", root().display()), "");
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
    for entry in fs::read_dir(root().join("tests/snapshots")).expect("the folder is there") {
        let name = entry.expect("can be listed").file_name();
        let name = name.to_string_lossy();
        assert!(
            !name.starts_with(&format!("{kind}__")) || known.contains(&*name),
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
