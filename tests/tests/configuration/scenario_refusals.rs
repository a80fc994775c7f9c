//! Every way in which a scenario's file can be wrong, by its message; and that no text makes loading panic.

use std::path::Path;

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use wbqp::toml;
use wbqp_robots as _;
use wbqp_sim::{Scenario, Variation};
use wbqp_tasks as _;
use wbqp_tests::{files::scenarios, said::scenario};

/// A scenario that is accepted.
const GOOD: &str = r#"name = "push"
controller = "push_with_disturbance.controller.toml"
duration = 2.0

[initial]
position = [-0.5, 0.0, 1.258]
rpy = [0.0, 0.0, 0.0]

[initial.joints]
arm_pitch1 = 0.3

[plant]
step = 0.00025

[[plant.wall]]
name = "wall"
point = [0.0, 0.0, 0.0]
normal = [-1.0, 0.0, 0.0]

[[plant.contact_point]]
frame = "tool"

[[plant.disturbance]]
frame = "base_link"
force = [-3.5, 0.0, 0.0]
from = 1.0
until = 2.0

[sensors.base]
position_sd = 0.0005

[[sensors.force_torque]]
frame = "tool"
force_sd = 0.05

[[detector]]
contact = "tip"
on = 1.0

[[event]]
at = 1.0
follow.base_position = { type = "min_jerk", to = [-0.1, 0.0, 1.258], duration = 6.0 }
weight.contact_force = [1e-3, 1e-3, 3.0]

[[case]]
name = "one"

[[case]]
name = "two"
set.task.contact_force.feedback = "off"
"#;

/// The good scenario with the first occurrence of a piece replaced.
fn replaced(piece: &str, other: &str) -> String {
    assert!(GOOD.contains(piece), "{piece}");
    GOOD.replacen(piece, other, 1)
}

/// Asserts what is said of it, in full. `{controller}` is the controller's file.
fn refused(piece: &str, other: &str, expected: &str) {
    let controller = scenarios().join("push_with_disturbance.controller.toml");
    let expected = expected.replace("{controller}", &controller.display().to_string());
    match scenario(&replaced(piece, other)) {
        Ok(_) => panic!("accepted: {other}"),
        Err(message) => assert_eq!(message, expected),
    }
}

#[test]
fn a_good_one_is_accepted() {
    let good = scenario(GOOD).expect("is good");
    assert_eq!(good.name(), "push");
    assert_eq!(good.case("one").expect("exists").duration(), 2.0);
    assert_eq!(good.cases().collect::<Vec<_>>(), ["one", "two"]);
    scenario(&replaced("duration = 2.0", "duration = 2")).expect("an integer is a number");
}

#[test]
fn file_that_is_not_there() {
    let error = Scenario::from_file(Path::new("none/s.toml")).expect_err("is not there");
    assert!(
        error
            .to_string()
            .starts_with("none/s.toml: cannot be read: ")
    );
}

#[test]
fn unknown_keys() {
    let unknown = |piece: &str, other: &str, place: &str, known: &str| {
        let key = other.split([' ', '.']).next().unwrap_or_default();
        let meant = piece.split([' ', '.']).next().unwrap_or_default();
        let expected = format!(
            "s.toml:{place}: unknown key `{key}`; did you mean `{meant}`? (known: {known})"
        );
        refused(piece, other, &expected);
    };
    let top = "case, controller, detector, duration, event, initial, name, plant, sensors";
    unknown("duration", "druation", "3:1", top);
    unknown("rpy", "rpx", "7:1", "joints, position, rpy");
    let plant = "command_delay, contact_point, disturbance, friction_speed, mismatch, servo, step, tolerance, wall";
    unknown("step =", "stop =", "13:1", plant);
    let base = "angular_sd, linear_sd, position_sd, rotation_sd, velocity_cutoff";
    unknown("position_sd", "position_sf", "30:1", base);
    let force = "cutoff, force_bias, force_sd, frame, moment_bias, moment_sd";
    unknown("force_sd", "force_df", "34:1", force);
    let detector = "contact, dwell, off, on";
    unknown(
        "on = 1.0\n\n[[event",
        "onn = 1.0\n\n[[event",
        "38:1",
        detector,
    );
    let event = "activate, activate_contact, at, deactivate, deactivate_contact, follow, mark, tare, weight";
    unknown("weight.contact", "weigth.contact", "43:1", event);
    unknown("set.task", "sett.task", "50:1", "change, name, set");
    refused(
        "set.task",
        "set.tusk",
        "s.toml:50:5: unknown key `tusk`; did you mean `task`? (known: constraint, contact, controller, fallback, \
         measurement, robot, solver, task)",
    );
}

