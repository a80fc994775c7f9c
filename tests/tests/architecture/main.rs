//! Arrows point down: what the modules of the framework and the crates use is what docs/architecture.md says.

mod links;

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
};

/// The repository.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The rows of a table of docs/architecture.md, by the header of its first column: what each may use.
fn table(header: &str) -> Vec<(String, BTreeSet<String>)> {
    let text = fs::read_to_string(root().join("docs/architecture.md")).expect("the page");
    let names = |cell: &str| -> BTreeSet<String> {
        let quoted = cell.split('`').skip(1).step_by(2);
        quoted.map(str::to_owned).collect()
    };
    let start = format!("| {header} |");
    let rows = text.lines().skip_while(|line| !line.starts_with(&start));
    let rows = rows.skip(2).take_while(|line| line.starts_with('|'));
    let row = |line: &str| {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let uses = names(cells[cells.len() - 2]);
        let rooms = names(cells[1]);
        rooms
            .into_iter()
            .map(move |room| (room, uses.clone()))
            .collect::<Vec<_>>()
    };
    let rows: Vec<_> = rows.flat_map(row).collect();
    assert!(
        !rows.is_empty(),
        "docs/architecture.md has no table `{header}`"
    );
    rows
}

/// An arrow that a line of code makes.
struct Arrow {
    from: String,
    to: String,
    place: String,
}

/// The parts of a source file that are compiled into the library, with their line numbers.
fn code(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let lines = text.lines().enumerate();
    let library = lines.take_while(|(_, line)| *line != "#[cfg(test)]");
    library.map(|(index, line)| (index + 1, line.split("//").next().unwrap_or_default()))
}

/// First names after `crate::` in a source file, `super::`s that reach the crate's root included.
fn names_from_root(text: &str, depth: usize) -> Vec<(usize, String)> {
    let up = "super::".repeat(depth);
    let mut found = Vec::new();
    // Braces open after `crate::`, and what was read of the name at their first level.
    let (mut open, mut name) = (0, String::new());
    for (line, text) in code(text) {
        let text = if depth > 0 {
            text.replace(&up, "crate::")
        } else {
            text.to_owned()
        };
        let mut rest = text.as_str();
        while !rest.is_empty() {
            if open > 0 {
                let end = rest.find(['{', '}', ',']).unwrap_or(rest.len());
                if open == 1 {
                    name.push_str(&rest[..end]);
                }
                let stop = rest[end..].chars().next();
                if open == 1 && stop.is_some() && !name.trim().is_empty() {
                    found.push((line, name.clone()));
                }
                match stop {
                    Some('{') => open += 1,
                    Some('}') => open -= 1,
                    _ => {}
                }
                if stop == Some(',') && open == 1 || open == 0 {
                    name.clear();
                } else if stop == Some('}') && open == 1 {
                    " ".clone_into(&mut name);
                }
                rest = &rest[(end + 1).min(rest.len())..];
            } else if let Some(at) = rest.find("crate::") {
                rest = &rest[at + "crate::".len()..];
                if let Some(list) = rest.strip_prefix('{') {
                    (open, rest) = (1, list);
                } else {
                    found.push((line, rest.to_owned()));
                }
            } else {
                break;
            }
        }
    }
    let first = |name: String| {
        let is_part = |c: char| c.is_alphanumeric() || c == '_';
        let name = name.trim_start();
        name[..name.find(|c| !is_part(c)).unwrap_or(name.len())].to_owned()
    };
    let named = found.into_iter().map(|(line, name)| (line, first(name)));
    named.filter(|(_, name)| !name.is_empty()).collect()
}

fn arrows(folder: &Path, source: &Path, out: &mut Vec<Arrow>) {
    for file in fs::read_dir(folder).expect("a folder of the framework") {
        let path = file.expect("readable").path();
        if path.is_dir() {
            arrows(&path, source, out);
            continue;
        }
        let inside = path.strip_prefix(source).expect("below it");
        let parts: Vec<_> = inside.iter().map(|part| part.to_string_lossy()).collect();
        let room = parts[0].trim_end_matches(".rs").to_owned();
        if room == "lib" {
            continue;
        }
        let text = fs::read_to_string(&path).expect("a source file");
        let is_mod = parts.last().is_some_and(|name| name == "mod.rs");
        let depth = parts.len() - usize::from(is_mod);
        let names = names_from_root(&text, depth);
        out.extend(names.into_iter().map(|(line, to)| Arrow {
            from: room.clone(),
            to,
            place: format!("framework/src/{}:{line}", inside.display()),
        }));
    }
}

