//! Files on a disk: devices and pipes, closed pipes, two runs into one folder, logs that were cut.

use std::{
    fs,
    io::Read as _,
    process::{Command, Stdio},
    thread::sleep,
    time::Duration,
};

use wbqp_log::RunLock;
use wbqp_measures::Recording;

use crate::common::{Temporary, root, wbqp};

const STAND: &str = include_str!("../../../examples/scenarios/quadruped_short.controller.toml");

/// A folder with the file, and where a run is to write.
fn with_stand(name: &str) -> (Temporary, String, String) {
    let folder = Temporary::new(name);
    let (file, out) = (folder.file("stand.toml"), folder.file("out"));
    fs::write(&file, STAND).unwrap();
    (folder, file, out)
}

#[cfg(target_os = "linux")]
#[test]
fn devices_and_pipes_are_refused_in_words_whatever_reads_them() {
    let folder = Temporary::new("devices");
    let pipe = folder.file("a.pipe");
    let made = Command::new("mkfifo").arg(&pipe).status().unwrap();
    assert!(made.success());
    let file = folder.file("robot.toml");
    fs::write(
        &file,
        "[controller]\nrate = 100.0\n[robot]\nfile = \"/dev/zero\"\n",
    )
    .unwrap();
    for arguments in [
        vec!["check", "/dev/zero"],
        vec!["check", &pipe],
        vec!["run", "/dev/zero"],
        vec!["run", &pipe],
        vec!["replay", "/dev/zero"],
        vec!["log", "repair", "/dev/zero"],
        vec!["view", "/dev/zero"],
        vec!["view", &pipe],
        vec!["check", &file],
        vec!["check", &file, "--set", "robot.file='a.pipe'"],
        vec!["new", "--urdf", "/dev/zero", "--kind", "arm"],
    ] {
        let done = wbqp(&arguments);
        assert_eq!(done.code, 1, "{arguments:?}");
        let words = ["only regular files are read", "is a "];
        assert!(
            words.iter().all(|w| done.stderr.contains(w)),
            "{arguments:?}: {}",
            done.stderr
        );
    }
}

#[test]
fn a_reader_that_has_enough_ends_no_run() {
    let (folder, file, out) = with_stand("closed_pipe");
    for arguments in [
        vec!["run", &file, "--duration", "0.1", "--out", &out],
        vec!["check", &file],
        vec!["plugins"],
    ] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_wbqp"))
            .current_dir(root())
            .args(&arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        // As `| head` does in the end.
        drop(child.stdout.take());
        let mut said = String::new();
        child
            .stderr
            .take()
            .unwrap()
            .read_to_string(&mut said)
            .unwrap();
        let code = child.wait().unwrap().code();
        assert!(!said.contains("panicked"), "{arguments:?}: {said}");
        assert!(
            code == Some(0) || code == Some(141),
            "{arguments:?}: {code:?}"
        );
    }
    assert!(folder.0.join("out/stand/summary.json").is_file());
}

#[test]
fn a_second_run_into_the_same_log_is_told_of_the_first() {
    let (folder, file, out) = with_stand("two_runs");
    let log = folder.0.join("out/stand/default.mcap");
    let lock = RunLock::take(&log).unwrap();
    fs::write(&log, "of the other run").unwrap();
    let arguments = ["run", &file, "--duration", "0.1", "--out", &out];
    let done = wbqp(&arguments);
    assert_eq!(done.code, 1);
    let process = format!("process {}", std::process::id());
    for part in [
        "default.mcap: another run is writing it",
        &process,
        "since 20",
        "command ",
    ] {
        assert!(done.stderr.contains(part), "{}", done.stderr);
    }
    assert_eq!(fs::read_to_string(&log).unwrap(), "of the other run");
    drop(lock);
    assert_eq!(wbqp(&arguments).code, 0);
    let left: Vec<_> = fs::read_dir(folder.0.join("out/stand")).unwrap().collect();
    let name = |entry: &std::io::Result<fs::DirEntry>| {
        entry
            .as_ref()
            .unwrap()
            .file_name()
            .to_string_lossy()
            .into_owned()
    };
    assert!(left.iter().all(|entry| !name(entry).contains(".lock")));
}

