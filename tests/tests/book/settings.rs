//! TOML: a whole file is loaded, a part of one is parsed and has no table that files do not have.

use std::fs;

use toml::{Table, Value};
use wbqp::ControllerConfig;
use wbqp_campaign::Plan;
use wbqp_sim::Scenario;
use wbqp_tests::{
    collection::collection,
    files::{Temporary, workspace},
};

use crate::pages::{Block, blocks, with_the_next};

/// Tables that files of some kind have.
const TABLES: [&str; 19] = [
    // Controllers.
    "controller",
    "robot",
    "solver",
    "measurement",
    "fallback",
    "contact",
    "task",
    "constraint",
    // Scenarios.
    "initial",
    "plant",
    "sensors",
    "detector",
    "event",
    "case",
    // Rotor parameter files.
    "defaults",
    "rotor",
    // Taplo's, Cargo's, and patches.
    "rule",
    "profile",
    "dependencies",
];

/// Pages that others write, whose parts of files are not marked.
const UNMARKED: [&str; 2] = ["docs/campaigns.md", "docs/robustness.md"];

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Controller,
    Scenario,
    Plan,
    Rotors,
    Part,
}

fn kind(block: &Block, table: &Table) -> Kind {
    if block.is("fragment") {
        Kind::Part
    } else if table.contains_key("rotor") {
        Kind::Rotors
    } else if table.get("controller").is_some_and(Value::is_str) {
        Kind::Scenario
    } else if table.contains_key("scenario") {
        Kind::Plan
    } else if table.contains_key("controller") && table.contains_key("robot") {
        Kind::Controller
    } else {
        Kind::Part
    }
}

#[test]
fn settings_are_loaded() {
    let mut loaded = 0;
    for block in blocks("toml") {
        let place = &block.place;
        // A first line for an editor is a comment.
        let table: Table = block
            .text
            .parse()
            .unwrap_or_else(|e| panic!("{place}: {e}"));
        let kind = kind(&block, &table);
        match kind {
            Kind::Controller => controller(&block, table),
            Kind::Scenario => scenario(&block, table),
            Kind::Rotors => rotors(&block),
            Kind::Plan => plan(&block),
            Kind::Part => part(&block, &table),
        }
        loaded += usize::from(kind != Kind::Part);
    }
    assert!(loaded >= 6, "only {loaded} whole files");
}

/// A part of a file is marked, so that a whole one with a misspelt table is not taken for it.
fn part(block: &Block, table: &Table) {
    let is_excepted = UNMARKED.iter().any(|page| block.place.starts_with(page));
    assert!(
        block.is("fragment") || is_excepted || table.is_empty(),
        "{}: neither a whole file nor marked: ```toml,fragment",
        block.place
    );
    for (key, value) in table {
        let is_table = value.is_table()
            || value
                .as_array()
                .is_some_and(|a| a.iter().all(Value::is_table));
        assert!(
            !is_table || TABLES.contains(&key.as_str()),
            "{}: no file has a table `{key}`",
            block.place
        );
    }
}

#[test]
fn what_is_refused_is_refused_in_the_words_of_the_page() {
    for [file, words] in with_the_next("refused") {
        let name = words.text.split(':').next().unwrap_or_default();
        let error =
            ControllerConfig::from_str(&file.text, name, &file.folder).expect_err("refused");
        assert_eq!(error.to_string(), words.text.trim_end(), "{}", words.place);
    }
}

/// Loaded, and made where its robot is here.
fn controller(block: &Block, mut table: Table) {
    let place = &block.place;
    let refusal = block.is("refused");
    let robot = table
        .get_mut("robot")
        .and_then(Value::as_table_mut)
        .expect("has a robot");
    let file = robot.get("file").and_then(Value::as_str).map(str::to_owned);
    if let Some(file) = file {
        let Some(path) = robot_file(&file) else {
            return;
        };
        robot.insert("file".into(), path.into());
        if let Some(rotors) = robot.get("rotors").and_then(Value::as_str) {
            let name = rotors.rsplit('/').next().unwrap_or(rotors);
            let path = workspace("examples/robots").join(name);
            robot.insert("rotors".into(), path.display().to_string().into());
        }
    }
    let text = toml::to_string(&table).expect("is TOML");
    let made = ControllerConfig::from_str(&text, place, &block.folder)
        .map_err(|e| e.to_string())
        .and_then(|config| config.build().map_err(|e| e.to_string()));
    match made {
        Ok(_) => assert!(!refusal, "{place}: is not refused"),
        Err(why) => assert!(refusal, "{place}: {why}"),
    }
}

/// The file of a robot of the collection, if it is on this machine.
fn robot_file(file: &str) -> Option<String> {
    let found = collection()?
        .into_iter()
        .find(|robot| robot.file.ends_with(&format!("/{file}")));
    let robot = found.unwrap_or_else(|| panic!("no robot has a file `{file}`"));
    Some(robot.path.display().to_string())
}

/// As if it stood among the plans that ship.
fn plan(block: &Block) {
    let plan = Plan::from_text(&block.text, &block.place, &workspace("examples/campaigns"));
    plan.unwrap_or_else(|e| panic!("{}: {e}", block.place));
}

fn scenario(block: &Block, mut table: Table) {
    let place = &block.place;
    let folder = Temporary::new("book");
    let named = table["controller"].as_str().expect("is a text");
    let controller = block.folder.join(named);
    assert!(controller.is_file(), "{place}: there is no {named}");
    table.insert("controller".into(), controller.display().to_string().into());
    let path = folder.file("scenario.toml");
    fs::write(&path, toml::to_string(&table).expect("is TOML")).expect("can be written");
    Scenario::from_file(&path).unwrap_or_else(|e| panic!("{place}: {e}"));
}

/// With the robot whose rotors they are.
fn rotors(block: &Block) {
    let place = &block.place;
    let Some(urdf) = robot_file("hextilt_flying_arm_5.urdf") else {
        return;
    };
    let folder = Temporary::new("book");
    let path = folder.file("a.rotors.toml");
    fs::write(&path, &block.text).expect("can be written");
    let options = wbqp_robots::Options::default();
    let robot = wbqp_robots::from_files(urdf.as_ref(), Some(&path), &options);
    let robot = robot.unwrap_or_else(|e| panic!("{place}: {e}"));
    assert!(robot.rotors().count() > 0, "{place}: no rotors");
}