/// One mistake hides none of the others, but for what its own table lacks: it may have been meant.
#[test]
fn several_mistakes_are_told_at_once() {
    let plant = "command_delay, contact_point, disturbance, friction_speed, mismatch, servo, step, tolerance, wall";
    let event = "activate, activate_contact, at, deactivate, deactivate_contact, follow, mark, tare, weight";
    let expected = format!(
        "s.toml:3:12: duration: invalid type: string \"long\", expected a number\n\
         s.toml:13:1: unknown key `stepp`; did you mean `step`? (known: {plant})\n\
         s.toml:14:1: unknown key `delay`; did you mean `command_delay`? (known: {plant})\n\
         s.toml:44:1: unknown key `weigth`; did you mean `weight`? (known: {event})"
    );
    let wrong = GOOD
        .replacen("duration = 2.0", "duration = \"long\"", 1)
        .replacen("step = 0.00025", "stepp = 0.00025\ndelay = 1", 1)
        .replacen("weight.contact", "weigth.contact", 1);
    assert_eq!(scenario(&wrong).err(), Some(expected));
    let lacking = GOOD
        .replacen("duration = 2.0", "duration = \"long\"", 1)
        .replacen("frame = \"base_link\"\n", "", 1)
        .replacen("at = 1.0\n", "", 1);
    let expected = "s.toml:3:12: duration: invalid type: string \"long\", expected a number\n\
                    s.toml:23:1: key `frame` is missing\n\
                    s.toml:39:1: key `at` is missing";
    assert_eq!(scenario(&lacking).err().as_deref(), Some(expected));
    let keys: Vec<String> = (0..50).map(|i| format!("key_{i} = {i}\n")).collect();
    let message = scenario(&replaced("step = 0.00025\n", &keys.concat())).err();
    assert_eq!(message.map(|message| message.lines().count()), Some(20));
    // Of a long file the first is enough: all of it would be read again for each.
    let long = format!("# {}\n{}", "x".repeat(40_000), keys.concat());
    let message = scenario(&replaced("step = 0.00025\n", &long)).err();
    assert_eq!(message.map(|message| message.lines().count()), Some(1));
}

#[test]
fn missing_keys() {
    refused("name = \"push\"\n", "", "s.toml:1:1: key `name` is missing");
    refused(
        "duration = 2.0\n",
        "",
        "s.toml:1:1: key `duration` is missing",
    );
    refused("at = 1.0\n", "", "s.toml:40:1: key `at` is missing");
    refused(
        "frame = \"base_link\"\n",
        "",
        "s.toml:23:1: key `frame` is missing",
    );
}

#[test]
fn wrong_types() {
    refused(
        "duration = 2.0",
        "duration = \"long\"",
        "s.toml:3:12: duration: invalid type: string \"long\", expected a number",
    );
    refused(
        "position = [-0.5, 0.0, 1.258]",
        "position = [-0.5, 0.0]",
        "s.toml:6:12: initial.position: invalid length 2, expected a list of length 3",
    );
    refused(
        "step = 0.00025",
        "command_delay = -1",
        "s.toml:13:17: plant.command_delay: invalid value: integer `-1`, expected an integer, 0 or more",
    );
    refused(
        "set.task.contact_force.feedback = \"off\"",
        "set = 3",
        "s.toml:50:7: case[1].set: invalid type: integer `3`, expected tables of values, like \
         task.<name>.<key> = …",
    );
    refused(
        "[1e-3, 1e-3, 3.0]",
        "\"x\"",
        "s.toml:43:24: event[0].weight.contact_force: invalid type: string \"x\", expected a number or a list of \
         numbers, one per row",
    );
    refused(
        "duration = 2.0",
        "duration = 2.0 s",
        "s.toml:3:12: string values must be quoted, expected literal string",
    );
}

#[test]
fn duration() {
    for (value, shown) in [("0.0", "0"), ("-1.0", "-1"), ("nan", "NaN"), ("inf", "inf")] {
        refused(
            "duration = 2.0",
            &format!("duration = {value}"),
            &format!("s.toml:3:12: duration: is {shown} s, must be positive and finite"),
        );
    }
    // Years.
    refused(
        "duration = 2.0",
        "duration = 1e9",
        "s.toml:3:12: duration: is 1e9 s, which are 2.5e11 control periods at 250 Hz; a run has at most 1e8: make it \
         shorter",
    );
    let fine =
        replaced("duration = 2.0", "duration = 10000.0").replace("step = 0.00025", "step = 1e-7");
    assert_eq!(
        scenario(&fine).expect_err("is too much"),
        "s.toml:13:8: plant.step: is 1e-7 s, which makes 1.0e11 steps in 10000 s; a run has at most 1e10: make the \
         step larger or the run shorter"
    );
}

