//! `wbqp check`: JSON, exit codes, and that errors come with their places.

use std::fs;

use wbqp::serde_json::Value;

use crate::common::{Temporary, fixture, root, wbqp};

const HUMANOID: &str = "robots/files/humanoid/humanoid.urdf";
const OTHEX: &str = "robots/files/othex/othex.urdf";
const ROTORS: &str = "robots/files/othex/othex.rotors.toml";

#[test]
fn the_json_of_a_robot_has_its_name_size_mass_and_diagnostics() {
    let done = wbqp(&["check", HUMANOID, "--json"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    let json = done.json();
    assert_eq!(json["kind"], "urdf");
    assert_eq!(json["name"], "humanoid");
    assert_eq!(json["nv"], 37);
    assert!((json["total_mass"].as_f64().unwrap() - 75.0).abs() < 1e-9);
    assert!(json["diagnostics"].is_array());
    assert!(json["errors"].as_array().unwrap().is_empty());
    assert_eq!(json["joints"].as_array().unwrap().len(), 31);
    let frames = json["frames"].as_array().unwrap();
    let sole = frames.iter().find(|f| f["name"] == "left_sole").unwrap();
    assert_eq!(sole["body"], "left_foot");
    let masses = json["bodies"].as_array().unwrap().iter();
    let sum: f64 = masses.map(|b| b["mass"].as_f64().unwrap()).sum();
    assert!((sum - 75.0).abs() < 1e-9);
    // Nothing says what carries it.
    assert_eq!(json["holding"]["means"], "nothing");
    let weight = json["holding"]["weight"].as_f64().unwrap();
    assert!((weight - 75.0 * 9.81).abs() < 1e-6);
    assert!(json["holding"]["efforts"].as_array().unwrap().is_empty());
}

#[test]
fn a_robot_of_a_thousand_joints_is_looked_at_and_its_memory_said() {
    let folder = Temporary::new("chain");
    let inertial = "<inertial><mass value='0.1'/><inertia ixx='1e-4' iyy='1e-4' izz='1e-4' ixy='0' ixz='0' iyz='0'/>\
                    </inertial>";
    let mut urdf = format!("<robot name='chain'><link name='l0'>{inertial}</link>");
    for k in 1..1000 {
        let before = k - 1;
        urdf += &format!(
            "<link name='l{k}'>{inertial}</link><joint name='j{k}' type='revolute'><parent link='l{before}'/>\
             <child link='l{k}'/><origin xyz='0 0 0.01'/><axis xyz='0 1 0'/>\
             <limit lower='-1' upper='1' velocity='5' effort='10'/></joint>"
        );
    }
    let file = folder.file("chain.urdf");
    fs::write(&file, urdf + "</robot>").unwrap();
    let done = wbqp(&["check", &file]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    assert!(done.stdout.contains(" needs about "));
    assert!(!done.stdout.contains("No controller can be made"));
}

#[test]
fn a_fixed_base_needs_gravity_compensation() {
    let done = wbqp(&["check", HUMANOID, "--base", "fixed", "--json"]);
    let json = done.json();
    assert_eq!(done.code, 0);
    assert_eq!(json["base"], "fixed");
    assert_eq!(json["nv"], 31);
    assert_eq!(json["holding"]["means"], "gravity_compensation");
    assert!(json["holding"]["missing"].as_array().unwrap().is_empty());
    // The legs hang straight from a fixed pelvis; a leaning head does not.
    let effort = |name: &str| -> f64 {
        let efforts = json["holding"]["efforts"].as_array().unwrap();
        let found = efforts.iter().find(|e| e["actuator"] == name).unwrap();
        found["effort"].as_f64().unwrap()
    };
    assert!(effort("waist_yaw").abs() < 1e-6);
    let of_text = wbqp(&["check", HUMANOID, "--base", "fixed"]);
    assert!(of_text.stdout.contains("fixed base, nv = 31 (31 joints)"));
    assert!(of_text.stdout.contains("gravity compensation"));
}

#[test]
fn rotors_carry_the_weight_at_home() {
    let done = wbqp(&["check", OTHEX, "--rotors", ROTORS, "--json"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    let json = done.json();
    assert_eq!(json["holding"]["means"], "hover");
    assert_eq!(json["nu"], 9);
    assert!(json["holding"]["missing"].as_array().unwrap().is_empty());
    let efforts = json["holding"]["efforts"].as_array().unwrap();
    let thrusts = efforts.iter().take(6);
    let sum: f64 = thrusts.map(|e| e["effort"].as_f64().unwrap()).sum();
    // The rotors are tilted by 35°, and one side carries an arm: they push more than the weight.
    let weight = json["holding"]["weight"].as_f64().unwrap();
    assert!(sum > weight && sum < 1.3 * weight, "{sum} of {weight}");
    for each in efforts.iter().take(6) {
        assert_eq!(each["limit"], 10.0);
        let share = each["effort"].as_f64().unwrap() / 10.0;
        assert!((each["share"].as_f64().unwrap() - share).abs() < 1e-12);
    }
}

#[test]
fn a_controller_with_contacts_stands() {
    for file in [
        "examples/scenarios/quadruped_stand.controller.toml",
        "examples/scenarios/quadruped_stand.toml",
    ] {
        let done = wbqp(&["check", file, "--json"]);
        assert_eq!(done.code, 0, "{}", done.stderr);
        let json = done.json();
        assert_eq!(json["holding"]["means"], "stand");
        assert_eq!(json["holding"]["first_tick"]["level"], "optimal");
        let contacts = json["holding"]["first_tick"]["contacts"]
            .as_array()
            .unwrap();
        let sum: f64 = contacts.iter().map(|c| c[1].as_f64().unwrap()).sum();
        let weight = json["holding"]["weight"].as_f64().unwrap();
        assert!((sum - weight).abs() < 0.05 * weight, "{sum} of {weight}");
        assert_eq!(json["controller"]["contacts"].as_array().unwrap().len(), 4);
    }
}

#[test]
fn values_are_put_into_the_file() {
    let file = "examples/scenarios/quadruped_stand.controller.toml";
    let rate = |arguments: &[&str]| wbqp(arguments).json()["controller"]["rate"].clone();
    assert_eq!(rate(&["check", file, "--json"]), 1000.0);
    let changed = ["check", file, "--json", "--set", "controller.rate=500"];
    assert_eq!(rate(&changed), 500.0);
    let done = wbqp(&["check", file, "--set", "task.nobody.kp=1"]);
    assert_eq!(done.code, 1);
    assert!(
        done.stderr.contains("no task has this name"),
        "{}",
        done.stderr
    );
    let done = wbqp(&["check", file, "--set", "duration=1"]);
    assert_eq!(done.code, 2, "{}", done.stderr);
}

#[test]
fn a_broken_robot_is_refused_with_its_line() {
    let folder = Temporary::new("broken");
    let urdf = fs::read_to_string(root().join(HUMANOID)).unwrap();
    let line = |text: &str, part: &str| 1 + text.lines().position(|l| l.contains(part)).unwrap();
    let joint = urdf
        .lines()
        .find(|l| l.contains("<joint name=\"left_knee\""))
        .unwrap();
    let broken = urdf.replacen(joint, &joint.replace("revolute", "hinge"), 1);
    let file = folder.file("broken.urdf");
    fs::write(&file, &broken).unwrap();
    let place = format!("broken.urdf:{}:", line(&broken, "left_knee"));
    let done = wbqp(&["check", &file]);
    assert_eq!(done.code, 1);
    assert!(
        done.stderr.contains(&place),
        "{} has no {place}",
        done.stderr
    );
    let done = wbqp(&["check", &file, "--json"]);
    assert_eq!(done.code, 1);
    let json = done.json();
    let first = json["errors"][0].as_str().unwrap();
    assert!(first.contains(&place), "{first}");
    assert_eq!(json["name"], Value::Null);
}

#[test]
fn every_mistake_of_a_controller_is_printed_with_its_place() {
    let file = "tests/fixtures/broken/controller/everything_at_once.toml";
    let done = wbqp(&["check", file]);
    assert_eq!(done.code, 1);
    let lines: Vec<&str> = done.stderr.lines().collect();
    assert!(lines.len() > 3, "{}", done.stderr);
    for line in lines {
        assert!(line.contains("everything_at_once.toml:"), "{line}");
    }
}

#[test]
fn other_files_are_told_apart() {
    let folder = Temporary::new("other");
    let refused = |name: &str, text: &str, expected: &str| {
        let file = folder.file(name);
        fs::write(&file, text).unwrap();
        let done = wbqp(&["check", &file]);
        assert_eq!(done.code, 1, "{name}");
        assert!(done.stderr.contains(expected), "{name}: {}", done.stderr);
    };
    refused("a.sdf", "<?xml version=\"1.0\"?><sdf/>", "SDF");
    refused("a.xml", "<mujoco/>", "MuJoCo");
    refused("a.txt", "hello", "neither a URDF");
    refused("a.toml", "[[rotor]]\nname = \"a\"", "neither a URDF");
    let done = wbqp(&["check", "nowhere.urdf"]);
    assert_eq!(done.code, 1);
    assert!(done.stderr.contains("nowhere.urdf: cannot be read"));
    assert_eq!(wbqp(&["check"]).code, 2);
    // A URDF under another name.
    let file = folder.file("robot.xml");
    fs::copy(root().join(HUMANOID), &file).unwrap();
    assert_eq!(wbqp(&["check", &file]).code, 0);
}

#[test]
fn the_long_form_of_a_short_file_says_the_same() {
    let folder = Temporary::new("expand");
    let short = "examples/scenarios/quadruped_short.controller.toml";
    let done = wbqp(&["check", short, "--expand"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    let long = folder.file("long.toml");
    fs::write(&long, &done.stdout).unwrap();
    let (a, b) = (
        wbqp(&["check", short, "--json"]),
        wbqp(&["check", &long, "--json"]),
    );
    assert_eq!(b.code, 0, "{}", b.stderr);
    assert_eq!(a.json()["holding"], b.json()["holding"]);
    // Nothing is left to say of the long one that matters.
    let implied = |file: &str| wbqp(&["check", file, "--explain-config"]).stdout;
    assert!(
        implied(short).contains("critically damped"),
        "{}",
        implied(short)
    );
    assert!(
        !implied(&long).contains("critically damped"),
        "{}",
        implied(&long)
    );
    assert_eq!(wbqp(&["check", HUMANOID, "--expand"]).code, 1);
}

#[test]
fn a_robot_can_be_named_by_an_option() {
    let folder = Temporary::new("urdf");
    let file = folder.file("stand.toml");
    let text = "[controller]\nrate = 500.0\n[robot]\nfile = \"elsewhere.urdf\"\n[[contact]]\n\
                frames = [\"left_sole\", \"right_sole\"]\nmotion = \"hard\"\nsize = [0.2, 0.1]\n\
                [[task]]\ntype = \"com\"\nkp = 50.0\n[[task]]\ntype = \"base_orientation\"\nkp = 50.0\n\
                [[task]]\ntype = \"posture\"\nkp = 30.0";
    fs::write(&file, text).unwrap();
    let done = wbqp(&["check", &file]);
    assert_eq!(done.code, 1);
    assert!(done.stderr.contains("elsewhere.urdf"), "{}", done.stderr);
    let done = wbqp(&["check", &file, "--urdf", HUMANOID, "--json"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    let json = done.json();
    assert_eq!(json["name"], "humanoid");
    assert_eq!(json["holding"]["means"], "stand");
}

#[test]
fn strict_mode_and_options_reach_the_loader() {
    let folder = Temporary::new("strict");
    let urdf = fs::read_to_string(root().join(HUMANOID)).unwrap();
    let joint = urdf
        .lines()
        .position(|l| l.contains("<joint name=\"left_knee\""))
        .unwrap();
    let limit = joint
        + urdf
            .lines()
            .skip(joint)
            .position(|l| l.contains("<limit"))
            .unwrap();
    let lines: Vec<String> = urdf.lines().map(str::to_owned).collect();
    let velocity = lines[limit].split("velocity=\"").nth(1).unwrap();
    let velocity = velocity.split('"').next().unwrap();
    let mut lax = lines.clone();
    lax[limit] = lines[limit].replace(&format!("velocity=\"{velocity}\""), "velocity=\"0\"");
    let file = folder.file("lax.urdf");
    fs::write(&file, lax.join("\n")).unwrap();
    let done = wbqp(&["check", &file, "--json"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    let json = done.json();
    let found = &json["diagnostics"][0];
    assert_eq!(found["severity"], "warning");
    for key in ["place", "element", "found", "done", "remedy"] {
        assert!(found[key].is_string(), "{key}");
    }
    assert!(
        found["place"].as_str().unwrap().contains("lax.urdf:"),
        "{found}"
    );
    assert!(
        found["element"].as_str().unwrap().contains("left_knee"),
        "{found}"
    );
    let text = wbqp(&["check", &file]).stdout;
    assert!(
        text.contains("Warnings (1)") && text.contains("left_knee"),
        "{text}"
    );
    let done = wbqp(&["check", &file, "--strict"]);
    assert_eq!(done.code, 1);
    assert!(done.stderr.contains("lax.urdf:"), "{}", done.stderr);
    // The option that the warning names cures it.
    let set = [
        "check",
        &file,
        "--json",
        "--set",
        "robot.options={velocity={left_knee=5.0}}",
    ];
    let done = wbqp(&set);
    assert!(
        done.json()["diagnostics"].as_array().unwrap().is_empty(),
        "{}",
        done.stdout
    );
}

/// Held level, a robot whose rotors all push upwards has no force sideways: it drifts, with an optimum in every tick.
#[test]
fn parallel_rotors_below_a_level_base_are_a_warning() {
    let folder = Temporary::new("leaning");
    let (urdf, output) = (fixture("quadrotor.urdf"), folder.file("new.toml"));
    let new = [
        "new",
        "--urdf",
        &urdf,
        "--kind",
        "multirotor",
        "--output",
        &output,
    ];
    // Rotors are assumed, which is status 1.
    assert_eq!(wbqp(&new).code, 1);
    let leaning = folder.file("new.toml");
    let text = fs::read_to_string(&leaning).unwrap();
    let follows = "reference = { type = \"thrust_attitude\" }\n";
    assert!(text.contains(follows), "{text}");
    let level = folder.file("level.toml");
    fs::write(&level, text.replace(follows, "")).unwrap();
    let told = "holds its attitude: level, the base drifts away";
    for (file, is_told) in [(&level, true), (&leaning, false)] {
        let done = wbqp(&["check", file]);
        assert_eq!(done.code, 0, "{}", done.stderr);
        assert_eq!(done.stdout.contains(told), is_told, "{}", done.stdout);
        assert!(done.stdout.contains("all rotors push along one direction"));
        let out = folder.file("out");
        let done = wbqp(&["run", file, "--duration", "0.1", "--out", &out]);
        assert_eq!(done.stderr.contains(told), is_told, "{}", done.stderr);
    }
    // Tilted ones push in every direction.
    let tilted = wbqp(&["check", OTHEX, "--rotors", ROTORS]);
    assert!(
        !tilted.stdout.contains("one direction"),
        "{}",
        tilted.stdout
    );
}

/// A share of the upper limit alone looks like room to both sides.
#[test]
fn rotors_near_their_lower_limits_are_said() {
    let folder = Temporary::new("idle");
    let rotors = fs::read_to_string(root().join(ROTORS)).unwrap();
    let idle = |min: &str| {
        let file = folder.file("idle.toml");
        let with_min = rotors
            .lines()
            .map(|line| match line.split_once("thrust = {") {
                Some(_) => format!("thrust = {{ min = {min}, max = 10.0 }}"),
                None => line.to_owned(),
            });
        fs::write(&file, with_min.collect::<Vec<_>>().join("\n")).unwrap();
        wbqp(&["check", OTHEX, "--rotors", &file]).stdout
    };
    let words = "above its lower limit of 5 N (";
    let told = idle("5.0");
    assert!(told.contains(words), "{told}");
    let told = idle("1.0");
    assert!(!told.contains("above its lower limit"), "{told}");
}

#[test]
fn a_controller_that_does_not_work_where_it_begins_fails() {
    let file = "examples/scenarios/quadruped_stand.controller.toml";
    for (change, words) in [
        // Nothing to stand on.
        ("contact.fl.active=false", "does not stand"),
        (
            "task.com.reference={type=\"hold\",value=[9.0,0.0,0.5]}",
            "more than `max_first_error",
        ),
    ] {
        let mut arguments = vec!["check", file, "--set", change];
        if words == "does not stand" {
            for foot in ["fr", "hl"] {
                let more = format!("contact.{foot}.active=false");
                arguments.extend(["--set", more.leak()]);
            }
        }
        let done = wbqp(&arguments);
        assert_eq!(done.code, 1, "{}{}", done.stdout, done.stderr);
        assert!(done.stderr.contains("error: "), "{}", done.stderr);
        assert!(
            done.stderr.contains(words),
            "{words}: {}{}",
            done.stdout,
            done.stderr
        );
    }
    // The controllers of the experiments work where their scenarios begin, which is not home.
    let done = wbqp(&["check", "examples/scenarios/push_and_slide.toml", "--json"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    let json = done.json();
    assert!(json["faults"].as_array().unwrap().is_empty());
    assert_eq!(
        json["holding"]["first_tick"]["place"],
        "where the case begins"
    );
    assert_eq!(
        wbqp(&["check", "examples/scenarios/push_and_slide.controller.toml"]).code,
        1
    );
}

/// Its first tick is optimal, and the arm falls.
#[test]
fn an_arm_that_no_task_holds_up_is_told() {
    let folder = Temporary::new("unheld");
    let urdf = concat!(
        r#"<robot name="arm"><link name="base"/><link name="rod"><inertial><origin xyz="0.3 0 0"/><mass value="2"/>"#,
        r#"<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>"#,
        r#"<joint name="elbow" type="revolute"><parent link="base"/><child link="rod"/><axis xyz="0 1 0"/>"#,
        r#"<limit lower="-1" upper="1" effort="50" velocity="3"/></joint></robot>"#,
    );
    fs::write(folder.file("arm.urdf"), urdf).unwrap();
    let controller = |tasks: &str| {
        let file = folder.file("arm.controller.toml");
        let text = format!(
            "[controller]\nrate = 500\n[robot]\nfile = \"arm.urdf\"\nbase = \"fixed\"\n{tasks}"
        );
        fs::write(&file, text).unwrap();
        wbqp(&["check", &file])
    };
    let posture = "[[task]]\ntype = \"posture\"\nkp = 50.0\n";
    for tasks in [
        "",
        &format!("{posture}weight = 0\n"),
        &format!("{posture}weight = 1\nactive = false\n"),
    ] {
        let done = controller(tasks);
        assert_eq!(done.code, 1, "{}", done.stdout);
        let words = "nothing holds it up at home: gravity asks -5.886 N·m of `elbow`";
        assert!(done.stderr.contains(words), "{}", done.stderr);
    }
    let done = controller(&format!("{posture}weight = 1\n"));
    assert_eq!((done.code, done.stderr.as_str()), (0, ""));
    // What an event switches on before the first tick acts in it.
    controller(&format!("{posture}weight = 1\nactive = false\n"));
    let scenario = folder.file("arm.toml");
    let text = "name = \"arm\"\ncontroller = \"arm.controller.toml\"\nduration = 1.0\n";
    let (event, case) = (
        "[[event]]\nat = 0.0\nactivate = [\"posture\"]\n",
        "[[case]]\nname = \"a\"\n",
    );
    fs::write(&scenario, [text, event, case].concat()).unwrap();
    assert_eq!(wbqp(&["check", &scenario]).code, 0);
    fs::write(&scenario, [text, case].concat()).unwrap();
    assert_eq!(wbqp(&["check", &scenario]).code, 1);
}

/// In the pin of a rod that may swing the force passes through the joint before it, whose motor gives nothing.
#[test]
fn an_arm_with_a_joint_without_a_motor_is_not_said_to_fall() {
    let folder = Temporary::new("swinging");
    let link = |name: &str| {
        format!(
            "<link name='{name}'><inertial><origin xyz='0.3 0 0'/><mass value='2'/><inertia ixx='0.1' ixy='0' ixz='0' \
             iyy='0.1' iyz='0' izz='0.1'/></inertial></link>"
        )
    };
    let joint = |name: &str, parent: &str, child: &str| {
        format!(
            "<joint name='{name}' type='revolute'><parent link='{parent}'/><child link='{child}'/><axis xyz='0 1 0'/>\
             <limit lower='-1' upper='1' effort='50' velocity='3'/></joint>"
        )
    };
    let urdf = [
        "<robot name='arm'><link name='base'/>".to_owned(),
        link("upper").replace("0.3", "0.0"),
        link("lower"),
        joint("shoulder", "base", "upper"),
        joint("elbow", "upper", "lower"),
        "</robot>".to_owned(),
    ];
    fs::write(folder.file("arm.urdf"), urdf.concat()).unwrap();
    let text = "[controller]\nrate = 500\n[robot]\nfile = \"arm.urdf\"\nbase = \"fixed\"\n\
                options = { passive = [\"elbow\"] }\n[[task]]\ntype = \"posture\"\njoints = [\"shoulder\"]\nkp = 30.0\n\
                weight = 1.0\n";
    let file = folder.file("arm.controller.toml");
    fs::write(&file, text).unwrap();
    let done = wbqp(&["check", &file]);
    assert_eq!(done.code, 0, "{}", done.stderr);
}

#[test]
fn where_frames_are_at_home_is_told() {
    let stand = "examples/scenarios/quadruped_stand.controller.toml";
    let done = wbqp(&["check", stand, "--frames"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    let (_, table) = done
        .stdout
        .split_once("Frames at home, in the world (m, rad)\n")
        .unwrap();
    let mut lines = table
        .lines()
        .map(|line| line.split_whitespace().collect::<Vec<_>>());
    assert_eq!(
        lines.next().unwrap(),
        ["frame", "x", "y", "z", "roll", "pitch", "yaw"]
    );
    let foot = lines
        .find(|words| words.first() == Some(&"fl_foot"))
        .unwrap();
    // It stands on the ground.
    assert_eq!(foot[3], "0.000");
    assert!(!wbqp(&["check", stand]).stdout.contains("Frames at home"));

    let json = wbqp(&["check", stand, "--json"]).json();
    let frames = json["frames"].as_array().unwrap();
    let found = frames.iter().find(|f| f["name"] == "fl_foot").unwrap();
    for (word, number) in foot[1..4].iter().zip(found["position"].as_array().unwrap()) {
        let told: f64 = word.parse().unwrap();
        assert!((told - number.as_f64().unwrap()).abs() < 6e-4, "{found}");
    }
    assert_eq!(found["rpy"].as_array().unwrap().len(), 3);
}

#[test]
fn a_controller_for_somewhere_else_is_told_to_have_a_scenario() {
    let done = wbqp(&["check", "examples/scenarios/push_away.controller.toml"]);
    assert_eq!(done.code, 1);
    assert!(
        done.stderr.contains(
            "; if the robot begins elsewhere, check the scenario whose [initial] says where"
        ),
        "{}",
        done.stderr
    );
    let done = wbqp(&["check", "examples/scenarios/push_away.toml"]);
    assert_eq!(done.code, 0, "{}", done.stderr);
}

/// Nothing else says where an arm is than its file: a surface that is elsewhere is no slip of all contacts.
#[test]
fn a_contact_of_a_fixed_robot_that_is_off_its_surface_is_told() {
    let folder = Temporary::new("off_surface");
    let file = folder.file("arm.controller.toml");
    let robot = root().join(HUMANOID).display().to_string();
    let text = |height: f64| {
        format!(
            "[controller]\nrate = 500.0\n[robot]\nfile = {robot:?}\noptions = {{ base = \"fixed\" }}\n[[contact]]\n\
             frame = \"left_sole\"\nmotion = \"hard\"\nsurface = {{ origin = [0.0, 0.0, {height:?}] }}\n[[task]]\n\
             type = \"posture\"\nkp = 30.0\n"
        )
    };
    fs::write(&file, text(-5.0)).unwrap();
    let done = wbqp(&["check", &file]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    let told = |done: &crate::common::Done| {
        let mut lines = done.stdout.lines();
        lines.any(|line| {
            line.contains("`left_sole` is ")
                && line.contains(" m above its surface at home: it does not")
        })
    };
    assert!(told(&done), "{}", done.stdout);
    fs::write(&file, text(5.0)).unwrap();
    assert!(!told(&wbqp(&["check", &file])));
}
