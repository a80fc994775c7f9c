//! The runs of the tutorials end as the pages say.

use std::{fs, process::ExitCode};

use serde_json::Value;
use wbqp_cli::command_line::CommandLine;
use wbqp_tests::{
    collection::collection,
    files::{Temporary, workspace},
};

/// Runs `wbqp run` with a file of the repository; the cases of its summary.
fn run(file: &str, options: &[&str]) -> Result<Vec<Value>, String> {
    let folder = Temporary::new("tutorial");
    let (path, out) = (
        workspace(file).display().to_string(),
        folder.path().display().to_string(),
    );
    let line = ["wbqp", "run", &path, "--out", &out];
    let command = CommandLine::from_words(line.iter().chain(options)).map_err(|e| e.to_string())?;
    let code = command.run().map_err(|e| format!("{e:#}"))?;
    assert_eq!(code, ExitCode::SUCCESS, "{file}");
    let scenario = workspace(file);
    let name = scenario.file_stem().expect("has a name").to_string_lossy();
    let text =
        fs::read_to_string(folder.path().join(&*name).join("summary.json")).expect("a summary");
    let summary: Value = serde_json::from_str(&text).expect("is JSON");
    Ok(summary.as_array().expect("is a list of cases").clone())
}

/// A number of a list's item with this name.
fn number(case: &Value, list: &str, name: &str, key: &str) -> f64 {
    let items = case[list].as_array().expect("is a list");
    let item = items.iter().find(|item| item["name"] == name);
    let item = item.unwrap_or_else(|| panic!("{list} has no {name}: {case}"));
    item[key]
        .as_f64()
        .unwrap_or_else(|| panic!("{list} {name} has no {key}: {case}"))
}

#[test]
fn a_push_on_a_wall() {
    const FILE: &str = "examples/scenarios/push_with_disturbance.toml";
    let cases = run(FILE, &["--case", "with_ft"]).expect("runs");
    assert_eq!(cases[0]["worst_level"], "optimal");
    assert!(number(&cases[0], "tasks", "contact_force", "end") < 0.1);

    let set = |force: f64| {
        format!("task.contact_force.reference={{ type = \"hold\", value = [{force:?}] }}")
    };
    let cases = run(FILE, &["--case", "with_ft", "--set", &set(7.0)]).expect("runs");
    assert!(number(&cases[0], "tasks", "contact_force", "end") < 0.1);
    assert!(
        number(&cases[0], "tasks", "base_position", "peak") > 0.3,
        "gives way while it is pulled"
    );

    let refused = run(FILE, &["--case", "with_ft", "--set", &set(8.0)]).expect_err("is too much");
    assert!(refused.contains("8.0 N asked, 7.9 N possible"), "{refused}");
}

#[test]
fn a_quadruped_that_lifts_a_foot() {
    let cases = run("examples/tutorials/quadruped_lift.toml", &[]).expect("runs");
    let [lift, no_lean] = &cases[..] else {
        panic!("{cases:?}")
    };
    assert_eq!(lift["not_optimal"], 0);
    assert!(number(lift, "tasks", "com", "peak") < 0.005);
    // Without leaning first it falls.
    assert!(no_lean["not_optimal"].as_f64() > Some(100.0), "{no_lean}");
}

#[test]
fn hextilt_presses_on_a_table() {
    let Some(robots) = collection() else { return };
    let urdf = robots
        .iter()
        .find(|robot| robot.file.ends_with("hextilt_flying_arm_5.urdf"));
    let urdf = urdf
        .expect("is in the collection")
        .path
        .display()
        .to_string();
    let cases = run("examples/tutorials/hextilt_push.toml", &["--urdf", &urdf]).expect("runs");
    for case in &cases {
        assert_eq!(case["worst_level"], "optimal", "{case}");
        assert!(
            number(case, "tasks", "tip_contact_force", "end") < 0.2,
            "{case}"
        );
    }
}
