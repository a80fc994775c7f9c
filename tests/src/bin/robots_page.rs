//! Writes the tables of `docs/robots.md` anew. `tests/oracles/robot_collection.py` finds the robots.

use std::{fs, process::ExitCode};

use wbqp_robots as _;
use wbqp_tasks as _;
use wbqp_tests::{
    collection::collection,
    files::workspace,
    robots_page::{Table, collection_table, gallery_table},
};

fn main() -> ExitCode {
    let Some(collection) = collection() else {
        return ExitCode::FAILURE;
    };
    let path = workspace("docs/robots.md");
    let Ok(page) = fs::read_to_string(&path) else {
        eprintln!("error: {}: cannot be read", path.display());
        return ExitCode::FAILURE;
    };
    let page = Table::Collection
        .put(&page, &collection_table(&collection))
        .and_then(|page| Table::Gallery.put(&page, &gallery_table(&collection)));
    match page.map(|page| fs::write(&path, page)) {
        Some(Ok(())) => ExitCode::SUCCESS,
        Some(Err(error)) => {
            eprintln!("error: {}: {error}", path.display());
            ExitCode::FAILURE
        }
        None => {
            eprintln!("error: {}: the tables' marks are not there", path.display());
            ExitCode::FAILURE
        }
    }
}
