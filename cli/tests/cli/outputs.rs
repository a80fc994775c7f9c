//! What is read is not written over, and nothing is written outside the folder that was named.

use std::fs;

use crate::common::{Temporary, fixture, root, wbqp};

const SCENARIO: &str = "examples/scenarios/quadruped_stand.toml";

#[test]
fn a_scenario_that_would_write_outside_its_folder_is_refused() {
    let folder = Temporary::new("escape");
    let controller = root().join("examples/scenarios/quadruped_stand.controller.toml");
    let text = fs::read_to_string(root().join(SCENARIO)).unwrap();
    let text = text.replace(
        "quadruped_stand.controller.toml",
        controller.to_str().unwrap(),
    );
    let line = 1 + text.lines().position(|l| l.starts_with("name = ")).unwrap();
    let (file, out) = (folder.file("s.toml"), folder.file("out"));
    for name in ["../escape", "/escape", "..", ".", "", "a/b", "a b", ".a"] {
        let named = text.replacen("name = \"quadruped_stand\"", &format!("name = {name:?}"), 1);
        fs::write(&file, named).unwrap();
        let done = wbqp(&["run", &file, "--out", &out]);
        assert_eq!(done.code, 1, "{name}");
        let place = format!("s.toml:{line}:8: name `{name}`");
        assert!(done.stderr.contains(&place), "{name}: {}", done.stderr);
        assert!(!folder.0.join("out").exists(), "{name}");
    }
}

#[test]
fn a_new_controller_is_not_written_over_what_it_is_made_from() {
    let folder = Temporary::new("new_over");
    let urdf = fs::read_to_string(fixture("quadrotor.urdf")).unwrap();
    let file = folder.file("quad.urdf");
    fs::write(&file, &urdf).unwrap();
    let beside = folder.0.join("quad.rotors.toml");
    let kind = ["--kind", "multirotor", "--force"];
    let other = format!("{}/./quad.urdf", folder.0.display());
    for output in [&file, &other] {
        let done = wbqp(&[&["new", "--urdf", &file, "--output", output], &kind[..]].concat());
        assert_eq!(done.code, 1);
        assert!(
            done.stderr.contains("is read by this command"),
            "{}",
            done.stderr
        );
        assert_eq!(fs::read_to_string(&file).unwrap(), urdf);
        assert!(!beside.exists());
    }
    // Neither over the rotors that are read.
    let output = folder.file("quad.toml");
    let new = ["new", "--urdf", &file, "--output", &output];
    // Rotors are assumed, which is status 1.
    assert_eq!(wbqp(&[&new, &kind[..]].concat()).code, 1);
    let rotors = fs::read_to_string(&beside).unwrap();
    let rotor_file = beside.display().to_string();
    let new = ["new", "--urdf", &file, "--output", &rotor_file];
    let done = wbqp(&[&new[..], &["--rotors", &rotor_file], &kind[..]].concat());
    assert_eq!(done.code, 1, "{}", done.stdout);
    assert_eq!(fs::read_to_string(&beside).unwrap(), rotors);
}

#[test]
fn a_model_is_written_over_nothing_that_it_is_made_from() {
    let folder = Temporary::new("mjcf_over");
    let stand =
        fs::read_to_string(root().join("examples/scenarios/quadruped_short.controller.toml"));
    let stand = stand.unwrap();
    let (file, model) = (folder.file("stand.toml"), folder.file("stand.xml"));
    fs::write(&file, &stand).unwrap();
    let export = ["export-mjcf", &file, "--out"];
    assert_eq!(wbqp(&[&export[..], &[&model]].concat()).code, 0);
    let done = wbqp(&[&export[..], &[&model]].concat());
    assert_eq!(done.code, 1);
    assert!(done.stderr.contains("--force"), "{}", done.stderr);
    assert_eq!(wbqp(&[&export[..], &[&model, "--force"]].concat()).code, 0);
    let done = wbqp(&[&export[..], &[&file, "--force"]].concat());
    assert_eq!(done.code, 1);
    assert!(done.stderr.contains("is read"), "{}", done.stderr);
    assert_eq!(fs::read_to_string(&file).unwrap(), stand);
}
