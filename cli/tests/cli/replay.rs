//! `wbqp replay`: a dump at another desk.

use std::fs;

use crate::common::{Temporary, root, wbqp};

/// A controller of a robot in a file whose `com` is nowhere near its reference: every tick is safe, and dumped.
fn dump(folder: &Temporary) -> String {
    let robot = root().join("robots/files/quadruped/quadruped.urdf");
    let desk = folder.0.join("desk");
    fs::create_dir_all(&desk).unwrap();
    fs::copy(robot, desk.join("quadruped.urdf")).unwrap();
    let urdf = desk.join("quadruped.urdf").display().to_string();
    let file = desk.join("stand.toml").display().to_string();
    let new = [
        "new",
        "--urdf",
        &urdf,
        "--kind",
        "quadruped",
        "--output",
        &file,
    ];
    assert_eq!(wbqp(&new).code, 0);
    let out = folder.file("out");
    // Motors that are too weak for the ground to be reached gently: the level changes in the run.
    let run = ["run", &file, "--duration", "0.4", "--out", &out];
    wbqp(
        &[
            &run[..],
            &[
                "--set",
                "change.plant.contact_point=[]",
                "--set",
                "change.plant.mismatch.mass_scale=0.2",
            ],
        ]
        .concat(),
    );
    let dump = folder.0.join("out/stand/default.1.tick.toml");
    assert!(dump.is_file());
    dump.display().to_string()
}

#[test]
fn a_dump_has_the_files_of_its_robot() {
    let folder = Temporary::new("desk");
    let dump = dump(&folder);
    let done = wbqp(&["replay", &dump]);
    assert_eq!(
        (done.code, done.stderr.as_str()),
        (0, ""),
        "{}",
        done.stdout
    );
    let here = folder.0.join("desk/quadruped.urdf");
    let urdf = fs::read_to_string(&here).unwrap();
    fs::write(&here, urdf.replacen("<robot", "<!-- --><robot", 1)).unwrap();
    let done = wbqp(&["replay", &dump]);
    assert_eq!(done.code, 1);
    for words in [
        "default.1.tick.toml",
        "--directory",
        "is not the one in the dump",
    ] {
        assert!(done.stderr.contains(words), "{}", done.stderr);
    }
    fs::remove_file(&here).unwrap();
    let done = wbqp(&["replay", &dump]);
    assert_eq!(done.code, 0, "{}{}", done.stdout, done.stderr);
    assert!(
        done.stderr.contains("quadruped.urdf: is not here"),
        "{}",
        done.stderr
    );
    assert_eq!(done.stderr.lines().count(), 1);
    // In whatever folder it is looked for.
    let elsewhere = folder.file("elsewhere");
    let done = wbqp(&["replay", &dump, "--directory", &elsewhere]);
    assert_eq!(done.code, 0, "{}{}", done.stdout, done.stderr);
}

#[test]
fn what_is_no_dump_or_no_tick_of_it_is_told_in_a_line() {
    let scenario = "examples/scenarios/quadruped_stand.toml";
    let done = wbqp(&["replay", scenario]);
    assert_eq!(done.code, 1);
    let start = format!("error: {scenario}: is not a dump of ticks: line ");
    assert!(done.stderr.starts_with(&start), "{}", done.stderr);
    assert!(done.stderr.contains("unknown key"), "{}", done.stderr);
    assert_eq!(done.stderr.lines().count(), 1, "{}", done.stderr);

    let folder = Temporary::new("ticks");
    let dump = dump(&folder);
    for tick in ["0", "99"] {
        let done = wbqp(&["replay", &dump, "--tick", tick]);
        assert_eq!(done.code, 1);
        let words = format!("error: --tick: there is no tick {tick}, {dump} has 1 to ");
        assert!(done.stderr.starts_with(&words), "{}", done.stderr);
    }
}