#[test]
fn cases() {
    let without = &GOOD[..GOOD.find("[[case]]").expect("has cases")];
    assert_eq!(
        scenario(without).expect_err("has no case"),
        "s.toml: case: there is none; add a [[case]] with a name"
    );
    refused(
        "\"two\"",
        "\"one\"",
        "s.toml:49:8: case[1]: the name `one` is used twice",
    );
    for name in ["a/b", "", "ä", "."] {
        refused(
            "\"two\"",
            &format!("\"{name}\""),
            &format!(
                "s.toml:49:8: case[1]: name `{name}` must be made of letters, digits, `_` and `-`"
            ),
        );
    }
    let scenario = scenario(GOOD).expect("is good");
    assert_eq!(
        scenario
            .controller_config("three")
            .expect_err("is none")
            .to_string(),
        "s.toml: there is no case `three` (known: one, two)"
    );
}

#[test]
fn the_controllers_file() {
    let missing = scenario(&replaced(
        "push_with_disturbance.controller.toml",
        "none.toml",
    ))
    .expect_err("is not there");
    let file = scenarios().join("none.toml");
    let start = format!("{}: cannot be read: ", file.display());
    assert!(missing.starts_with(&start), "{missing}");
    assert!(
        missing.ends_with("\nin case `one` of s.toml:2:14"),
        "{missing}"
    );
    // Another file's errors are shown as that file's.
    let wrong = scenario(&replaced(
        "push_with_disturbance.controller.toml",
        "push_with_disturbance.toml",
    ))
    .expect_err("is no controller");
    let file = scenarios().join("push_with_disturbance.toml");
    let start = format!(
        "{}: top level: table `[robot]` is missing\n",
        file.display()
    );
    assert!(wrong.starts_with(&start), "{wrong}");
}

#[test]
fn overrides() {
    let over = "contact_force.feedback = \"off\"";
    refused(
        over,
        "force.feedback = \"off\"",
        "{controller}: override task `force`.`feedback`: no task has this name; did you mean `contact_force`? \
         (known: base_position, base_orientation, posture, contact_force, propeller_regularisation)\n\
         in case `two` of s.toml:49:8",
    );
    refused(
        over,
        "contact_force.feedback = \"of\"",
        "{controller}: override task `contact_force`.`feedback`: unknown value `of`, expected `off` \
         or `pi`\nin case `two` of s.toml:49:8",
    );
    refused(
        over,
        "contact_force.feed = \"off\"",
        "{controller}: override task `contact_force`.`feed`: unknown key `feed`; did you mean `feedback`? \
         (known: active, anti_windup, clamp, contact, feedback, hardness, ki, kp, name, reference, tangential, \
         transition, type, weight)\nin case `two` of s.toml:49:8",
    );
    // What only the robot can tell.
    refused(
        over,
        "contact_force.weight = [1, 2]",
        "{controller}: override task `contact_force`.`weight`: has 2 entries, expected one \
         number, or 3: one per row\nin case `two` of s.toml:49:8",
    );
}

#[test]
fn initial_state() {
    refused(
        "arm_pitch1",
        "arm_pitch9",
        "s.toml:10:1: initial.joints: the robot has no joint `arm_pitch9`; did you mean `arm_pitch1`? \
         (known: arm_roll, arm_pitch1, arm_pitch2)",
    );
    for (piece, other, place) in [
        (
            "arm_pitch1 = 0.3",
            "arm_pitch1 = nan",
            "10:14: initial.joints.arm_pitch1: is NaN, must be finite",
        ),
        (
            "rpy = [0.0, 0.0, 0.0]",
            "rpy = [inf, 0.0, 0.0]",
            "7:7: initial.rpy: is [inf, 0.0, 0.0], must be finite",
        ),
        (
            "position = [-0.5",
            "position = [1e90",
            "6:13: initial.position[0]: is 1e90 m: no robot has more than 1e4; it counts in m",
        ),
    ] {
        refused(piece, other, &format!("s.toml:{place}"));
    }
    refused(
        "arm_pitch1 = 0.3",
        "arm_pitch1 = 7.0",
        "s.toml:10:1: initial state: joint `arm_pitch1` at 7 is outside its range -1.570796 to 1.570796",
    );
    refused(
        "position = [-0.5",
        "position = [0.5",
        "s.toml:5:2: initial state: contact point `tool` is 0.630 m behind wall `wall`; does the wall's \
         normal point to the robot?",
    );
}

const FRAMES: &str = "(known: base_link, arm_base, arm_link1, arm_link2, arm_link3, tool, rotor_1, \
                      rotor_2, rotor_3, rotor_4, rotor_5, rotor_6)";