#[test]
fn shards_share_a_folder_and_its_summary() {
    let folder = Temporary::new("shards");
    fs::write(folder.file("stand.controller.toml"), STAND).unwrap();
    let ground = "[[plant.wall]]\nname = \"ground\"\npoint = [0.0, 0.0, 0.0]\nnormal = [0.0, 0.0, 1.0]\n\
                  stiffness = 2e4\ndamping = 60.0\nfriction = 0.8\n";
    let feet = ["fl", "fr", "hl", "hr"];
    let points = feet.map(|foot| format!("[[plant.contact_point]]\nframe = \"{foot}_foot\"\n"));
    let cases = ["a", "b", "c"].map(|case| format!("[[case]]\nname = \"{case}\"\n"));
    let text = format!(
        "name = \"s\"\ncontroller = \"stand.controller.toml\"\nduration = 0.1\n{ground}{}{}",
        points.concat(),
        cases.concat()
    );
    let file = folder.file("s.toml");
    fs::write(&file, text).unwrap();
    let out = folder.file("out");
    let shard = |case: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_wbqp"));
        let arguments = ["run", &file, "--out", &out, "--case", case];
        command
            .args(arguments)
            .stdout(Stdio::null())
            .stderr(Stdio::null());
        command.spawn().unwrap()
    };
    let shards: Vec<_> = ["c", "a", "b"].into_iter().map(shard).collect();
    for mut shard in shards {
        assert!(shard.wait().unwrap().success());
    }
    let summary = fs::read_to_string(folder.0.join("out/s/summary.json")).unwrap();
    let summary: wbqp::serde_json::Value = wbqp::serde_json::from_str(&summary).unwrap();
    let names: Vec<&str> = summary
        .as_array()
        .unwrap()
        .iter()
        .map(|case| case["case"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["a", "b", "c"]);
}

