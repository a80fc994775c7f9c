//! `wbqp view`: what it refuses, and the address that it prints.

use std::{
    fs,
    io::{BufRead as _, BufReader},
    process::{Command, Stdio},
};

use wbqp_cli::view::page_is_built;

use crate::common::{Temporary, root, wbqp};

#[test]
fn what_is_no_log_is_refused_in_words() {
    let folder = Temporary::new("view_refused");
    let text = folder.file("text.mcap");
    fs::write(&text, "no log").unwrap();
    let empty = folder.file("empty.mcap");
    fs::write(&empty, "").unwrap();
    for (file, words) in [
        (folder.file("missing.mcap"), "os error 2"),
        (text, "is no MCAP file"),
        (empty, "is no MCAP file"),
        (folder.0.display().to_string(), "is a folder"),
    ] {
        let done = wbqp(&["view", &file, "--no-browser"]);
        assert_eq!(done.code, 1, "{file}");
        let all = [file.as_str(), "cannot be read", words];
        assert!(
            all.iter().all(|w| done.stderr.contains(w)),
            "{}",
            done.stderr
        );
        assert_eq!(done.stdout, "");
    }
}

#[test]
fn a_command_line_that_is_not_understood_is_another_status() {
    for arguments in [&["view"][..], &["view", "a.mcap", "--port", "70000"]] {
        assert_eq!(wbqp(arguments).code, 2, "{arguments:?}");
    }
}

#[test]
fn the_address_is_printed_or_how_to_build_the_page() {
    let folder = Temporary::new("view_address");
    let file = folder.file("a log.mcap");
    fs::write(&file, b"\x89MCAP0\r\n").unwrap();
    if !page_is_built() {
        let done = wbqp(&["view", &file, "--no-browser"]);
        assert_eq!(done.code, 1);
        assert!(done.stderr.contains("web/build.sh"), "{}", done.stderr);
        return;
    }
    let mut served = Command::new(env!("CARGO_BIN_EXE_wbqp"))
        .current_dir(root())
        .args(["view", &file, "--no-browser"])
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut line = String::new();
    let printed = BufReader::new(served.stdout.take().unwrap()).read_line(&mut line);
    served.kill().unwrap();
    served.wait().unwrap();
    printed.unwrap();
    assert!(
        line.starts_with("http://127.0.0.1:") && line.ends_with("/?log=log%2Fa%2520log%252Emcap\n"),
        "{line}"
    );
}
