//! `wbqp new`: what it writes loads, ticks optimally, and runs.

use std::{fs, path::Path};

use wbqp::{
    Controller, ControllerConfig, Measurement, controller::FallbackLevel, model::JointKind,
    serde_json,
};
use {wbqp_robots as _, wbqp_tasks as _};

use crate::common::{Done, Temporary, fixture, root, wbqp};

const QUADRUPED: &str = "robots/files/quadruped/quadruped.urdf";
const HUMANOID: &str = "robots/files/humanoid/humanoid.urdf";

/// Writes a controller; returns it, made.
fn new(folder: &Temporary, urdf: &str, kind: &str, code: i32) -> (String, Controller) {
    let file = folder.file("new.toml");
    let done = wbqp(&["new", "--urdf", urdf, "--kind", kind, "--output", &file]);
    let text = fs::read_to_string(&file).unwrap_or_default();
    assert_eq!(done.code, code, "{}\n{}\n{text}", done.stdout, done.stderr);
    assert!(
        done.stdout.contains("100 ticks from home, all optimal"),
        "{}",
        done.stdout
    );
    assert!(
        done.stdout.contains("2 s of simulation, all ticks optimal"),
        "{}",
        done.stderr
    );
    let controller = Controller::new(ControllerConfig::from_file(&file).unwrap()).unwrap();
    (text, controller)
}

/// Not what the command says but what the file does.
fn ticks_optimally(controller: &mut Controller) {
    let contacts = controller.contact_names().count();
    let mut measurement = Measurement::home(controller.robot(), contacts);
    let period = 1.0 / controller.settings().rate;
    for tick in 0..100 {
        measurement.time = f64::from(tick) * period;
        let (command, report) = controller.tick(&measurement);
        assert_eq!(report.level, FallbackLevel::Optimal, "tick {tick}");
        assert!(command.effort.iter().all(|u| u.is_finite()));
    }
    // At home and at rest it stays: nothing accelerates.
    let fastest = controller.report().vdot.amax();
    assert!(fastest < 1e-2, "{fastest}");
}

/// It stays where it is in simulation, too.
fn stands(folder: &Temporary, file: &Path) {
    let out = folder.file("out");
    let file = file.display().to_string();
    let done = wbqp(&["run", &file, "--duration", "0.6", "--out", &out]);
    assert_eq!(done.code, 0, "{}{}", done.stdout, done.stderr);
    let summary = Path::new(&out).join("new/summary.json");
    let summary: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(summary).unwrap()).unwrap();
    assert_eq!(summary[0]["not_optimal"], 0, "{}", done.stdout);
    for task in summary[0]["tasks"].as_array().unwrap() {
        let end = task["end"].as_f64().unwrap();
        // The ground gives way a little; the posture pays for it.
        let most = if task["name"] == "posture" {
            0.05
        } else {
            0.002
        };
        assert!(end < most, "{task}");
    }
}

#[test]
fn a_quadruped_stands_on_its_feet() {
    let folder = Temporary::new("quadruped");
    let (text, mut controller) = new(&folder, QUADRUPED, "quadruped", 0);
    let names: Vec<&str> = controller.contact_names().collect();
    assert_eq!(names, ["fl_foot", "fr_foot", "hl_foot", "hr_foot"]);
    // The knees are bent, the legs alike.
    let robot = controller.robot();
    let q = |name: &str| robot.home.q[robot.model.joint(name).unwrap().index()];
    assert!(q("fl_knee").abs() > 0.5 && (q("fl_knee") - q("fr_knee")).abs() < 1e-3);
    assert!(q("fl_hip_roll").abs() < 1e-3);
    ticks_optimally(&mut controller);
    let lines = text.lines().map(str::trim);
    let counted = lines.filter(|line| !line.is_empty() && !line.starts_with('#'));
    assert!(counted.count() <= 35, "{text}");
    stands(&folder, Path::new(&folder.file("new.toml")));
}

