//! Rust: every page with a block is compiled with the documentation tests.

use std::{collections::BTreeSet, fs};

use wbqp_tests::files::workspace;

use crate::pages::{blocks, name, pages};

/// Crates whose documentation tests have pages.
const CRATES: [&str; 3] = [
    "tests/src/book.rs",
    "examples/src/lib.rs",
    "examples/custom_task/src/lib.rs",
];

#[test]
fn every_page_with_rust_is_compiled() {
    let compiled: String = CRATES
        .map(|file| fs::read_to_string(workspace(file)).expect("is there"))
        .concat();
    let with_rust: BTreeSet<String> = blocks("rust")
        .iter()
        .filter_map(|block| Some(block.place.rsplit_once(':')?.0.to_owned()))
        .collect();
    for page in &with_rust {
        assert!(
            compiled.contains(&format!("/{page}\"")),
            "{page} is in no documentation test"
        );
    }
    let known = pages();
    for line in compiled
        .lines()
        .filter_map(|line| line.split("include_str!(\"").nth(1))
    {
        let page = line
            .trim_start_matches("../")
            .split('"')
            .next()
            .unwrap_or_default();
        assert!(
            known.iter().any(|known| name(known) == page),
            "{page} is no page"
        );
    }
}

#[test]
fn no_block_is_ignored() {
    for block in blocks("rust") {
        assert!(!block.is("ignore"), "{}: nobody compiles it", block.place);
    }
}