#[test]
fn modules_of_the_framework_use_what_the_table_says() {
    let table = table("module");
    let order: BTreeMap<&str, usize> = table
        .iter()
        .enumerate()
        .map(|(i, (name, _))| (name.as_str(), i))
        .collect();
    let mut wrong = Vec::new();
    for (index, (name, uses)) in table.iter().enumerate() {
        for used in uses {
            if order.get(used.as_str()).is_none_or(|above| *above >= index) {
                wrong.push(format!(
                    "docs/architecture.md: `{name}` uses `{used}`, which is not above it"
                ));
            }
        }
    }
    let source = root().join("framework/src");
    let mut all = Vec::new();
    arrows(&source, &source, &mut all);
    assert!(
        all.len() > 250,
        "the lines that use others are not found: {}",
        all.len()
    );
    let mut seen: BTreeSet<(String, String)> = BTreeSet::new();
    for Arrow { from, to, place } in all {
        let Some((_, uses)) = table.iter().find(|(name, _)| *name == from) else {
            wrong.push(format!(
                "{place}: module `{from}` is not in docs/architecture.md"
            ));
            continue;
        };
        if to != from && !uses.contains(&to) {
            wrong.push(format!(
                "{place}: `{from}` uses `{to}`, which docs/architecture.md does not list"
            ));
        }
        seen.insert((from, to));
    }
    for (from, uses) in &table {
        for to in uses {
            if !seen.contains(&(from.clone(), to.clone())) {
                wrong.push(format!(
                    "docs/architecture.md: `{from}` does not use `{to}`"
                ));
            }
        }
    }
    wrong.sort();
    wrong.dedup();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn an_arrow_is_found_wherever_it_stands() {
    let text = "use crate::{\n    a::{B, c::D},\n    e,\n    f::G,\n};\n\
                fn x() { crate::h::i(); super::j::k() }\n// crate::no\n";
    let names: Vec<String> = names_from_root(text, 1)
        .into_iter()
        .map(|(_, name)| name)
        .collect();
    assert_eq!(names, ["a", "e", "f", "h", "j"]);
    let deep = names_from_root("use super::super::a::B;\nuse super::here;", 2);
    assert_eq!(deep, [(1, "a".to_owned())]);
}

#[test]
fn crates_depend_on_what_the_table_says() {
    let table = table("crate");
    let mut wrong = Vec::new();
    let members = fs::read_to_string(root().join("Cargo.toml")).expect("the workspace");
    let members: toml::Table = members.parse().expect("TOML");
    let members = members["workspace"]["members"]
        .as_array()
        .expect("members")
        .clone();
    let mut crates = BTreeMap::new();
    for member in &members {
        let folder = member.as_str().expect("a path");
        let manifest = root().join(folder).join("Cargo.toml");
        let manifest: toml::Table = fs::read_to_string(manifest)
            .expect("a manifest")
            .parse()
            .expect("TOML");
        let name = manifest["package"]["name"]
            .as_str()
            .expect("a name")
            .to_owned();
        let dependencies = manifest.get("dependencies").and_then(toml::Value::as_table);
        let dependencies = dependencies
            .into_iter()
            .flat_map(|table| table.keys().cloned());
        crates.insert(name, dependencies.collect::<BTreeSet<_>>());
    }
    let names: BTreeSet<String> = crates.keys().cloned().collect();
    for (name, dependencies) in &crates {
        let ours: BTreeSet<String> = dependencies.intersection(&names).cloned().collect();
        match table.iter().find(|(row, _)| row == name) {
            Some((_, uses)) if *uses == ours => {}
            Some((_, uses)) => wrong.push(format!(
                "{name} uses {ours:?}, docs/architecture.md says {uses:?}"
            )),
            None => wrong.push(format!(
                "{name} is not in docs/architecture.md; it uses {ours:?}"
            )),
        }
    }
    for (index, (name, uses)) in table.iter().enumerate() {
        let above: BTreeSet<_> = table[..index]
            .iter()
            .map(|(name, _)| name.clone())
            .collect();
        for used in uses.difference(&above) {
            wrong.push(format!(
                "docs/architecture.md: `{name}` uses `{used}`, which is not above it"
            ));
        }
        if !names.contains(name) {
            wrong.push(format!("docs/architecture.md: there is no crate `{name}`"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