/// Legs in two planes: hard rows of their feet depend on one another, and contradict as soon as the ground gives way.
#[test]
fn planar_legs_have_soft_contacts() {
    let folder = Temporary::new("planar");
    let file = folder.file("new.toml");
    let lock = "robot.lock=[\".*_hip_roll\"]";
    let arguments = [
        "new",
        "--urdf",
        QUADRUPED,
        "--kind",
        "quadruped",
        "--set",
        lock,
        "--output",
        &file,
    ];
    let done = wbqp(&arguments);
    assert_eq!(done.code, 0, "{}{}", done.stdout, done.stderr);
    let text = fs::read_to_string(&file).unwrap();
    assert!(text.contains("motion = \"soft\""), "{text}");
    let why = "of the 12 directions in which contacts with hard motion must not move, 2 follow from the others";
    assert!(text.replace("\n# ", " ").contains(why), "{text}");
    stands(&folder, Path::new(&file));
}

/// One foot above the ground: a tick at home sees nothing of that, and lets all four carry.
#[test]
fn a_robot_that_does_not_stand_in_simulation_is_said() {
    let folder = Temporary::new("falls");
    let done = new_at_home(&folder, "fl_hip_roll", "0.0", "-1.6");
    assert!(done.stdout.contains("100 ticks from home, all optimal"));
    let words = "warning: within 2 s of simulation";
    assert!(done.stderr.contains(words), "{}", done.stderr);
}

#[test]
fn joints_of_a_named_posture_that_were_moved_are_said() {
    let folder = Temporary::new("moved");
    let done = new_at_home(&folder, "fl_hip_roll", "-1.2", "-1.244");
    let words = "joint `fl_hip_roll`: is at -1.2 in the home state, outside its range -0.9 to 0.9: moved to -0.9";
    assert!(done.stderr.contains(words), "{}", done.stderr);
}

/// Writes a controller for the quadruped that begins in a named posture: knees bent, one by `knee`, and a joint
/// elsewhere. It has something to be said of.
fn new_at_home(folder: &Temporary, joint: &str, at: &str, knee: &str) -> Done {
    let mut values = vec![(joint.to_owned(), at)];
    for leg in ["fl", "fr", "hl", "hr"] {
        values.push((format!("{leg}_hip_pitch"), "0.68"));
        values.push((
            format!("{leg}_knee"),
            if leg == "fl" { knee } else { "-1.244" },
        ));
    }
    let values: Vec<String> = values
        .iter()
        .map(|(name, value)| format!("<joint name=\"{name}\" value=\"{value}\"/>"))
        .collect();
    let srdf = folder.file("robot.srdf");
    let text = format!(
        "<robot name=\"quadruped\"><group_state name=\"half\" group=\"all\">{}</group_state></robot>",
        values.join("")
    );
    fs::write(&srdf, text).unwrap();
    let (file, home) = (folder.file("new.toml"), "robot.home=half");
    let robot = ["new", "--urdf", QUADRUPED, "--kind", "quadruped"];
    let rest = ["--srdf", &srdf, "--set", home, "--output", &file];
    let done = wbqp(&[&robot[..], &rest].concat());
    assert_eq!(done.code, 1, "{}{}", done.stdout, done.stderr);
    done
}

#[test]
fn a_humanoid_stands_on_soles_of_an_assumed_size() {
    let folder = Temporary::new("humanoid");
    // The file has no shapes: that is said, in the file as well.
    let (text, mut controller) = new(&folder, HUMANOID, "humanoid", 1);
    assert!(
        text.contains("ATTENTION") && text.contains("ASSUMED"),
        "{text}"
    );
    let names: Vec<&str> = controller.contact_names().collect();
    assert_eq!(names, ["left_sole", "right_sole"]);
    let robot = controller.robot();
    let knee = robot.home.q[robot.model.joint("left_knee").unwrap().index()];
    assert!(knee > 0.3, "{knee}");
    ticks_optimally(&mut controller);
    let lines = text.lines().map(str::trim);
    let counted = lines.filter(|line| !line.is_empty() && !line.starts_with('#'));
    assert!(counted.count() <= 40, "{text}");
    stands(&folder, Path::new(&folder.file("new.toml")));
}

