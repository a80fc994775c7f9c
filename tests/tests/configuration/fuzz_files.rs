//! No file makes loading panic, whatever is in it: junk and changed files, from seeds. What loads is bound to its robot
//! and ticks.
//!
//! The suite runs a few seconds' worth.
//! `WBQP_FUZZ_CASES=1000000 cargo test --release -p wbqp-tests --test configuration fuzz_files -- --nocapture
//! --test-threads 1` runs a million; `WBQP_FUZZ_SEED` chooses others.

use std::{
    env, fs,
    panic::{AssertUnwindSafe, catch_unwind},
    path::Path,
    time::{Duration, Instant},
};

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use wbqp::{
    ControllerConfig, Measurement,
    controller::Controller,
    robot::{RobotError, RobotModel, SourceFile},
    settings::{Hover, Settings},
};
use wbqp_robots::{BaseKind, Options, Othex, from_sources};
use wbqp_sim::Scenario;
use wbqp_tasks as _;
use wbqp_tests::{
    files::{self, Temporary, texts, workspace},
    mutation::{junk, mutated},
};

/// No case may take longer, s: a loader that hangs is as bad as one that panics.
const SLOWEST: f64 = 20.0;

fn number(variable: &str, default: u64) -> u64 {
    let given = env::var(variable).ok();
    given.map_or(default, |text| text.parse().expect("is a number"))
}

/// Cases of a target that has a share of a million; never fewer than `least`.
fn cases(share: u64, least: u64) -> u64 {
    (number("WBQP_FUZZ_CASES", 0) * share / 1_000_000).max(least)
}

/// Texts of a folder's files whose name ends so.
fn corpus(folder: &str, end: &str) -> Vec<String> {
    let texts = texts(folder, end).into_iter();
    texts.map(|(_, text)| text).collect()
}

/// What became of a file.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Outcome {
    Refused,
    /// Read, but it does not fit the robot.
    Misfit,
    Accepted,
}

/// Feeds a target with cases; panics and slow cases are reported with the text that caused them.
fn fuzz(name: &str, cases: u64, corpus: &[String], target: impl Fn(&str) -> Outcome) {
    let seed = number("WBQP_FUZZ_SEED", 1);
    let begin = Instant::now();
    let mut counts = [0_u64; 3];
    let mut slowest = (Duration::ZERO, String::new());
    let mut panics = Vec::new();
    for case in 0..cases {
        // A generator per case: any of them can be repeated alone.
        let mut rng = ChaCha8Rng::seed_from_u64(seed << 40 | case);
        let text = if rng.random_range(0..20) == 0 {
            junk(&mut rng)
        } else {
            let one = rng.random_range(0..corpus.len());
            let other = rng.random_range(0..corpus.len());
            mutated(&corpus[one], &corpus[other], &mut rng)
        };
        let start = Instant::now();
        match catch_unwind(AssertUnwindSafe(|| target(&text))) {
            Ok(outcome) => counts[outcome as usize] += 1,
            Err(_) => panics.push(format!("{name}, seed {seed}, case {case}:\n{text}")),
        }
        let took = start.elapsed();
        if took > slowest.0 {
            slowest = (took, text);
        }
    }
    let [refused, misfit, accepted] = counts;
    println!(
        "{name}: {cases} cases in {:.1} s, {refused} refused, {misfit} do not fit the robot, {accepted} accepted, \
         {} panics, slowest {:.1} ms{}",
        begin.elapsed().as_secs_f64(),
        panics.len(),
        slowest.0.as_secs_f64() * 1e3,
        peak_memory(),
    );
    if env::var_os("WBQP_FUZZ_SHOW").is_some() {
        println!("slowest:\n{}", slowest.1);
    }
    panics.truncate(10);
    assert!(panics.is_empty(), "{}", panics.join("\n----\n"));
    assert!(slowest.0.as_secs_f64() < SLOWEST, "{}", slowest.1);
    assert!(refused > 0 && accepted > 0, "the cases are too much alike");
}

/// Largest memory of the process, where the system says it.
fn peak_memory() -> String {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    peak.map_or_else(String::new, |peak| {
        format!(", peak memory of the process {}", peak.trim())
    })
}

fn controller(text: &str, folder: &Path) -> Outcome {
    let config = match ControllerConfig::from_str(text, "x.toml", folder) {
        Ok(config) => config,
        Err(errors) => {
            assert!(errors.iter().all(|error| !error.message.is_empty()));
            assert!(!errors.to_string().contains("internal error"), "{errors}");
            return Outcome::Refused;
        }
    };
    if let Ok(saved) = config.to_toml() {
        let again = ControllerConfig::from_str(&saved, "saved.toml", folder);
        again.unwrap_or_else(|errors| panic!("what was saved is refused: {errors}\n{saved}"));
    }
    match Controller::new(config) {
        Err(error) => {
            let message = error.to_string();
            assert!(message.starts_with("x.toml"), "{message}");
            Outcome::Misfit
        }
        Ok(controller) => ticks(controller),
    }
}

