//! Links between the documents: the file is there, and so is the heading.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

/// Lines outside of code blocks.
fn prose(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut is_code = false;
    (1..).zip(text.lines()).filter(move |(_, line)| {
        let fence = line.trim_start().starts_with("```");
        is_code ^= fence;
        !fence && !is_code
    })
}

/// The anchors that headings get: lower case, blanks as hyphens, other punctuation left out; a number for one that is
/// there already.
fn anchors(text: &str) -> BTreeSet<String> {
    let mut anchors = BTreeSet::new();
    for (_, line) in prose(text) {
        let title = line.trim_start_matches('#');
        if title.len() == line.len() || !title.starts_with(' ') {
            continue;
        }
        let is_kept = |c: &char| c.is_alphanumeric() || "-_ ".contains(*c);
        let slug: String = title.trim().chars().filter(is_kept).collect();
        let slug = slug.to_lowercase().replace(' ', "-");
        let again = (1..).map(|n| format!("{slug}-{n}"));
        let mut names = std::iter::once(slug.clone()).chain(again);
        let free = names.find(|name| !anchors.contains(name));
        anchors.extend(free);
    }
    anchors
}

/// The targets of a line's links, `](target)`.
fn targets(line: &str) -> impl Iterator<Item = &str> {
    let parts = line.split("](").skip(1);
    parts.filter_map(|rest| Some(rest.split_once(')')?.0))
}

fn dead_links(document: &Path) -> Vec<String> {
    let text = fs::read_to_string(document).expect("readable");
    let folder = document.parent().expect("a folder");
    let mut dead = Vec::new();
    for (line, words) in prose(&text) {
        for target in targets(words) {
            if target.contains("://") || target.starts_with("mailto:") {
                continue;
            }
            let (file, anchor) = target.split_once('#').unwrap_or((target, ""));
            let file = match file {
                "" => document.to_owned(),
                file => folder.join(file),
            };
            let is_there = file.exists()
                && (anchor.is_empty()
                    || fs::read_to_string(&file).is_ok_and(|text| anchors(&text).contains(anchor)));
            if !is_there {
                dead.push(format!("{}:{line}: `{target}`", document.display()));
            }
        }
    }
    dead
}

/// The pages of a folder and those below it, but for what mdBook makes.
fn add_pages(folder: &Path, documents: &mut Vec<PathBuf>) {
    for file in fs::read_dir(folder).expect("a folder") {
        let path = file.expect("readable").path();
        let is_made = path.ends_with("docs/book") || path.ends_with("docs/files");
        if path.is_dir() && !is_made {
            add_pages(&path, documents);
        } else if path.extension().is_some_and(|e| e == "md") {
            documents.push(path);
        }
    }
}

#[test]
fn links_of_the_documents_lead_somewhere() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .expect("the workspace");
    let at_the_root = [
        "README.md",
        "CHANGELOG.md",
        "CONTRIBUTING.md",
        "SECURITY.md",
    ];
    let mut documents: Vec<PathBuf> = at_the_root.iter().map(|name| root.join(name)).collect();
    add_pages(&root.join("docs"), &mut documents);
    let dead: Vec<String> = documents.iter().flat_map(|d| dead_links(d)).collect();
    assert!(dead.is_empty(), "{}", dead.join("\n"));
}

#[test]
fn headings_become_anchors() {
    let text = "# One `[two]`: three\n```\n# none\n```\n## Again\n## Again\n#tag\n";
    let expected = ["again", "again-1", "one-two-three"];
    assert_eq!(anchors(text), expected.map(str::to_owned).into());
    let found: Vec<&str> = targets("[a](b.md#c) and [d](#e)").collect();
    assert_eq!(found, ["b.md#c", "#e"]);
}