#[test]
fn plant() {
    refused(
        "step = 0.00025",
        "step = 0.1",
        "s.toml:13:8: plant.step: is 0.1, must be positive and at most 0.0004 s\n\
         s.toml:12:2: plant.servo.time_constant: is 0.03, must be at least two steps of 0.1 s\n\
         s.toml:15:1: plant.wall[0] `wall`: tangential_damping: is 60, must be at least \
         tangential_stiffness × step = 2000",
    );
    refused(
        "step = 0.00025",
        "step = nan\ncommand_delay = 2000\nmismatch.mass_scale = 0",
        "s.toml:13:8: plant.step: is NaN, must be positive and at most 0.0004 s\n\
         s.toml:14:17: plant.command_delay: is 2000, must be at most 1000 periods\n\
         s.toml:15:23: plant.mismatch.mass_scale: is 0, must be positive and finite",
    );
    refused(
        "normal = [-1.0, 0.0, 0.0]",
        "normal = [0.0, 0.0, 0.0]\nfriction = -1",
        "s.toml:18:10: plant.wall[0] `wall`: normal: is zero, must point from the wall to the robot\n\
         s.toml:19:12: plant.wall[0] `wall`: friction: is -1, must be finite and not negative",
    );
    refused(
        "normal = [-1.0, 0.0, 0.0]",
        "normal = [-1.0, nan, 0.0]",
        "s.toml:18:10: plant.wall[0] `wall`: normal: is [-1.0, NaN, 0.0], must be finite",
    );
    refused(
        "frame = \"tool\"",
        "frame = \"toll\"",
        &format!(
            "s.toml:21:9: plant.contact_point[0].frame: robot `othex` has no frame `toll`; did you mean `tool`? \
             {FRAMES}"
        ),
    );
    refused(
        "frame = \"base_link\"",
        "frame = \"base_lnik\"",
        &format!(
            "s.toml:24:9: plant.disturbance[0].frame: robot `othex` has no frame `base_lnik`; did you mean \
             `base_link`? {FRAMES}"
        ),
    );
    refused(
        "force = [-3.5",
        "force = [nan",
        "s.toml:25:9: plant.disturbance[0].force: is [NaN, 0.0, 0.0], must be finite",
    );
    refused(
        "force = [-3.5",
        "force = [1e90",
        "s.toml:25:10: plant.disturbance[0].force[0]: is 1e90 N: no robot has more than 1e8; it counts in N",
    );
    refused(
        "force = [-3.5",
        "name = \"a\\u001b\"\nforce = [-3.5",
        "s.toml:25:8: plant.disturbance[0].name: has control characters, such as line breaks: leave them out",
    );
    refused(
        "until = 2.0",
        "until = 0.5",
        "s.toml:27:9: plant.disturbance[0].until: is 0.5, must not be before from = 1",
    );
    refused(
        "step = 0.00025",
        "step = 1e-12",
        "s.toml:13:8: plant.step: is 1e-12, must be at least 1e-7 s",
    );
    refused(
        "normal = [-1.0, 0.0, 0.0]",
        "normal = [-1.0, 0.0, 0.0, 5.0]",
        "s.toml:18:10: plant.wall[0].normal: invalid length 4, expected a list of length 3",
    );
    refused(
        "[[plant.contact_point]]\nframe = \"tool\"",
        "[[plant.contact_point]]\nframe = \"tool\"\n[[plant.contact_point]]\nframe = \"tool\"",
        "s.toml:23:9: plant.contact_point[1].frame: is the frame `tool` of a point at the same place: it would push \
         twice",
    );
    let stiff = "normal = [-1.0, 0.0, 0.0]\nstiffness = 1e9\ntangential_stiffness = 1e4";
    let message =
        scenario(&replaced("normal = [-1.0, 0.0, 0.0]", stiff)).expect_err("is too stiff");
    let start = "s.toml:13:8: step of 0.00025 s is too large: it may be at most ";
    assert!(message.starts_with(start), "{message}");
    let wall = " s, as wall `wall` has up to 1000000000 N/m and ";
    let (_, told) = message.split_at(start.len());
    let (most, _) = told.split_once(wall).expect("says why");
    let shorter = replaced("normal = [-1.0, 0.0, 0.0]", stiff);
    let step = |step: &str| scenario(&shorter.replace("step = 0.00025", &format!("step = {step}")));
    step(most).expect("is short enough");
    step(&format!(
        "{}",
        1.01 * most.parse::<f64>().expect("is a number")
    ))
    .expect_err("is not");
}

