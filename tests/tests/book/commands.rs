//! Shell: `wbqp …` is a command line that is understood, `cargo … --bin …` names a program, files of the repository are
//! there.

use std::{collections::BTreeSet, fs, path::Path};

use wbqp_cli::command_line::CommandLine;
use wbqp_tests::files::workspace;

use crate::pages::{Block, blocks};

/// Folders of the repository that commands name files of.
const FOLDERS: [&str; 8] = [
    "examples/",
    "python/",
    "tests/",
    "web/",
    "docs/",
    ".ci/",
    "cli/",
    "simulation/",
];

#[test]
fn commands_are_understood() {
    let programs = programs();
    let mut understood = 0;
    for block in blocks("sh") {
        for command in commands(&block.text) {
            understood += usize::from(check(&block, &command, &programs));
        }
    }
    assert!(understood > 60, "only {understood} commands");
}

/// Whether it was one that can be checked.
fn check(block: &Block, words: &[String], programs: &BTreeSet<String>) -> bool {
    let place = &block.place;
    files_are_there(place, words);
    let mut arguments: Vec<&str> = words.iter().map(String::as_str).collect();
    // Variables of one command.
    while arguments
        .first()
        .is_some_and(|word| word.contains('=') && !word.starts_with('-'))
    {
        arguments.remove(0);
    }
    match arguments.first() {
        Some(&"wbqp") => understand(place, &arguments[1..]),
        Some(&"cargo") => cargo(place, &arguments[1..], programs),
        _ => return false,
    }
    true
}

fn understand(place: &str, arguments: &[&str]) {
    // Help is an error of the parser, as it ends the program.
    if arguments.first() == Some(&"help") {
        return;
    }
    let line = ["wbqp"].iter().chain(arguments);
    if let Err(why) = CommandLine::from_words(line) {
        panic!("{place}: wbqp {}: {why}", arguments.join(" "));
    }
}

fn cargo(place: &str, arguments: &[&str], programs: &BTreeSet<String>) {
    let mut words = arguments.iter();
    let bin = words
        .by_ref()
        .find(|word| **word == "--bin")
        .and_then(|_| words.next());
    let Some(bin) = bin else { return };
    assert!(
        programs.contains(*bin),
        "{place}: there is no program `{bin}`"
    );
    if *bin == "wbqp" && arguments.contains(&"--") {
        let after: Vec<&str> = arguments
            .iter()
            .skip_while(|word| **word != "--")
            .skip(1)
            .copied()
            .collect();
        understand(place, &after);
    }
}

fn files_are_there(place: &str, words: &[String]) {
    for word in words {
        let path = word.trim_start_matches("../").trim_start_matches("./");
        let is_plain = !path.contains(['*', '$', '[', '<', '…', '(']);
        // What builds make.
        let is_made =
            path.contains("/dist") || path.contains("node_modules") || path.contains("/pkg");
        if is_plain && !is_made && FOLDERS.iter().any(|folder| path.starts_with(folder)) {
            assert!(workspace(path).exists(), "{place}: there is no {path}");
        }
    }
}

/// Names of the workspace's programs.
fn programs() -> BTreeSet<String> {
    let mut names = BTreeSet::from(["wbqp".to_owned(), "wbqp_peer".into(), "wbqp_qp".into()]);
    let listed = workspace("Cargo.toml");
    let manifest: toml::Table = fs::read_to_string(listed)
        .expect("is there")
        .parse()
        .expect("is TOML");
    let members = manifest["workspace"]["members"]
        .as_array()
        .expect("is a list");
    for member in members {
        let folder = workspace(member.as_str().expect("is a text")).join("src/bin");
        names.extend(stems(&folder));
    }
    names
}

fn stems(folder: &Path) -> Vec<String> {
    let files = fs::read_dir(folder).into_iter().flatten().flatten();
    let stems =
        files.filter_map(|file| Some(file.path().file_stem()?.to_string_lossy().into_owned()));
    stems.collect()
}

/// The commands of a text, word by word.
fn commands(text: &str) -> Vec<Vec<String>> {
    let text = text.replace("\\\n", " ");
    let commands = text.lines().flat_map(split);
    commands.filter(|words| !words.is_empty()).collect()
}

/// Splits a line into commands at `&&`, `;` and `|`, and these into words, as a shell does; redirections and subshells
/// are left as they are.
fn split(line: &str) -> Vec<Vec<String>> {
    let (mut commands, mut words) = (Vec::new(), Vec::new());
    let mut word = String::new();
    let mut quote = None;
    for c in line.chars() {
        match (quote, c) {
            (Some(q), c) if c == q => quote = None,
            (None, '\'' | '"') => quote = Some(c),
            (None, '#') if word.is_empty() => break,
            (None, c) if c.is_whitespace() || matches!(c, '&' | ';' | '|') => {
                if !word.is_empty() {
                    words.push(std::mem::take(&mut word));
                }
                if !c.is_whitespace() {
                    commands.push(std::mem::take(&mut words));
                }
            }
            (_, c) => word.push(c),
        }
    }
    if !word.is_empty() {
        words.push(word);
    }
    commands.push(words);
    commands
}

#[test]
fn a_line_is_split_as_a_shell_does() {
    let words = commands("a --set 'x=[1, 2]' \\\n  b # said\nc && d|e\n");
    let expected: [&[&str]; 4] = [&["a", "--set", "x=[1, 2]", "b"], &["c"], &["d"], &["e"]];
    assert_eq!(words, expected);
}

#[test]
fn what_is_not_understood_is_found() {
    assert!(CommandLine::from_words(["wbqp", "run", "a.toml"]).is_ok());
    assert!(CommandLine::from_words(["wbqp", "run", "a.toml", "--sed", "1"]).is_err());
}
