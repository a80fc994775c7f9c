//! What cases and variations change of a scenario, and how what they get wrong is refused.

use wbqp::{controller::Controller, toml};
use wbqp_log::MemoryLog;
use wbqp_robots as _;
use wbqp_sim::{Scenario, Variation};
use wbqp_tasks as _;
use wbqp_tests::{runs::logged, said::scenario};

const TEXT: &str = r#"name = "variants"
controller = "push_with_disturbance.controller.toml"
duration = 1.0
initial.position = [-0.5, 0.0, 1.258]

[[plant.wall]]
name = "wall"
point = [0.0, 0.0, 0.0]
normal = [-1.0, 0.0, 0.0]
cases = ["plain", "other"]

[[plant.contact_point]]
frame = "tool"

[[plant.disturbance]]
name = "gust"
frame = "base_link"
force = [-3.5, 0.0, 0.0]
from = 0.2
until = 0.4

[[sensors.force_torque]]
frame = "tool"

[[detector]]
contact = "tip"
cases = ["plain"]

[[event]]
at = 0.1
mark = "go"
follow.base_position = { type = "min_jerk", to = [-0.4, 0.0, 1.258], duration = 0.5 }

[[event]]
at = 0.5
mark = "late"
cases = ["other"]
deactivate = ["posture"]

[[case]]
name = "plain"

[[case]]
name = "other"
change.duration = 2.0
change.initial.joints.arm_pitch1 = 0.2
change.plant.mismatch = { mass_scale = 1.05, thrust_scale = 0.95 }
change.plant.wall.wall.friction = 0.3
change.plant.disturbance.gust.force = [0.0, 1.0, 0.0]
change.sensors.base.position_sd = 0.001
change.sensors.force_torque.tool.cutoff = 30.0
change.event.go.at = 0.3
change.event.go.follow.base_position.duration = 1.0

[[case]]
name = "calm"
change.plant.disturbance = []
change.event.go.follow.base_position = { type = "hold" }
"#;

fn good() -> Scenario {
    scenario(TEXT).expect("is good")
}

#[test]
fn each_case_has_its_own() {
    let scenario = good();
    let [plain, other, calm] =
        ["plain", "other", "calm"].map(|name| scenario.case(name).expect("exists"));
    assert_eq!(
        [plain, other, calm].map(wbqp_sim::scenario::Case::duration),
        [1.0, 2.0, 1.0]
    );
    assert!(plain.initial().joints.is_empty());
    assert_eq!(other.initial().joints["arm_pitch1"], 0.2);
    assert_eq!(other.initial().position, Some([-0.5, 0.0, 1.258]));
    assert_eq!(plain.plant().mismatch.mass_scale, 1.0);
    assert_eq!(other.plant().mismatch.mass_scale, 1.05);
    assert_eq!(other.plant().mismatch.thrust_scale, 0.95);
    assert_eq!(plain.plant().walls[0].friction, 0.5);
    assert_eq!(other.plant().walls[0].friction, 0.3);
    assert_eq!(other.plant().walls[0].normal, [-1.0, 0.0, 0.0]);
    assert!(calm.plant().walls.is_empty());
    assert_eq!(plain.plant().disturbances[0].force, [-3.5, 0.0, 0.0]);
    assert_eq!(other.plant().disturbances[0].force, [0.0, 1.0, 0.0]);
    assert!(calm.plant().disturbances.is_empty());
    assert_eq!(other.sensors().base.position_sd, 0.001);
    assert_eq!(plain.sensors().force_torque[0].cutoff, 15.0);
    assert_eq!(other.sensors().force_torque[0].cutoff, 30.0);
    let detectors = [plain, other, calm].map(|case| case.detectors().len());
    assert_eq!(detectors, [1, 0, 0]);
    let events = [plain, other, calm].map(|case| case.events().len());
    assert_eq!(events, [1, 2, 1]);
    assert_eq!([plain.events()[0].at, other.events()[0].at], [0.1, 0.3]);
    let follow = |case: &wbqp_sim::scenario::Case| case.events()[0].follow["base_position"].clone();
    assert_eq!(follow(plain)["duration"], toml::Value::Float(0.5));
    assert_eq!(follow(other)["duration"], toml::Value::Float(1.0));
    assert_eq!(
        follow(other)["type"],
        toml::Value::String("min_jerk".into())
    );
    assert_eq!(follow(calm).as_table().expect("is a table").len(), 1);
}

#[test]
fn a_run_is_its_cases() {
    let scenario = good();
    let (short, plain) = logged(&scenario, "plain");
    let (long, other) = logged(&scenario, "other");
    assert_eq!((short.ticks, long.ticks), (250, 500));
    let timeline = |log: &MemoryLog| log.metadata["timeline"].clone();
    assert_eq!(timeline(&plain)["gust_start"], "0.2");
    assert!(!timeline(&plain).contains_key("late"));
    assert!(timeline(&other).contains_key("late"));
    assert_eq!(plain.metadata["scenario"]["case"], "plain");
    assert_eq!(plain.metadata["scenario"]["name"], "variants");
}