/// Whatever number of the file is one that nobody means: it is refused, or told.
#[test]
fn no_number_is_taken_silently_whatever_its_size() {
    let is_digit = |c: char| c.is_ascii_digit();
    let mut tried = 0;
    let mut start = 0;
    while let Some(at) = GOOD[start..].find(is_digit).map(|at| start + at) {
        let of_number = |c: char| c.is_ascii_digit() || ".e-".contains(c);
        let end = GOOD[at..]
            .find(|c| !of_number(c))
            .map_or(GOOD.len(), |end| at + end);
        start = end;
        let before = GOOD[..at].trim_end_matches('-');
        if !before.ends_with(['[', ' ']) {
            // Of a name.
            continue;
        }
        tried += 1;
        let text = format!("{before}1e99{}", &GOOD[end..]);
        let Ok(scenario) = Scenario::from_text(&text, "s.toml", &scenarios()) else {
            continue;
        };
        let case = scenario.case("one").expect("is there");
        let config = case.controller_config().expect("is sound");
        let warnings = case.warnings(&case.make_controller(config).expect("fits"));
        assert!(
            warnings.iter().any(|warning| warning.contains("1e99")),
            "{text}\n{warnings:?}"
        );
    }
    assert!(tried > 25, "{tried}");
}

#[test]
fn sensors() {
    refused(
        "position_sd = 0.0005",
        "position_sd = -1",
        "s.toml:30:15: sensors.base.position_sd: is -1, must be finite and not negative",
    );
    refused(
        "force_sd = 0.05",
        "force_sd = nan\ncutoff = 0",
        "s.toml:34:12: sensors.force_torque[0].force_sd: is NaN, must be finite and not negative\n\
         s.toml:35:10: sensors.force_torque[0].cutoff: is 0, must be positive",
    );
    refused(
        "frame = \"tool\"\nforce_sd",
        "frame = \"toll\"\nforce_sd",
        &format!(
            "s.toml:33:9: sensors.force_torque[0].frame: robot `othex` has no frame `toll`; did you mean `tool`? \
             {FRAMES}"
        ),
    );
}

#[test]
fn detectors() {
    refused(
        "contact = \"tip\"",
        "contact = \"top\"",
        "s.toml:36:1: detector: there is no contact `top`; did you mean `tip`? (known: tip)",
    );
    refused(
        "\non = 1.0",
        "\non = 0.1",
        "s.toml:36:1: detector: `on` is 0.1 N, must be above off = 0.3 N",
    );
    refused(
        "\non = 1.0",
        "\non = 1e300",
        "s.toml:36:1: detector: `on` is 1e300 N: no robot has more than 1e8; it counts in N",
    );
    refused(
        "\non = 1.0",
        "\ndwell = -1.0",
        "s.toml:36:1: detector: `dwell` is -1 s, must be finite and not negative",
    );
    refused(
        "\non = 1.0",
        "\noff = -0.6",
        "s.toml:36:1: detector: `off` is -0.6 N, must not be negative: in the air a sensor that was tared \
         says zero, and noise",
    );
    refused(
        "contact = \"tip\"",
        "contact = \"tip\"\n[[detector]]\ncontact = \"tip\"",
        "s.toml:38:1: detector: contact `tip` has a detector already",
    );
    refused(
        "frame = \"tool\"\nforce_sd",
        "frame = \"base_link\"\nforce_sd",
        "s.toml:36:1: detector: no force is measured at contact `tip`: there is no \
         [[sensors.force_torque]] with frame = \"tool\"",
    );
}