#[test]
fn soles_have_the_size_of_their_collision_shapes() {
    let folder = Temporary::new("soles");
    let urdf = fs::read_to_string(root().join(HUMANOID)).unwrap();
    let mut boxed = urdf;
    for side in ["left", "right"] {
        let shape = "<collision><origin xyz=\"0.01 0.02 0.03\"/>\
                     <geometry><box size=\"0.2 0.1 0.06\"/></geometry></collision>";
        let link = format!("<link name=\"{side}_sole\"");
        let start = boxed.find(&link).unwrap();
        let end = start + boxed[start..].find('>').unwrap();
        let shaped = if boxed[..end].ends_with('/') {
            format!("{}>{shape}</link>{}", &boxed[..end - 1], &boxed[end + 1..])
        } else {
            format!("{}>{shape}{}", &boxed[..end], &boxed[end + 1..])
        };
        boxed = shaped;
    }
    let file = folder.file("boxed.urdf");
    fs::write(&file, boxed).unwrap();
    let (text, _) = new(&folder, &file, "humanoid", 0);
    for line in ["size = [0.2, 0.1]", "offset = [0.01, 0.02, 0.0]"] {
        assert!(text.contains(line), "{line}\n{text}");
    }
}

#[test]
fn an_arm_holds_its_tip() {
    let folder = Temporary::new("arm");
    let (text, mut controller) = new(&folder, &fixture("arm.urdf"), "arm", 0);
    assert!(text.contains("frame = \"tool0\""), "{text}");
    assert!(text.contains("base = \"fixed\""), "{text}");
    // The elbow is bent.
    let robot = controller.robot();
    let elbow = robot.home.q[robot.model.joint("elbow").unwrap().index()];
    assert!(elbow < -0.3, "{text}");
    ticks_optimally(&mut controller);
    stands(&folder, Path::new(&folder.file("new.toml")));
}

/// As some arms have them: 0 is far from all that the joints can be.
#[test]
fn an_arm_is_at_home_with_room_to_both_ends_of_its_ranges() {
    let folder = Temporary::new("arm_elsewhere");
    let urdf = fs::read_to_string(fixture("arm.urdf")).unwrap();
    let urdf = urdf.replace("lower=\"-2\" upper=\"2\"", "lower=\"0.8\" upper=\"5.5\"");
    let file = folder.file("elsewhere.urdf");
    fs::write(&file, urdf).unwrap();
    let (_, controller) = new(&folder, &file, "arm", 0);
    let robot = controller.robot();
    let joints = robot.model.joints().iter().zip(&robot.home.q);
    let mut seen = 0;
    for (joint, q) in joints.filter(|(joint, _)| joint.kind == JointKind::Revolute) {
        let range = joint.limits.upper - joint.limits.lower;
        if range.is_finite() {
            let room = (q - joint.limits.lower).min(joint.limits.upper - q) / range;
            assert!(room > 0.1, "{}: {q}", joint.name);
            seen += 1;
        }
    }
    assert_eq!(seen, 5);
}

#[test]
fn a_quadrotor_hovers_on_rotors_that_are_assumed() {
    let folder = Temporary::new("quadrotor");
    // The file has nothing of rotors but their places: that is said, in the file as well.
    let (text, mut controller) = new(&folder, &fixture("quadrotor.urdf"), "multirotor", 1);
    let unwrapped = text.replace("\n# ", " ");
    assert!(
        unwrapped.contains("ATTENTION: the robot's file says no more of its rotors"),
        "{text}"
    );
    // Turning propellers are locked: thrusts stand for them.
    assert_eq!(controller.robot().model.nv(), 6);
    assert!(text.contains("rotor_3_joint"), "{text}");
    assert_eq!(controller.robot().nu(), 4);
    let rotors = fs::read_to_string(folder.file("new.rotors.toml")).unwrap();
    assert!(rotors.contains("ASSUMED"), "{rotors}");
    // Neighbours turn against one another, or the base would turn.
    let reaction = |name: &str| {
        let found = controller.robot().rotors().find(|(_, a, _)| a.name == name);
        found.unwrap().2.reaction
    };
    assert_eq!(reaction("rotor_0"), reaction("rotor_1"));
    assert_ne!(reaction("rotor_0"), reaction("rotor_2"));
    ticks_optimally(&mut controller);
    stands(&folder, Path::new(&folder.file("new.toml")));
}