/// Asserts what is said of a file in which a piece is replaced.
fn refused(piece: &str, other: &str, expected: &str) {
    assert!(TEXT.contains(piece), "{piece}");
    match scenario(&TEXT.replacen(piece, other, 1)) {
        Ok(_) => panic!("accepted: {other}"),
        Err(message) => assert_eq!(message, expected),
    }
}

#[test]
fn changes_of_what_is_not_there() {
    let change = "change.initial.joints.arm_pitch1 = 0.2";
    let line = 46;
    let wrong = |other: &str, column: usize, expected: &str| {
        refused(
            change,
            other,
            &format!("s.toml:{line}:{column}: {expected}"),
        );
    };
    wrong(
        "change.durration = 2.0",
        8,
        "unknown key `durration`; did you mean `duration`? (known: case, controller, detector, duration, event, \
         initial, name, plant, sensors)",
    );
    wrong(
        "change.plant.mismach.mass_scale = 2.0",
        14,
        "unknown key `mismach`; did you mean `mismatch`? (known: command_delay, contact_point, disturbance, \
         friction_speed, mismatch, servo, step, tolerance, wall)",
    );
    wrong(
        "change.plant.wall.wal.friction = 0.3",
        19,
        "[[plant.wall]] with name `wal` is not there; did you mean `wall`? (known: wall)",
    );
    wrong(
        "change.plant.wall.wall.frction = 0.3",
        24,
        "unknown key `frction`; did you mean `friction`? (known: damping, friction, name, normal, point, stiffness, \
         tangential_damping, tangential_stiffness, viscous)",
    );
    wrong(
        "change.detector.tip.on = 2.0",
        17,
        "[[detector]] with contact `tip` is not there (known: none)",
    );
    wrong(
        "change.event.gone.at = 2.0",
        14,
        "[[event]] with mark `gone` is not there; did you mean `go`? (known: go, late)",
    );
    wrong("change.name = 'x'", 8, "`name` is the same in every case");
    wrong(
        "change.plant.wall.wall.stiffness = 'x'",
        36,
        "case[1].change.plant.wall.wall.stiffness: invalid type: string \"x\", expected a number",
    );
    let plain = "name = \"plain\"";
    refused(
        plain,
        &format!("{plain}\nchange = 3"),
        "s.toml:42:10: `change` must be a table, found integer",
    );
    refused(
        plain,
        &format!("{plain}\nchange.plant.wall.wall = 0.3"),
        "s.toml:42:26: must be a table of values, found float",
    );
    refused(
        "change.plant.wall.wall.friction = 0.3",
        "change.plant.wall.wall.friction = -0.3",
        "s.toml:48:35: plant.wall[0] `wall`: friction: is -0.3, must be finite and not negative\n\
         in case `other` of s.toml",
    );
}

#[test]
fn cases_of_an_entry() {
    let cases = "cases = [\"other\"]";
    refused(
        cases,
        "cases = [\"othr\"]",
        "s.toml:37:10: there is no case `othr`; did you mean `other`? (known: plain, other, calm)",
    );
    refused(
        cases,
        "cases = []",
        "s.toml:37:9: `cases` is empty: this would be in no case",
    );
    refused(
        cases,
        "cases = \"other\"",
        "s.toml:37:9: `cases` must be a list of cases' names, found string",
    );
    refused(
        "duration = 1.0",
        "duration = 1.0\ncases = [\"other\"]",
        "s.toml:4:1: unknown key `cases`; did you mean `case`? (known: case, controller, detector, duration, event, \
         initial, name, plant, sensors)",
    );
}

#[test]
fn events_that_would_never_happen() {
    refused(
        "at = 0.5",
        "at = 3.0",
        "s.toml:34:1: event `late` at 3 s: would never happen: the last tick is at 1.996 s\n\
         in case `other` of s.toml",
    );
    refused(
        "at = 0.1",
        "at = 1.0",
        "s.toml:29:1: event `go` at 1 s: would never happen: the last tick is at 0.996 s",
    );
    scenario(&TEXT.replacen("at = 0.1", "at = 0.996", 1)).expect("the last tick is in the run");
    refused(
        "mark = \"late\"",
        "mark = \"go\"",
        "s.toml:52:14: [[event]] with mark `go` is there twice",
    );
}