#[test]
fn events() {
    let event = |piece: &str, other: &str, place: &str, expected: &str| {
        refused(
            piece,
            other,
            &format!("s.toml:{place}: event at 1 s: {expected}"),
        );
    };
    for (value, shown) in [("-1.0", "-1"), ("nan", "NaN"), ("inf", "inf")] {
        refused(
            "at = 1.0",
            &format!("at = {value}"),
            &format!("s.toml:41:6: event at {shown} s: at: must be finite and not negative"),
        );
    }
    let entries =
        "base_position, base_orientation, posture, contact_force, propeller_regularisation";
    for (action, columns) in [("activate", [20, 12]), ("deactivate", [22, 14])] {
        event(
            "at = 1.0",
            &format!("at = 1.0\n{action}_contact = [\"top\"]"),
            &format!("42:{}", columns[0]),
            &format!(
                "{action}_contact: there is no contact `top`; did you mean `tip`? (known: tip)"
            ),
        );
        event(
            "at = 1.0",
            &format!("at = 1.0\n{action} = [\"cones\"]"),
            &format!("42:{}", columns[1]),
            &format!(
                "{action}: there is no entry `cones`; did you mean `cone`? (known: {entries}, limits, cone, \
                 no_slip)"
            ),
        );
    }
    let (follow, weight) = (
        "follow.base_position",
        "weight.contact_force = [1e-3, 1e-3, 3.0]",
    );
    event(
        follow,
        "follow.base_pose",
        "42:8",
        &format!("follow.base_pose: there is no task `base_pose` (known: {entries})"),
    );
    event(
        follow,
        "follow.propeller_regularisation",
        "42:8",
        "follow.propeller_regularisation: task `propeller_regularisation` follows no reference",
    );
    event(
        "\"min_jerk\"",
        "\"minjerk\"",
        "42:8",
        "follow.base_position: unknown reference type `minjerk`; did you mean `min_jerk`? \
         (known: ellipse, hold, min_jerk, thrust_attitude, waypoints)",
    );
    event(
        "to = [",
        "too = [",
        "42:45",
        "follow.base_position: unknown key `too`; did you mean `to`? (known: duration, from, start, to)",
    );
    event(
        "to = [-0.1, 0.0, 1.258]",
        "to = [-0.1, 0.0]",
        "42:45",
        "follow.base_position: `to` has 2 entries, expected 3",
    );
    event(
        "duration = 6.0",
        "duration = -6.0",
        "42:70",
        "follow.base_position: `duration` is -6, must be finite and above zero",
    );
    event(
        "{ type = \"min_jerk\", to = [-0.1, 0.0, 1.258], duration = 6.0 }",
        "3",
        "42:24",
        "follow.base_position: must be a table with a `type`, found integer",
    );
    event(
        follow,
        "follow.contact_force = { type = \"hold\", value = [-5.0] }\n#",
        "42:41",
        "follow.contact_force: `value` is -5 N: a surface pushes and never pulls, a normal force is 0 or more",
    );
    event(
        follow,
        "follow.contact_force = { type = \"hold\", value = [1e4] }\n#",
        "42:41",
        "follow.contact_force: `value` is 10000 N, more than the contact's `force_max` of 20 N",
    );
    event(
        weight,
        "weight.contact_force = 1e308",
        "43:24",
        "weight.contact_force: is 1e308, must be 0 or between 1e-100 and 1e100",
    );
    event(
        "to = [-0.1, 0.0, 1.258]",
        "to = [-0.1, 1e308, 1.258]",
        "42:57",
        "follow.base_position.to[1]: is 1e308 m: no robot has more than 1e4; it counts in m",
    );
    event(
        "duration = 6.0",
        "duration = 1e-300",
        "42:81",
        "follow.base_position.duration: is 1e-300 s: shorter than any period; it counts in seconds",
    );
    for (value, given) in [
        ("[1e-3, 3.0]", "[0.001, 3.0]"),
        ("-1.0", "-1"),
        ("nan", "NaN"),
    ] {
        event(
            weight,
            &format!("weight.contact_force = {value}"),
            "43:24",
            &format!(
                "weight.contact_force: `weight` is {given}, must be one number, or 3, finite and not negative"
            ),
        );
    }
    event(
        weight,
        "weight.contactforce = 1.0",
        "43:23",
        &format!(
            "weight.contactforce: there is no entry `contactforce`; did you mean `contact_force`? (known: {entries}, \
             limits, cone, no_slip)"
        ),
    );
}

/// The key that is wrong is the changed one, which the case has.
#[test]
fn an_event_that_a_case_changes_is_wrong_there() {
    let text = replaced("at = 1.0", "at = 1.0\nmark = \"go\"").replace(
        "set.task.contact_force.feedback = \"off\"",
        "change.event.go.weight.contact_force = -1.0",
    );
    assert_eq!(
        scenario(&text).expect_err("is negative"),
        "s.toml:51:40: event `go` at 1 s: weight.contact_force: `weight` is -1, must be one number, or 3, finite and \
         not negative\nin case `two` of s.toml"
    );
}

#[test]
fn types_of_tables_and_lists() {
    for (piece, other, place, list) in [
        ("[[plant.wall]]", "[plant.wall]", "15:8", "plant.wall"),
        (
            "[[sensors.force_torque]]",
            "[sensors.force_torque]",
            "32:10",
            "sensors.force_torque",
        ),
        ("[[event]]", "[event]", "40:2", "event"),
    ] {
        let expected = format!(
            "s.toml:{place}: `{list}` is a list, also of one: write `[[{list}]]`, with two brackets on each side"
        );
        refused(piece, other, &expected);
    }
    refused(
        "[initial]",
        "[[initial]]",
        "s.toml:5:3: `initial` is there once: write `[initial]`, with one bracket on each side",
    );
    refused(
        "force = [-3.5, 0.0, 0.0]",
        "force = [-3.5, \"left\", 0.0]",
        "s.toml:25:16: plant.disturbance[0].force[1]: invalid type: string \"left\", expected a number",
    );
}