/// What stands beside the log of a run that was killed is of no older run.
#[test]
fn a_run_that_is_killed_leaves_no_results_of_the_one_before() {
    let (folder, file, out) = with_stand("killed");
    let done = wbqp(&["run", &file, "--duration", "0.2", "--out", &out]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    let results = folder.0.join("out/stand");
    let figure = results.join("default.motion.svg");
    assert!(figure.exists());
    let arguments = ["run", &file, "--duration", "100000", "--out", &out];
    let mut child = Command::new(env!("CARGO_BIN_EXE_wbqp"))
        .args(arguments)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    while figure.exists() && child.try_wait().unwrap().is_none() {
        sleep(Duration::from_millis(2));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(!figure.exists());
    let summary = fs::read_to_string(results.join("summary.json")).unwrap();
    assert_eq!(summary.trim(), "[]");
}

#[test]
fn a_log_that_was_cut_is_repaired_beside_it() {
    let (folder, file, out) = with_stand("repair");
    let done = wbqp(&["run", &file, "--duration", "1.2", "--out", &out]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    let log = folder.0.join("out/stand/default.mcap");
    let whole = fs::read(&log).unwrap();
    let cut = folder.file("cut.mcap");
    fs::write(&cut, &whole[..whole.len() * 9 / 10]).unwrap();
    let done = wbqp(&["log", "repair", &cut]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    assert!(done.stdout.contains("are cut off"), "{}", done.stdout);
    let saved = wbqp_measures::log::Log::open(&folder.0.join("cut.repaired.mcap")).unwrap();
    assert!(saved.topics().count() > 3);
    // A second time there is a file in the way.
    assert_eq!(wbqp(&["log", "repair", &cut]).code, 1);
}

/// Every number of the file is that of the log, to the bit.
/// What is saved of it ends in the middle.
#[test]
fn a_log_that_a_run_is_writing_is_saved_with_a_warning() {
    let (folder, file, out) = with_stand("repair_running");
    let done = wbqp(&["run", &file, "--duration", "0.1", "--out", &out]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    let log = folder.file("out/stand/default.mcap");
    let lock = RunLock::take(folder.0.join("out/stand/default.mcap").as_path()).unwrap();
    let process = format!("a run is writing it, process {}", std::process::id());
    let arguments = ["log", "repair", &log, "--output", &folder.file("a.mcap")];
    let done = wbqp(&arguments);
    assert!(done.stderr.contains(&process), "{}", done.stderr);
    drop(lock);
    let arguments = ["log", "repair", &log, "--output", &folder.file("b.mcap")];
    let done = wbqp(&arguments);
    assert_eq!((done.code, done.stderr.as_str()), (0, ""));
    assert!(
        done.stdout.contains("up to 0.1 s") || done.stdout.contains("up to 0.09"),
        "{}",
        done.stdout
    );
}

/// A limit of the shell on the size of files stands for a disk without room.
#[cfg(target_os = "linux")]
#[test]
fn what_a_full_disk_does_not_take_is_named_and_leaves_nothing_half() {
    let (folder, file, out) = with_stand("full");
    let program = env!("CARGO_BIN_EXE_wbqp");
    let limited = |blocks: u32, arguments: &str| {
        let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec '{program}' {arguments}");
        let done = Command::new("bash").args(["-c", &script]).output().unwrap();
        assert_eq!(done.status.code(), Some(1), "{arguments}");
        String::from_utf8(done.stderr).unwrap()
    };
    let log = limited(4, &format!("run '{file}' --duration 5 --out '{out}'"));
    assert!(
        log.contains("default.mcap: cannot be written: File too large"),
        "{log}"
    );
    let model = folder.file("model.xml");
    let export = limited(1, &format!("export-mjcf '{file}' --out '{model}'"));
    assert!(
        export.contains("model.xml: cannot be written: File too large"),
        "{export}"
    );
    let problems = folder.file("problems.json");
    let dump = limited(
        1,
        &format!("tick-stats --robot quadruped --dump-problems '{problems}'"),
    );
    assert!(
        dump.contains("problems.json: cannot be written: File too large"),
        "{dump}"
    );
    let left: Vec<_> = fs::read_dir(&folder.0).unwrap().flatten().collect();
    let left = |end: &str| {
        left.iter()
            .any(|e| e.file_name().to_string_lossy().ends_with(end))
    };
    assert!(!left(".part") && !left("model.xml") && !left("problems.json"));
}

#[test]
fn the_json_of_a_file_that_cannot_be_looked_into_has_errors() {
    let folder = Temporary::new("json_errors");
    let (foreign, bytes, large) = (
        folder.file("foreign.toml"),
        folder.file("bytes.toml"),
        folder.file("large.toml"),
    );
    fs::write(&foreign, "[package]\nname = \"a\"\n").unwrap();
    fs::write(&bytes, b"[robot]\nname = \"\xff\"\n").unwrap();
    let zeros = fs::File::create(&large).unwrap();
    zeros.set_len((16 << 20) + 1).unwrap();
    for (file, words) in [
        (foreign.as_str(), "is neither a URDF"),
        (&bytes, "line 2 is not UTF-8"),
        (&large, "is larger than 16 MiB"),
        (&folder.file("nowhere.toml"), "cannot be read"),
        (&folder.0.display().to_string(), "is a folder"),
    ] {
        let done = wbqp(&["check", file, "--json"]);
        assert_eq!(done.code, 1, "{file}");
        let json = done.json();
        assert_eq!(json["file"], file);
        assert!(json["kind"].is_null());
        let error = json["errors"][0].as_str().unwrap();
        assert!(error.contains(words), "{error}");
        assert!(done.stderr.contains(words), "{}", done.stderr);
    }
}

/// A robot, a controller and a scenario name one another in text.
#[cfg(target_os = "linux")]
#[test]
fn a_path_that_is_not_utf_8_is_named_with_what_to_do() {
    use std::os::unix::ffi::OsStrExt as _;
    let folder = Temporary::new("bytes_in_path");
    let file = folder.0.join(std::ffi::OsStr::from_bytes(b"st\xffnd.toml"));
    fs::write(&file, STAND).unwrap();
    let done = Command::new(env!("CARGO_BIN_EXE_wbqp"))
        .arg("run")
        .arg(&file)
        .output()
        .unwrap();
    assert_eq!(done.status.code(), Some(1));
    let error = String::from_utf8(done.stderr).unwrap();
    assert!(
        error.contains("nd.toml: the path is not UTF-8") && error.contains("rename the file"),
        "{error}"
    );
}

#[test]
fn names_of_files_and_entries_do_not_steer_the_terminal() {
    let folder = Temporary::new("escapes");
    let file = folder.file("a\u{1b}[2J.toml");
    fs::write(&file, STAND).unwrap();
    let done = wbqp(&["check", &file]);
    assert!(
        done.stdout.contains("a\\u{1b}[2J.toml: needs"),
        "{}",
        done.stdout
    );
    let named = STAND.replacen("[[task]]", "[[task]]\nname = \"a\\u001b[2J\"", 1);
    fs::write(&file, named).unwrap();
    let refused = wbqp(&["check", &file]);
    assert_eq!(refused.code, 1);
    assert!(
        refused.stderr.contains("has control characters"),
        "{}",
        refused.stderr
    );
    for text in [&done.stdout, &done.stderr, &refused.stdout, &refused.stderr] {
        assert!(!text.contains('\u{1b}'), "{text:?}");
    }
}

#[test]
fn a_log_is_written_as_csv() {
    let (folder, file, out) = with_stand("csv");
    let done = wbqp(&["run", &file, "--duration", "0.1", "--out", &out]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    let path = folder.0.join("out/stand/default.mcap");
    let log = path.display().to_string();
    let done = wbqp(&["log", "csv", &log]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    let tables = path.with_extension("");
    let names = |table: &str| {
        let mut table = csv::Reader::from_path(tables.join(table)).unwrap();
        let header = table.headers().unwrap().clone();
        let rows: Vec<_> = table.records().map(Result::unwrap).collect();
        (header, rows)
    };
    let (header, rows) = names("plant.csv");
    assert_eq!(&header[0], "t");
    let at = header
        .iter()
        .position(|name| name == "base/position/z")
        .unwrap();
    let log_file = wbqp_measures::log::Log::open(&path).unwrap();
    let height = log_file
        .columns("/plant", &["/base/position/z".to_owned()])
        .unwrap();
    assert_eq!(rows.len(), height[0].len());
    for (row, (t, z)) in rows.iter().zip(height[0].samples()) {
        let number = |k: usize| row[k].parse::<f64>().unwrap();
        assert_eq!((number(0), number(at)), (t, z));
    }
    let (header, rows) = names("qp.csv");
    let level = header.iter().position(|name| name == "level").unwrap();
    assert!(rows.iter().all(|row| &row[level] == "optimal"));
    // Files that are there stay, all of them.
    fs::remove_file(tables.join("plant.csv")).unwrap();
    let again = wbqp(&["log", "csv", &log]);
    assert_eq!(again.code, 1);
    assert!(again.stderr.contains("--force"), "{}", again.stderr);
    assert!(!tables.join("plant.csv").exists());
    assert_eq!(wbqp(&["log", "csv", &log, "--force"]).code, 0);
    assert!(tables.join("plant.csv").exists());
    // What is a text alone is no table; a topic that is not there is refused with those that are.
    assert!(!tables.join("robot_description.csv").exists());
    let done = wbqp(&["log", "csv", &log, "--topic", "/contact/nobody"]);
    assert_eq!(done.code, 1);
    assert!(
        done.stderr.contains("/contact/nobody") && done.stderr.contains("/plant"),
        "{}",
        done.stderr
    );
}

#[test]
fn a_damaged_log_is_told_of_and_saved_but_for_what_is_damaged() {
    let (folder, file, out) = with_stand("damaged");
    let done = wbqp(&["run", &file, "--duration", "1.2", "--out", &out]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    let mut bytes = fs::read(folder.0.join("out/stand/default.mcap")).unwrap();
    let middle = bytes.len() / 3;
    bytes[middle] ^= 4;
    let damaged = folder.file("damaged.mcap");
    fs::write(&damaged, bytes).unwrap();
    let done = wbqp(&["log", "repair", &damaged]);
    assert_eq!(done.code, 1, "{}", done.stdout);
    for words in ["damaged at byte ", "this chunk", " messages lost"] {
        assert!(done.stdout.contains(words), "{}", done.stdout);
    }
    let saved = wbqp_measures::log::Log::open(&folder.0.join("damaged.repaired.mcap")).unwrap();
    assert!(saved.topics().count() > 3);
    let refused = wbqp_measures::log::Log::open(damaged.as_ref()).unwrap_err();
    assert!(refused.to_string().contains("wbqp log repair"), "{refused}");
}

#[test]
fn a_contact_on_a_frame_that_touches_nothing_is_said() {
    let folder = Temporary::new("wrong_frame");
    let file = folder.file("stand.toml");
    fs::write(&file, STAND.replace("\"hr_foot\"", "\"hr_thigh\"")).unwrap();
    let done = wbqp(&["check", &file]);
    assert!(
        done.stdout.contains("contact `hr_thigh` is 0."),
        "{}",
        done.stdout
    );
    assert!(
        done.stdout.contains("is its frame the right one?"),
        "{}",
        done.stdout
    );
    fs::write(&file, STAND).unwrap();
    let done = wbqp(&["check", &file]);
    assert!(!done.stdout.contains("its surface"), "{}", done.stdout);
}

#[test]
fn an_option_beside_its_table_is_told_where_it_belongs() {
    let folder = Temporary::new("option");
    let file = folder.file("robot.toml");
    fs::write(
        &file,
        "[controller]\nrate = 100.0\n[robot]\nfile = \"r.urdf\"\neffort = { a = 1 }\n",
    )
    .unwrap();
    let done = wbqp(&["check", &file]);
    assert!(
        done.stderr
            .contains("unknown key `effort`; it belongs into `options`: `options.effort = …`"),
        "{}",
        done.stderr
    );
}