#[test]
fn a_variation_is_on_top_of_every_case() {
    let variation = Variation::new()
        .change("plant.mismatch.mass_scale", 1.02)
        .change("plant.wall.wall.friction", 0.4)
        .change("event.late.at", 0.6)
        .set("robot.thrust_max", 9.5)
        .set("task.base_orientation.kp", 60.0);
    let same = Variation::from_toml(
        "change.plant.mismatch.mass_scale = 1.02\n\
         change.plant.wall.wall.friction = 0.4\n\
         change.event.late.at = 0.6\n\
         set.robot.thrust_max = 9.5\n\
         set.task.base_orientation.kp = 60.0",
    );
    assert_eq!(same.expect("is TOML"), variation);

    // In two steps it is the same.
    let scenario = good()
        .varied(&Variation::new().change("plant.mismatch.mass_scale", 1.03))
        .and_then(|once| once.varied(&variation))
        .expect("is good");
    for case in ["plain", "other", "calm"] {
        let config = scenario.controller_config(case).expect("is good");
        let saved = config.to_toml().expect("can be saved");
        assert!(saved.contains("kp = 60.0") && saved.contains("thrust_max = 9.5"));
        let case = scenario.case(case).expect("exists");
        assert_eq!(case.plant().mismatch.mass_scale, 1.02);
        // A wall or an event that a case does not have is left alone.
        assert!(case.plant().walls.iter().all(|w| w.friction == 0.4));
        let controller = Controller::new(config).expect("fits");
        let rotors = controller.robot().rotors();
        assert!(rotors.into_iter().all(|(_, a, _)| a.upper == 9.5));
    }
    assert_eq!(scenario.case("other").expect("exists").events()[1].at, 0.6);
    // What the case itself changes stays.
    let other = scenario.case("other").expect("exists");
    assert_eq!(other.plant().mismatch.thrust_scale, 0.95);

    let (_, log) = logged(&scenario, "plain");
    let kept = std::str::from_utf8(&log.attachments["variation.toml"].1).expect("is text");
    assert_eq!(
        &Variation::from_toml(kept).expect("is TOML"),
        scenario.variation()
    );
    assert_eq!(log.metadata["rotors"]["rotor_1.max"], "9.5");
}

#[test]
fn variations_that_are_refused() {
    let wrong = |variation: Variation, expected: &str| {
        let message = good().varied(&variation).expect_err("is wrong").to_string();
        assert_eq!(message, expected);
    };
    wrong(
        Variation::new().change("plant.mismatch.mass", 1.1),
        "s.toml: variation `plant.mismatch.mass = 1.1`: unknown key `mass`; did you mean `mass_scale`? (known: \
         com_shift, inertia_scale, mass_scale, rotor_lag_scale, rotor_scales, thrust_max, thrust_scale)",
    );
    wrong(
        Variation::new().change("plant.wall.door.friction", 0.4),
        "s.toml: variation `plant.wall.door.friction = 0.4`: [[plant.wall]] with name `door` is not there \
         (known: wall)",
    );
    wrong(
        Variation::new().change("duration", "long"),
        "s.toml: variation `duration = \"long\"`: invalid type: string \"long\", expected a number",
    );
    wrong(
        Variation::new().change("plant.wall.wall.friction", -0.4),
        "s.toml: variation `plant.wall.wall.friction = -0.4`: plant.wall[0] `wall`: friction: is -0.4, must be finite \
         and not negative",
    );
    let message = Variation::from_toml("chnge.duration = 1").expect_err("is wrong");
    assert_eq!(
        message.to_string(),
        "variation.toml:1:1: unknown key `chnge`; did you mean `change`? (known: change, set)"
    );
}

/// What a command line gives is told as its option, not as the case's that is checked first.
#[test]
fn values_of_an_option_are_told_as_the_option() {
    let controller = wbqp_tests::files::scenarios().join("push_with_disturbance.controller.toml");
    let controller = controller.display();
    let refused = |variation: Variation, expected: &str| {
        let error = good().varied(&variation.given_by("--set"));
        assert_eq!(error.expect_err("is refused").to_string(), expected);
    };
    refused(
        Variation::new().change("duration", f64::NAN),
        "--set change.duration=nan: duration: is NaN s, must be positive and finite",
    );
    refused(
        Variation::new().change("plant.step", "small"),
        "--set change.plant.step=\"small\": invalid type: string \"small\", expected a number",
    );
    refused(
        Variation::new().set("task.contact_force.feedback", "of"),
        &format!(
            "{controller}: override task `contact_force`.`feedback`: unknown value `of`, expected `off` or `pi`\n\
             given by `--set task.contact_force.feedback=\"of\"`"
        ),
    );
    // What only the robot shows, in a value of a name that is quoted.
    let list = toml::Value::Array(vec![1.into(), 2.into()]);
    refused(
        Variation::new().set("task.contact_force.weight", list),
        &format!(
            "{controller}: override task `contact_force`.`weight`: has 2 entries, expected one number, or 3: one per \
             row\ngiven by `--set task.contact_force.weight=[1, 2]`"
        ),
    );
    refused(
        Variation::new().set("task.'left arm'.kp", 1),
        &format!(
            "{controller}: override task `left arm`.`kp`: no task has this name (known: base_position, \
             base_orientation, posture, contact_force, propeller_regularisation)\n\
             given by `--set task.\"left arm\".kp=1`"
        ),
    );
}