/// What would do nothing, whether a case has it from the file or from a change.
#[test]
fn entries_that_would_do_nothing() {
    let force = "force = [-3.5, 0.0, 0.0]\n";
    refused(
        force,
        "",
        "s.toml:23:1: plant.disturbance[0] `disturbance`: has neither `force` (N) nor `moment` (N·m), so that it does \
         nothing: give it one (of zeros, if something else sets it later), or take it out",
    );
    // Zero in so many words may be the beginning of a sweep.
    for other in ["force = [0, 0, 0]\n", "moment = [0.0, 0.0, 1.0]\n"] {
        scenario(&replaced(force, other)).expect("says how it pushes");
    }
    let in_a_case =
        replaced(force, "") + "change.plant.disturbance.disturbance.moment = [0, 0, 1]\n";
    scenario(&in_a_case).expect("pushes in a case");

    let event = |keys: &str| {
        replaced(
            "[[case]]",
            &format!("[[event]]\nat = 0.5\n{keys}\n\n[[case]]"),
        )
    };
    let nothing = "s.toml:45:1: event at 0.5 s: does nothing: give it an action, such as `follow`, or a `mark`, or \
                   take it out";
    for keys in ["", "activate = []", "weight = {}"] {
        assert_eq!(scenario(&event(keys)).expect_err("does nothing"), nothing);
    }
    scenario(&event("mark = \"half\"")).expect("marks a time");

    let late = |from: &str, end: &str| {
        format!(
            "from: is {from} s, and the longest case ends at {end} s: it would never push; let it begin earlier, or \
             make `duration` longer"
        )
    };
    let window = "from = 1.0\nuntil = 2.0";
    refused(
        window,
        "from = 2.0",
        &format!("s.toml:26:8: plant.disturbance[0].{}", late("2", "2")),
    );
    let outage = |from: &str| {
        let other = format!("[[sensors.outage]]\nsensor = \"tool\"\nfrom = {from}\n\n[[event]]");
        scenario(&replaced("[[event]]", &other))
    };
    outage("1.996").expect("breaks the last sample");
    assert_eq!(
        outage("1.997").expect_err("is behind the last sample"),
        "s.toml:42:8: sensors.outage[0].from: is 1.997 s, and the longest case ends at 2 s: it would never break the \
         sensor; let it begin earlier, or make `duration` longer"
    );
    // A case may be shorter or longer than the others, and have what only they come to.
    let with = |from: &str, change: &str| {
        scenario(&(replaced(window, &format!("from = {from}")) + change + "\n"))
    };
    let gust = "change.plant.disturbance.disturbance.from";
    with("1.5", "change.duration = 1.2").expect("begins in the other case");
    with("3.0", "change.duration = 5").expect("begins in this case");
    assert_eq!(
        with("6.0", "change.duration = 5").expect_err("begins in none"),
        format!("s.toml:26:8: plant.disturbance[0].{}", late("6", "5"))
    );
    assert_eq!(
        with("1.0", &format!("{gust} = 3.0")).expect_err("begins never"),
        format!(
            "s.toml:50:45: plant.disturbance[0].{}\nin case `two` of s.toml",
            late("3", "2")
        )
    );
    let short = Variation::new()
        .change("duration", 1.0)
        .change("event", toml::Value::Array(vec![]));
    let good = scenario(GOOD).expect("is good");
    good.varied(&short).expect("may be shortened from outside");
}

#[test]
fn disturbances_have_different_names() {
    let another = |name: &str| {
        let other = format!(
            "[[plant.disturbance]]\n{name}frame = \"tool\"\nmoment = [0, 0, 1]\n\n[sensors.base]"
        );
        replaced("[sensors.base]", &other)
    };
    assert_eq!(
        scenario(&another("")).expect_err("have one name"),
        "s.toml:29:1: plant.disturbance[1].name: `disturbance`, which one without a name has, is used twice: give it \
         another one"
    );
    let gust = another("name = \"gust\"\n");
    scenario(&gust).expect("have two names");
    let twice = gust.replacen(
        "frame = \"base_link\"",
        "name = \"gust\"\nframe = \"base_link\"",
        1,
    );
    assert_eq!(
        scenario(&twice).expect_err("have one name"),
        "s.toml:31:8: plant.disturbance[1].name: `gust` is used twice: give it another one"
    );
    // Each in a case of its own.
    let apart = twice
        .replacen("name = \"gust\"", "name = \"gust\"\ncases = [\"one\"]", 1)
        .replacen(
            "\nname = \"gust\"\nframe = \"tool\"",
            "\nname = \"gust\"\ncases = [\"two\"]\nframe = \"tool\"",
            1,
        );
    scenario(&apart).expect("are never together");
}