#[test]
fn rotors_that_no_frame_shows_are_assumed_and_that_is_said() {
    let folder = Temporary::new("no-frames");
    let urdf = fs::read_to_string(fixture("quadrotor.urdf")).unwrap();
    let file = folder.file("hex_tilt.urdf");
    let urdf = urdf
        .replace("rotor_", "blade_")
        .replace("four_rotors", "hex_tilt");
    fs::write(&file, urdf).unwrap();
    let (text, mut controller) = new(&folder, &file, "multirotor", 1);
    assert!(text.contains("ATTENTION"), "{text}");
    assert_eq!(controller.robot().rotors().count(), 6);
    ticks_optimally(&mut controller);
}

#[test]
fn nothing_is_replaced_unless_asked() {
    let folder = Temporary::new("replace");
    let file = folder.file("new.toml");
    fs::write(&file, "mine").unwrap();
    let arguments = [
        "new",
        "--urdf",
        QUADRUPED,
        "--kind",
        "quadruped",
        "--output",
        &file,
    ];
    let done = wbqp(&arguments);
    assert_eq!(done.code, 1);
    assert!(done.stderr.contains("--force"), "{}", done.stderr);
    assert_eq!(fs::read_to_string(&file).unwrap(), "mine");
    let done = wbqp(&[&arguments[..], &["--force"]].concat());
    assert_eq!(done.code, 0, "{}", done.stderr);
}

#[test]
fn what_a_robot_does_not_have_is_said() {
    let folder = Temporary::new("lacking");
    let refused = |urdf: &str, kind: &str, expected: &str| {
        let file = folder.file("lacking.toml");
        let done = wbqp(&["new", "--urdf", urdf, "--kind", kind, "--output", &file]);
        assert_eq!(done.code, 1);
        assert!(done.stderr.contains(expected), "{}", done.stderr);
        assert!(!Path::new(&file).exists());
    };
    refused(&fixture("arm.urdf"), "quadruped", "needs four");
    refused(&fixture("quadrotor.urdf"), "humanoid", "needs two legs");
}

/// Legs with no joint left to move by, and a motor that is too weak for the posture.
#[test]
fn a_robot_that_cannot_move_or_hold_still_is_said() {
    let folder = Temporary::new("cannot");
    let urdf = fs::read_to_string(fixture("arm.urdf")).unwrap();
    let weak = folder.file("weak.urdf");
    let lift = r#"<limit lower="-2" upper="2" effort="60" velocity="3"/>"#;
    assert_eq!(urdf.matches(lift).count(), 1);
    fs::write(&weak, urdf.replace(lift, &lift.replace("60", "2"))).unwrap();
    for (urdf, kind, words) in [
        (
            QUADRUPED,
            "humanoid",
            "have 6 joints in all: with two soles flat on the ground, six constraints each, the robot cannot move",
        ),
        (
            weak.as_str(),
            "arm",
            "missing, joint `lift`, whose motor is at its limit",
        ),
    ] {
        let file = folder.file(&format!("{kind}.toml"));
        let done = wbqp(&["new", "--urdf", urdf, "--kind", kind, "--output", &file]);
        assert_eq!(done.code, 1, "{}", done.stdout);
        assert!(done.stderr.contains(words), "{}", done.stderr);
        if kind == "arm" {
            let checked = wbqp(&["check", &file]);
            assert_eq!(checked.code, 1, "{}", checked.stdout);
            assert!(checked.stderr.contains("does not hold still at home"));
        }
    }
}
