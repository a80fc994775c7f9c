//! Numbers of a URDF that can be computed with and are not likely to be meant: taken with a warning; strictly, refused.

use wbqp::robot::SourceFile;
use wbqp_robots::{Options, from_sources};

/// A quadrotor of which nothing is to be said; its propellers are frozen.
const PROPPY: &str = r#"<robot name="proppy">
<link name="body"><inertial><mass value="1.2"/>
<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.03"/></inertial></link>
<link name="prop"><inertial><mass value="0.01"/>
<inertia ixx="1e-5" ixy="0" ixz="0" iyy="1e-5" iyz="0" izz="2e-5"/></inertial></link>
<joint name="spin" type="continuous"><parent link="body"/><child link="prop"/><origin xyz="0.2 0.2 0.03"
  rpy="0 1.57 0"/>
<axis xyz="0 0 1"/><limit effort="1" velocity="100"/></joint>
</robot>
"#;

const ROTORS: &str = "[[rotor]]
name = 'front'
frame = 'prop'
reaction = -1
thrust_coefficient = 1.3e-5
moment_coefficient = 0.016
thrust = { min = 0.2, max = 10 }
time_constant = { rise = 0.01, fall = 0.02 }
";

fn source(name: &str, contents: &str) -> SourceFile {
    SourceFile {
        name: name.to_owned(),
        contents: contents.to_owned(),
    }
}

fn options(text: &str) -> Options {
    toml::from_str(text).expect("are options")
}

/// Warnings, each on a line.
fn said(urdf: &str, rotors: Option<&str>, given: &str) -> Vec<String> {
    let rotors = rotors.map(|text| source("r.toml", text));
    let robot = from_sources(source("r.urdf", urdf), rotors, &options(given)).expect("is taken");
    robot.diagnostics.iter().map(ToString::to_string).collect()
}

#[track_caller]
fn is_said_and_strictly_refused(urdf: &str, place: &str, words: &str, remedy: &str) {
    let all = said(urdf, None, "");
    let [one] = all.as_slice() else {
        panic!("{all:#?}");
    };
    let expected = [place, words, remedy];
    assert!(expected.iter().all(|part| one.contains(part)), "{one}");
    let strict = from_sources(source("r.urdf", urdf), None, &options("strict = true"));
    let refused = strict.expect_err("is refused").to_string();
    assert!(refused.contains(words), "{refused}");
}

#[test]
fn what_is_usual_is_taken_without_a_word() {
    assert_eq!(said(PROPPY, None, ""), Vec::<String>::new());
    // A turn is one, and a body of a robot may be far from its own middle: a mast of 30 m.
    let mast = PROPPY
        .replace("0 1.57 0", "0 -6.2832 0")
        .replace("value=\"1.2\"", "value=\"300\"")
        .replace("ixx=\"0.02\"", "ixx=\"22500\"")
        .replace("iyy=\"0.02\"", "iyy=\"22500\"");
    assert_eq!(said(&mast, None, ""), Vec::<String>::new());
    // Numbers made up for a link that is next to nothing.
    let made_up = PROPPY
        .replace("value=\"0.01\"", "value=\"1e-6\"")
        .replace("\"1e-5\"", "\"1\"")
        .replace("\"2e-5\"", "\"1\"");
    assert_eq!(said(&made_up, None, ""), Vec::<String>::new());
}

#[test]
fn angles_in_degrees_are_said() {
    is_said_and_strictly_refused(
        &PROPPY.replace("0 1.57 0", "0 90 0"),
        "r.urdf:6:",
        "joint `spin`: an angle of its rpy is 90 rad, more than a turn",
        "90° are 1.570796 rad",
    );
}

#[test]
fn moments_of_other_units_are_said() {
    let wrong = PROPPY
        .replace("ixx=\"1e-5\"", "ixx=\"10\"")
        .replace("iyy=\"1e-5\"", "iyy=\"10\"")
        .replace("izz=\"2e-5\"", "izz=\"20\"");
    is_said_and_strictly_refused(
        &wrong,
        "r.urdf:4:",
        "link `prop`: with 0.01 kg and a moment of inertia of 20 kg·m² its mass is 44.7 m from its middle",
        "1 kg·mm² 1e-6",
    );
    let given = "[inertia.prop]\nmass = 0.01\ncom = [0, 0, 0]\nmoments = [1e-5, 1e-5, 2e-5]\n";
    assert_eq!(said(&wrong, None, given), Vec::<String>::new());
}

#[test]
fn joints_that_turn_propellers_are_to_be_locked() {
    let all = said(PROPPY, Some(ROTORS), "");
    let [one] = all.as_slice() else {
        panic!("{all:#?}");
    };
    let expected = "r.toml:1:1: warning: rotor `front`: the joint that turns it is not locked: the controller takes it \
                    for a joint, with a motor that may turn the robot: used as it is; thrusts stand for what turns \
                    propellers: `lock = [\"spin\"]` in [robot]";
    assert_eq!(one, expected);
    let locked = said(PROPPY, Some(ROTORS), "lock = ['spin']");
    assert_eq!(locked, Vec::<String>::new());
    // A joint that tilts its rotor, and one that swings it around, are there to be moved.
    let tilting = PROPPY.replace("axis xyz=\"0 0 1\"", "axis xyz=\"0 1 0\"");
    let tip = "<link name=\"tip\"/><joint name=\"out\" type=\"fixed\"><origin xyz=\"0.3 0 0\"/><parent link=\"prop\"/>\
               <child link=\"tip\"/></joint></robot>";
    let swinging = PROPPY.replace("</robot>", tip);
    for (urdf, frame) in [(&tilting, "'prop'"), (&swinging, "'tip'")] {
        let rotors = ROTORS.replace("'prop'", frame);
        assert_eq!(said(urdf, Some(&rotors), ""), Vec::<String>::new());
    }
}