/// A controller that is made can be used.
fn ticks(mut controller: Controller) -> Outcome {
    let contacts = controller.report().contacts.len();
    let measurement = Measurement::home(controller.robot(), contacts);
    let (command, _) = controller.tick(&measurement);
    assert!(command.effort.iter().all(|u| u.is_finite()));
    Outcome::Accepted
}

#[test]
fn controllers() {
    let folder = workspace("tests/fixtures/broken/controller");
    let mut good = corpus("examples/scenarios", ".controller.toml");
    good.push(QUADRUPED.to_owned());
    // Mistakes on top of mistakes are a third.
    let mut texts = corpus("tests/fixtures/broken/controller", ".toml");
    let times = 2 * texts.len() / good.len();
    texts.extend(std::iter::repeat_n(good, times).flatten());
    fuzz("controller", cases(700_000, 3000), &texts, |text| {
        controller(text, &folder)
    });
}

/// A robot from a file, and what the shipped controllers do not have.
const QUADRUPED: &str = r#"[controller]
rate = 500
formulation = "explicit"

[robot]
type = "urdf"
file = "../../robots/quadruped.urdf"
options.base = "floating"
options.servo = ["fl_knee"]
options.home = { fl_knee = 0.1 }

[[contact]]
name = "fl"
frame = "fl_foot"
kind = "normal"
surface = { normal = [0, 0, 1], x_axis = [1, 0, 0] }
active = true

[[task]]
name = "posture"
type = "posture"
weight = [1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1]
kp = 10
kd = 3
reference = { type = "waypoints", points = [{ at = 1, value = [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0] }] }

[[task]]
name = "slide"
type = "free_motion"
contact = "fl"
weight = 1
kp = 10
kd = 3

[[constraint]]
name = "cone"
type = "friction_pyramid"
contact = "fl"
sides = 8

[[constraint]]
name = "still"
type = "contact_motion"
contact = "fl"
"#;

#[test]
fn scenarios() {
    let folder = files::scenarios();
    let texts: Vec<String> = corpus("examples/scenarios", ".toml")
        .into_iter()
        .filter(|text| text.contains("[[case]]"))
        .collect();
    fuzz(
        "scenario",
        cases(50_000, 100),
        &texts,
        |text| match Scenario::from_text(text, "s.toml", &folder) {
            Ok(_) => Outcome::Accepted,
            Err(error) => {
                assert!(!error.to_string().is_empty());
                Outcome::Refused
            }
        },
    );
}

fn source(name: &str, contents: &str) -> SourceFile {
    SourceFile {
        name: name.to_owned(),
        contents: contents.to_owned(),
    }
}

#[test]
fn urdf() {
    let mut texts = corpus("tests/fixtures/robots", ".urdf");
    texts.extend(corpus("robots/files/othex", ".urdf"));
    fuzz("URDF", cases(130_000, 600), &texts, |text| {
        // A fixed base needs no inertia of its root: other checks are reached.
        let base = [BaseKind::Floating, BaseKind::Fixed][text.len() % 2];
        let options = Options {
            base,
            ..Options::default()
        };
        robot(from_sources(source("r.urdf", text), None, &options))
    });
}

#[test]
fn rotor_parameter_files() {
    let urdf = &corpus("robots/files/othex", ".urdf")[0];
    let texts = corpus("robots/files/othex", ".rotors.toml");
    fuzz(
        "rotor parameter file",
        cases(120_000, 600),
        &texts,
        |text| {
            let rotors = source("r.rotors.toml", text);
            let options = Options::default();
            robot(from_sources(source("r.urdf", urdf), Some(rotors), &options))
        },
    );
}

/// A robot that was accepted can be controlled.
fn robot(loaded: Result<RobotModel, RobotError>) -> Outcome {
    let Ok(robot) = loaded else {
        return Outcome::Refused;
    };
    let any = Box::new(Othex::default());
    // Most of these robots fall.
    let settings = Settings {
        hover: Hover::Unchecked,
        ..Settings::at_rate(250.0)
    };
    let config = ControllerConfig::new(settings, any);
    match Controller::with_robot(config, robot) {
        Err(_) => Outcome::Misfit,
        Ok(controller) => ticks(controller),
    }
}

#[test]
fn files_that_are_no_text() {
    let folder = Temporary::new("fuzz");
    let path = folder.file("x.toml");
    for bytes in [&b"\xff\xfe"[..], b"[controller]\nrate = \"\xc3\"", b"\0\0"] {
        fs::write(&path, bytes).expect("can be written");
        ControllerConfig::from_file(&path).expect_err("is refused");
        Scenario::from_file(&path).expect_err("is refused");
    }
    // A folder is no file.
    ControllerConfig::from_file(folder.path()).expect_err("is refused");
}
