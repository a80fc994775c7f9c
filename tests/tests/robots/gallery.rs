//! The gallery: ten robots as their makers describe them stand, shift their weight, reach and fly as the page says.
//!
//! They are in the PyPI package that `oracles/robot_collection.py` reads; without it these tests say so and pass,
//! unless `WBQP_REQUIRE_ORACLES` is set, as it is in `.ci/run`.

use std::{collections::BTreeSet, fs};

use wbqp::controller::FallbackLevel;
use wbqp_robots as _;
use wbqp_tasks as _;
use wbqp_tests::{
    collection::collection,
    files::{lines_that_count, workspace},
    gallery::GALLERY,
    runs::run,
};

fn runs(name: &str) {
    let Some(collection) = collection() else {
        return;
    };
    let exhibit = GALLERY.iter().find(|exhibit| exhibit.name == name);
    let exhibit = exhibit.expect("is in the gallery");
    let scenario = exhibit.scenario(&collection);
    let outcome = run(&scenario.unwrap_or_else(|e| panic!("{e}")));
    println!(
        "{name}: {} ticks, errors {:?}, share {:?}, slip {:.1e} m",
        outcome.ticks, outcome.errors, outcome.share, outcome.slip
    );
    assert!(outcome.ticks >= 2000);
    assert_eq!(
        (outcome.not_optimal, outcome.worst),
        (0, FallbackLevel::Optimal)
    );
    for (task, most) in exhibit.errors {
        let error = outcome.error(task).expect("the task is there");
        assert!(error < *most, "{task}: {error}");
    }
    assert!(outcome.share.0 < exhibit.share, "{:?}", outcome.share);
    // What does nothing cannot be told from what needs nothing.
    assert!(outcome.share.0 > 0.1, "{:?}", outcome.share);
    assert_eq!(outcome.lifted, 0);
    assert!(outcome.slip < 2e-3, "{}", outcome.slip);
}

#[test]
fn solo12_shifts_its_weight() {
    runs("solo12");
}

#[test]
fn go2_shifts_its_weight() {
    runs("go2");
}

#[test]
fn anymal_c_shifts_its_weight() {
    runs("anymal_c");
}

#[test]
fn talos_reaches() {
    runs("talos");
}

#[test]
fn g1_reaches() {
    runs("g1");
}

#[test]
fn panda_draws_an_ellipse() {
    runs("panda");
}

#[test]
fn ur5_reaches() {
    runs("ur5");
}

#[test]
fn hextilt_draws_a_circle_and_stays_level() {
    runs("hextilt");
}

#[test]
fn borinot_flies_and_swings_its_arm() {
    runs("borinot");
}

#[test]
fn iris_flies_a_circle() {
    runs("iris");
}

#[test]
fn controllers_are_short() {
    for exhibit in &GALLERY {
        let text = fs::read_to_string(exhibit.controller_file()).expect("ships");
        let lines = lines_that_count(&text);
        assert!(lines <= exhibit.lines, "{} has {lines} lines", exhibit.name);
    }
}

#[test]
fn every_scenario_of_the_folder_is_run_and_has_its_picture() {
    let files = fs::read_dir(workspace("examples/robots")).expect("is there");
    let names = files.map(|file| file.expect("can be read").file_name().into_string());
    let names = names.map(|name| name.expect("is a name"));
    let scenarios: BTreeSet<String> = names
        .filter_map(|name| name.strip_suffix(".toml").map(str::to_owned))
        .filter(|name| !name.contains('.'))
        .collect();
    let known = GALLERY.iter().map(|exhibit| exhibit.name.to_owned());
    assert_eq!(scenarios, known.collect());
    let page = fs::read_to_string(workspace("docs/robots.md")).expect("is there");
    for exhibit in &GALLERY {
        let picture = format!("robots/{}.svg", exhibit.name);
        assert!(page.contains(&picture), "{picture} is not on the page");
        let size = fs::metadata(workspace("docs").join(&picture)).expect("is there");
        assert!(size.len() < 60_000, "{picture}: {} bytes", size.len());
    }
}