#[test]
fn an_outages_misspelt_sensor_is_told_where_it_is() {
    let text = replaced(
        "[[event]]",
        "[[sensors.outage]]\nsensor = \"tol\"\nfrom = 1.0\n\n[[event]]",
    );
    assert_eq!(
        scenario(&(text.clone() + "change.sensors.outage.tool.from = 0.5\n")).expect_err("is none"),
        "s.toml:41:10: sensors.outage[0].sensor: there is no sensor `tol`; did you mean `tool`, whose outage is \
         changed?"
    );
    // Of a change that names no sensor either, the change is told.
    let error = scenario(&(text + "change.sensors.outage.toll.from = 0.5\n")).expect_err("is none");
    assert!(
        error.starts_with("s.toml:55:23: [[sensors.outage]] with sensor `toll`"),
        "{error}"
    );
}

#[test]
fn a_case_that_is_there_twice_comes_before_the_one_that_is_lost() {
    let text =
        replaced("at = 1.0", "at = 1.0\ncases = [\"two\"]").replace("\"two\"\nset", "\"one\"\nset");
    assert_eq!(
        scenario(&text).expect_err("is there twice"),
        "s.toml:50:8: case[1]: the name `one` is used twice"
    );
}

/// Where a push that is too large is asked for: an event, what a case sets, or the controller's file.
#[test]
fn pushes_that_are_too_large() {
    let told = "task `contact_force` pushes on contact `tip`: 19.0 N asked, 8.0 N possible: `rotor_1`, `rotor_6` are \
                at their largest effort, friction of 0.5 is used up";
    refused(
        "follow.base_position = {",
        "follow.contact_force = { type = \"hold\", value = [19.0] }\n# {",
        &format!("s.toml:40:1: {told}"),
    );
    refused(
        "set.task.contact_force.feedback = \"off\"",
        "set.task.contact_force.reference = { type = \"hold\", value = [19.0] }",
        &format!("s.toml:49:8: {told}\nin case `two` of s.toml"),
    );
    // What is possible is less where the plant is heavier.
    let heavy = replaced(
        "[[plant.wall]]",
        "mismatch.mass_scale = 1.5\n\n[[plant.wall]]",
    );
    let error = scenario(&heavy).expect_err("is too heavy");
    let controller = scenarios().join("push_with_disturbance.controller.toml");
    let start = format!("{}:56:1: task `contact_force` pushes", controller.display());
    assert!(error.starts_with(&start), "{error}");
}

/// Values and pieces of text that may stand where a scenario has something else.
const PIECES: &[&str] = &[
    "nan",
    "inf",
    "-inf",
    "0",
    "-1",
    "1e300",
    "-1e-300",
    "9223372036854775807",
    "\"\"",
    "\"tip\"",
    "\"ä\"",
    "[]",
    "{}",
    "[1]",
    "[[1]]",
    "true",
    "1979-05-27",
    "\n",
    "\"",
    "]",
    "}",
    "=",
    "#",
    ".",
    "\0",
    "[plant]",
    "[[case]]",
    "type = \"hold\"",
];

/// A text with a word, a line or a character changed.
fn mutated(text: &str, rng: &mut ChaCha8Rng) -> String {
    let piece = PIECES[rng.random_range(0..PIECES.len())];
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let i = rng.random_range(0..lines.len());
    let line = lines[i].clone();
    match rng.random_range(0..6) {
        0 => drop(lines.remove(i)),
        1 => lines.insert(rng.random_range(0..i + 1), line),
        2 => {
            let j = rng.random_range(0..lines.len());
            lines.swap(i, j);
        }
        3 => {
            let at = rng.random_range(0..line.chars().count() + 1);
            let byte = line.char_indices().nth(at).map_or(line.len(), |(b, _)| b);
            lines[i].insert_str(byte, piece);
        }
        // A whole value or one of a list's.
        4 => {
            if let Some((key, _)) = line.split_once(" = ") {
                lines[i] = format!("{key} = {piece}");
            }
        }
        _ => {
            let words: Vec<&str> = line.split(", ").collect();
            let word = words[rng.random_range(0..words.len())];
            if !word.is_empty() {
                lines[i] = line.replacen(word, piece, 1);
            }
        }
    }
    lines.join("\n") + "\n"
}

#[test]
fn no_text_makes_loading_panic() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let (mut accepted, mut refused) = (0, 0);
    for _ in 0..600 {
        let mut text = GOOD.to_owned();
        for _ in 0..rng.random_range(1..4) {
            text = mutated(&text, &mut rng);
        }
        match scenario(&text) {
            Ok(_) => accepted += 1,
            Err(message) => {
                assert!(!message.is_empty());
                refused += 1;
            }
        }
    }
    println!("{accepted} accepted, {refused} refused");
    assert!(accepted > 20 && refused > 200, "{accepted} {refused}");
}
