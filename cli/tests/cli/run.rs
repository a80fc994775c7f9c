//! `wbqp run`: logs, figures, summary, exit codes.

use std::{fs, path::Path};

use wbqp::serde_json::{self, Value};
use wbqp_measures::Recording;

use crate::common::{Temporary, fixture, root, wbqp};

const QUADRUPED: &str = "examples/scenarios/quadruped_stand.toml";

fn summary(folder: &Path) -> Value {
    let text = fs::read_to_string(folder.join("summary.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

#[test]
fn a_legged_scenario_leaves_a_log_figures_and_a_summary() {
    let out = Temporary::new("run");
    let done = wbqp(&[
        "run",
        QUADRUPED,
        "--set",
        "change.duration=0.5",
        "--set",
        "change.event=[]",
        "--set",
        "task.com.kp=80",
        "--out",
        &out.0.display().to_string(),
    ]);
    assert_eq!(done.code, 0, "{}", done.stderr);
    assert!(
        done.stdout.contains("stand: ran to its end"),
        "{}",
        done.stdout
    );
    let folder = out.0.join("quadruped_stand");
    for file in ["motion", "tasks", "efforts", "contacts"] {
        let svg = fs::read_to_string(folder.join(format!("stand.{file}.svg"))).unwrap();
        assert!(svg.contains("<svg") && svg.contains("polyline"), "{file}");
    }
    let log = wbqp_measures::log::Log::open(&folder.join("stand.mcap")).unwrap();
    assert!((log.end() - 0.499).abs() < 1e-9);
    let varied = log.attachment("variation.toml").unwrap();
    let varied = std::str::from_utf8(varied).unwrap();
    assert!(varied.contains("kp = 80"), "{varied}");
    let case = &summary(&folder)[0];
    assert_eq!(case["ticks"], 500);
    assert_eq!(case["not_optimal"], 0);
    assert_eq!(case["worst_level"], "optimal");
    let com = &case["tasks"][0];
    assert_eq!((&com["name"], &com["unit"]), (&"com".into(), &"m".into()));
    assert!(com["end"].as_f64().unwrap() < 2e-3);
    let share = case["efforts"][2]["share"].as_f64().unwrap();
    assert!(share > 0.2 && share < 0.4, "{share}");
    assert_eq!(case["contacts"][0]["on"], 1.0);
}

#[test]
fn a_controller_runs_on_ground_of_its_own() {
    let out = Temporary::new("default");
    let directory = out.0.display().to_string();
    for (name, duration) in [("quadruped_stand", "0.5"), ("humanoid_stand", "0.3")] {
        let done = wbqp(&[
            "run",
            &format!("examples/scenarios/{name}.controller.toml"),
            "--duration",
            duration,
            "--out",
            &directory,
        ]);
        assert_eq!(done.code, 0, "{}", done.stderr);
        let case = &summary(&out.0.join(format!("{name}.controller")))[0];
        assert_eq!(case["not_optimal"], 0);
        // It stands: the contacts bear it, and the centre of mass stays where it is.
        assert!(case["contacts"][0]["peak_real"].as_f64().unwrap() > 1.0);
        assert!(case["tasks"][0]["peak"].as_f64().unwrap() < 2e-3);
    }
}

#[test]
fn a_run_that_diverges_fails() {
    let out = Temporary::new("diverges");
    // Nothing is there to stand on.
    let done = wbqp(&[
        "run",
        QUADRUPED,
        "--set",
        "change.duration=20",
        "--set",
        "change.plant.contact_point=[]",
        "--set",
        "change.event=[]",
        "--set",
        "change.plant.mismatch.mass_scale=1e-9",
        "--out",
        &out.0.display().to_string(),
    ]);
    assert_eq!(done.code, 1, "{}{}", done.stdout, done.stderr);
    assert!(
        done.stdout.contains("DIVERGED") && done.stdout.contains(" s: "),
        "{}{}",
        done.stdout,
        done.stderr
    );
}

/// Falling freely, every tick has an optimum or a fallback, and the run goes on to its end.
#[test]
fn a_robot_that_ends_nowhere_near_its_reference_is_told() {
    let out = Temporary::new("falls");
    let folder = out.0.display().to_string();
    let mut arguments = vec!["run", QUADRUPED, "--out", &folder];
    for change in ["duration=1.5", "plant.contact_point=[]", "event=[]"] {
        arguments.extend(["--set", change]);
    }
    let arguments: Vec<String> = arguments
        .into_iter()
        .map(|a| {
            if a.contains('=') {
                format!("change.{a}")
            } else {
                a.to_owned()
            }
        })
        .collect();
    let done = wbqp(&arguments);
    assert!(
        done.stdout.contains("ATTENTION: `") && done.stdout.contains("from its reference"),
        "{}{}",
        done.stdout,
        done.stderr
    );
    let case = &summary(&out.0.join("quadruped_stand"))[0];
    assert!(!case["attention"].as_array().unwrap().is_empty());
    let stands = wbqp(&[
        "run",
        QUADRUPED,
        "--set",
        "change.duration=0.2",
        "--out",
        &folder,
    ]);
    assert!(!stands.stdout.contains("ATTENTION"), "{}", stands.stdout);
}

/// Kicked over: its centre of mass is less than a metre from its reference.
#[test]
fn a_robot_that_lies_on_the_ground_is_told() {
    let out = Temporary::new("lies");
    let folder = out.0.display().to_string();
    let mut arguments = vec!["run", QUADRUPED, "--out", &folder];
    for change in [
        "change.duration=0.75",
        "change.event=[]",
        "change.plant.disturbance=[{name=\"kick\",frame=\"trunk\",force=[0.0,30.0,0.0],from=0.1,until=0.3}]",
    ] {
        arguments.extend(["--set", change]);
    }
    let done = wbqp(&arguments);
    assert_eq!(done.code, 0, "{}", done.stderr);
    let case = &summary(&out.0.join("quadruped_stand"))[0];
    assert!(case["tasks"][0]["end"].as_f64().unwrap() < 1.0);
    let told = case["attention"].as_array().unwrap();
    let told: Vec<&str> = told.iter().filter_map(Value::as_str).collect();
    let mut words = vec!["`com` ended", "the base ended leaning by"];
    // Every last digit makes it another fall, with more or less than half of the ticks without an optimum.
    let [without, ticks] = ["not_optimal", "ticks"].map(|key| case[key].as_f64().unwrap());
    if without > 0.5 * ticks {
        words.push("of the ticks had no optimum");
    }
    assert_eq!(told.len(), words.len(), "{told:?}");
    for (told, words) in told.iter().zip(words) {
        assert!(told.contains(words), "{told}");
        assert!(done.stdout.contains(&format!("ATTENTION: {told}")));
    }
}

/// No speed is plausible, so no tick has an optimum.
#[test]
fn ticks_without_an_optimum_are_told() {
    let out = Temporary::new("without");
    let folder = out.0.display().to_string();
    let mut arguments = vec!["run", QUADRUPED, "--out", &folder];
    for change in [
        "change.duration=0.1",
        "change.event=[]",
        "measurement.max_joint_velocity=1e-6",
    ] {
        arguments.extend(["--set", change]);
    }
    let done = wbqp(&arguments);
    let words = "ATTENTION: 100 % of the ticks had no optimum";
    assert!(done.stdout.contains(words), "{}", done.stdout);
}

/// A detector that waits for more than there is, and a surface that is turned round.
#[test]
fn a_contact_that_hardly_ever_is_on_is_told() {
    let out = Temporary::new("seldom");
    let folder = out.0.display().to_string();
    for (change, words) in [
        (
            "change.detector=[{contact=\"tip\",on=100.0}]",
            "and was on for 0 %: its [[detector]] waits for 100 N",
        ),
        (
            "contact.tip.surface={normal=[1.0,0.0,0.0],x_axis=[0.0,0.0,1.0]}",
            "contact `tip` was pressed from behind, with up to ",
        ),
    ] {
        let scenario = "examples/scenarios/push_with_disturbance.toml";
        let arguments = ["run", scenario, "--case", "no_ft", "--out", &folder];
        let done = wbqp(&[&arguments[..], &["--set", change]].concat());
        assert!(
            done.stdout.contains(words),
            "{}{}",
            done.stdout,
            done.stderr
        );
    }
}

/// Nothing switches it on; or other tasks pull against its force.
#[test]
fn a_contact_that_is_not_pushed_as_wanted_is_told() {
    let out = Temporary::new("wanted");
    let folder = out.0.display().to_string();
    for (case, change, words) in [
        (
            "with_ft",
            "change.detector=[]",
            "N, and was never on: let a [[detector]]",
        ),
        (
            "no_ft",
            "task.contact_force.weight=[1e-3,1e-3,1e-5]",
            "N over the last tenth of the run, and its force task wants 5 N",
        ),
    ] {
        let scenario = "examples/scenarios/push_with_disturbance.toml";
        let arguments = ["run", scenario, "--case", case, "--out", &folder];
        let done = wbqp(&[&arguments[..], &["--set", change]].concat());
        let lines = done.stdout.lines();
        let told = lines.filter(|line| line.contains("ATTENTION: contact `tip`"));
        let told: Vec<&str> = told.collect();
        assert!(
            matches!(told.as_slice(), [line] if line.contains(words)),
            "{}{}",
            done.stdout,
            done.stderr
        );
    }
}

/// On from the beginning, the contact is counted on while the robot is still on its way.
#[test]
fn a_contact_that_is_on_in_the_air_is_told() {
    let out = Temporary::new("air");
    let folder = out.0.display().to_string();
    let approach = "follow={base_position={type=\"min_jerk\",to=[-0.0688,0.0,1.258],duration=6.0}}";
    let events =
        format!("change.event=[{{at=0.0,activate_contact=[\"tip\"]}},{{at=1.0,{approach}}}]");
    let scenario = "examples/scenarios/push_with_disturbance.toml";
    let done = wbqp(&[
        "run",
        scenario,
        "--case",
        "with_ft",
        "--set",
        &events,
        "--set",
        "change.detector=[]",
        "--set",
        "change.duration=10.0",
        "--out",
        &folder,
    ]);
    let words = "ATTENTION: contact `tip` was on for ";
    let line = done.stdout.lines().find(|line| line.contains(words));
    let line = line.unwrap_or_else(|| panic!("{}{}", done.stdout, done.stderr));
    assert!(line.contains("s in which nothing was there"), "{line}");
}

/// A touch of which nothing is wrong, however short beside the run.
#[test]
fn a_short_touch_is_nothing_to_look_at() {
    let out = Temporary::new("short");
    let folder = out.0.display().to_string();
    let scenario = "examples/scenarios/push_with_disturbance.toml";
    let done = wbqp(&["run", scenario, "--case", "with_ft", "--out", &folder]);
    assert!(!done.stdout.contains("ATTENTION"), "{}", done.stdout);
    let case = &summary(&out.0.join("push_with_disturbance"))[0];
    let contact = &case["contacts"][0];
    let share = |key: &str| contact[key].as_f64().unwrap();
    assert!(share("touched") > 0.0 && share("on") > 0.5 * share("touched"));
}

/// As in a corner, with a wall and the ground: the plant has the point once.
#[test]
fn two_contacts_at_one_place_stand_on_the_default_plant() {
    let out = Temporary::new("corner");
    let text = std::fs::read_to_string("../examples/scenarios/quadruped_short.controller.toml");
    let text =
        text.unwrap() + "[[contact]]\nframe = \"fl_foot\"\nname = \"again\"\nmotion = \"soft\"\n";
    let file = out.file("corner.toml");
    std::fs::write(&file, text).unwrap();
    let folder = out.file("out");
    let done = wbqp(&["run", &file, "--duration", "0.1", "--out", &folder]);
    assert_eq!(done.code, 0, "{}{}", done.stdout, done.stderr);
}

#[test]
fn a_contact_that_never_touches_is_told() {
    let out = Temporary::new("untouched");
    let folder = out.0.display().to_string();
    let told = |change: &str| {
        let done = wbqp(&[
            "run",
            QUADRUPED,
            "--set",
            "change.duration=0.1",
            "--set",
            "change.event=[]",
            "--set",
            change,
            "--out",
            &folder,
        ]);
        assert_eq!(done.code, 0, "{}", done.stderr);
        let start = "  ATTENTION: contact `fl` ";
        let line = done.stdout.lines().find(|line| line.starts_with(start));
        line.map(str::to_owned)
    };
    assert_eq!(told("change.plant.command_delay=1"), None);
    assert_eq!(
        told("change.plant.contact_point=[]").as_deref(),
        Some(
            "  ATTENTION: contact `fl` was on for 100 % of the run and never touched anything: the plant has \
             no [[plant.contact_point]] with frame = \"fl_foot\""
        )
    );
    assert_eq!(
        told("change.plant.wall.ground.point=[0.0,0.0,-9.0]").as_deref(),
        Some(
            "  ATTENTION: contact `fl` was on for 100 % of the run and never touched anything: frame \
             `fl_foot` did not come to a [[plant.wall]]; is the wall where it goes?"
        )
    );
    // One that is off, and waits for a touch that never comes.
    let done = wbqp(&[
        "run",
        "examples/scenarios/push_away.toml",
        "--set",
        "change.duration=0.1",
        "--set",
        "change.event=[]",
        "--out",
        &folder,
    ]);
    assert!(
        done.stdout
            .contains("ATTENTION: contact `tip` has a [[detector]] and never touched anything: "),
        "{}{}",
        done.stdout,
        done.stderr
    );
}

#[test]
fn every_line_of_an_error_is_there_once() {
    let done = wbqp(&["run", QUADRUPED, "--set", "change.plant.step=0.1"]);
    assert_eq!(done.code, 1);
    let lines: Vec<&str> = done.stderr.lines().collect();
    assert!(lines.len() > 1, "{}", done.stderr);
    assert!(
        lines.iter().all(|line| line.starts_with("error: ")),
        "{}",
        done.stderr
    );
    assert_eq!(
        done.stderr.matches("must be positive and at most").count(),
        1
    );
}

#[test]
fn a_run_of_no_tick_is_refused() {
    let stand = "examples/scenarios/quadruped_stand.controller.toml";
    let done = wbqp(&["run", stand, "--duration", "1e-9"]);
    assert_eq!(done.code, 1);
    assert!(
        done.stderr.contains(
            "with the default plant: duration: is 0.000000001 s, shorter than a control period"
        ),
        "{}",
        done.stderr
    );
    let done = wbqp(&["run", stand, "--duration", "-1"]);
    assert_eq!(done.code, 1, "{}", done.stderr);
    assert!(done.stderr.contains("duration: "), "{}", done.stderr);
    assert_eq!(wbqp(&["tick-stats", "--ticks", "0"]).code, 2);
    let done = wbqp(&["tick-stats", "--ticks", "1", "--solver", "nope"]);
    assert_eq!(done.code, 1);
    assert!(done.stderr.contains("--solver"), "{}", done.stderr);
    assert_eq!(wbqp(&["campaign", "plan.toml", "--limit", "0"]).code, 2);
}

#[test]
fn warnings_of_the_loader_come_before_a_run_once() {
    let out = Temporary::new("warned");
    let folder = out.0.display().to_string();
    let stand = "examples/scenarios/quadruped_stand.controller.toml";
    let run = ["run", stand, "--duration", "0.01", "--out", &folder];
    let quiet = wbqp(&run);
    assert!(!quiet.stderr.contains("warning"), "{}", quiet.stderr);
    let done = wbqp(&[&run[..], &["--set", "task.com.kp=1e9"]].concat());
    assert_eq!(done.stderr.matches("warning").count(), 1, "{}", done.stderr);
    // What is the same of several joints, once.
    let urdf = fs::read_to_string(root().join("robots/files/quadruped/quadruped.urdf")).unwrap();
    let file = out.file("quadruped.urdf");
    let (limit, none) = (r#"effort="2.7""#, r#"effort="0""#);
    assert_eq!(urdf.matches(limit).count(), 12);
    fs::write(&file, urdf.replace(limit, none)).unwrap();
    let stand = out.file("stand.toml");
    let new = [
        "new",
        "--urdf",
        &file,
        "--kind",
        "quadruped",
        "--output",
        &stand,
    ];
    assert_eq!(wbqp(&new).code, 0);
    let done = wbqp(&["run", &stand, "--duration", "0.01", "--out", &folder]);
    let more = "  and 11 more of this kind: `wbqp check` lists them\n";
    assert!(done.stderr.contains(more), "{}", done.stderr);
    assert_eq!(done.stderr.matches("warning").count(), 1, "{}", done.stderr);
}

#[test]
fn what_is_not_there_is_refused_with_a_hint() {
    let refused = |arguments: &[&str], expected: &str| {
        let done = wbqp(arguments);
        assert_eq!(done.code, 1, "{}", done.stderr);
        assert!(done.stderr.contains(expected), "{}", done.stderr);
    };
    refused(
        &["run", QUADRUPED, "--case", "stnad"],
        "did you mean `stand`",
    );
    refused(&["run", QUADRUPED, "--duration", "1"], "change.duration");
    // What the log calls the times of the disturbance `aside`.
    let event = "change.event=[{at=1.0,mark=\"aside_start\"}]";
    refused(&["run", QUADRUPED, "--set", event], "under this mark");
    refused(&["run", "robots/files/othex/othex.urdf"], "wbqp new");
    refused(
        &["run", QUADRUPED, "--set", "change.plant.walls=1"],
        "unknown key `walls`; did you mean `wall`?",
    );
}

/// While nobody knows the base: why, what really pushes, and what a force is compared with that no sensor measures.
#[test]
fn an_outage_is_told_and_what_really_pushes_is_logged() {
    let out = Temporary::new("outage");
    let folder = out.0.display().to_string();
    let outage = "change.sensors.outage=[{sensor=\"base\",from=0.1,until=0.25,reads=\"nan\"}]";
    let scenario = "examples/scenarios/humanoid_stand.toml";
    let mut arguments = vec!["run", scenario, "--out", &folder];
    for change in ["change.duration=0.4", "change.event=[]", outage] {
        arguments.extend(["--set", change]);
    }
    let done = wbqp(&[&arguments[..], &["--set", "change.plant.disturbance=[]"]].concat());
    for words in [
        "150 not optimal (20 extrapolated, 130 safe)",
        "the first of these at 0.100 s: extrapolated: measurement not finite: base position",
        "force_left (planned) ",
    ] {
        let text = &done.stdout;
        assert!(text.contains(words), "{words}: {text}{}", done.stderr);
    }
    let folder = out.0.join("humanoid_stand");
    let log = wbqp_measures::log::Log::open(&folder.join("stand.mcap")).unwrap();
    let real = log.series("/contact/left", "/truth/z").unwrap();
    assert_eq!(real.len(), 400);
    let planned = log.series("/contact/left", "/solution/z").unwrap();
    assert_eq!(planned.samples().count(), 250);
    let svg = fs::read_to_string(folder.join("stand.contacts.svg")).unwrap();
    assert!(svg.contains("no solution") && !svg.contains("disturbance"));
    let case = &summary(&folder)[0];
    assert_eq!(case["first_not_optimal"]["time"], 0.1);
    assert_eq!(case["tasks"][4]["of"], "planned");
    assert_eq!(case["tasks"][0]["of"], "measured");
    assert!(case["tasks"][4]["end"].as_f64().unwrap() < 50.0, "{case}");
    let dump = folder.join("stand.2.tick.toml").display().to_string();
    let told = wbqp(&["replay", &dump]).stdout;
    for words in [
        "no problem was built in this tick",
        "command of the fallback law `damped_hover`",
    ] {
        assert!(told.contains(words), "{told}");
    }
}

/// A sensor that is not there says zero, and the integral of it asks for more than the set point.
#[test]
fn feedback_of_a_force_that_nobody_measures_is_told() {
    let out = Temporary::new("fed");
    let folder = out.0.display().to_string();
    let scenario = "examples/scenarios/push_with_disturbance.toml";
    let words =
        "ATTENTION: the force task of contact `tip` feeds back a force that nobody measures";
    for (case, is_told) in [("with_ft", true), ("no_ft", false)] {
        let mut arguments = vec!["run", scenario, "--case", case, "--out", &folder];
        for change in [
            "contact.tip.active=true",
            "change.detector=[]",
            "change.sensors.force_torque=[]",
            "change.event=[]",
            "change.plant.disturbance=[]",
            "change.duration=0.1",
        ] {
            arguments.extend(["--set", change]);
        }
        let done = wbqp(&arguments);
        assert_eq!(done.stdout.contains(words), is_told, "{}", done.stdout);
    }
}

/// Of metres and radians together nothing could be said.
#[test]
fn a_pose_is_told_by_its_position_and_its_orientation() {
    let out = Temporary::new("pose");
    let (arm, folder) = (out.file("arm.toml"), out.0.display().to_string());
    let urdf = fixture("arm.urdf");
    let new = ["new", "--urdf", &urdf, "--kind", "arm", "--output", &arm];
    assert_eq!(wbqp(&new).code, 0);
    let away = "task.tool0_frame_pose.position={type=\"hold\",value=[9.0,9.0,9.0]}";
    let run = ["run", &arm, "--duration", "0.05", "--out", &folder];
    let far = [
        "--set",
        "controller.max_first_error.position=inf",
        "--set",
        away,
    ];
    let done = wbqp(&[&run[..], &far].concat());
    let case = &summary(&out.0.join("arm"))[0];
    let tasks = case["tasks"].as_array().unwrap();
    let pose = |k: usize| (&tasks[k]["name"], &tasks[k]["unit"], &tasks[k]["rows"]);
    let name = &"tool0_frame_pose".into();
    assert_eq!(pose(0), (name, &"m".into(), &3.into()));
    assert_eq!(pose(1), (name, &"rad".into(), &3.into()));
    let text = &done.stdout;
    assert!(
        text.contains("ATTENTION: `tool0_frame_pose` ended 1"),
        "{text}{}",
        done.stderr
    );
}
