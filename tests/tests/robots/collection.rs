//! The 69 URDFs of the PyPI package `example-robot-data`: arms, hands, quadrupeds, humanoids and multirotors as their
//! makers describe them. All load but those named here, their dynamics are Pinocchio's to 1e-9, a controller runs on
//! each, and strict mode refuses what it always refused.
//!
//! The package and Pinocchio's figures are made by `oracles/robot_collection.py`; without them these tests say so and
//! pass, unless `WBQP_REQUIRE_ORACLES` is set, as it is in `.ci/run`.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

use serde_json::Value;
use wbqp::{
    Controller, ControllerConfig, Measurement,
    controller::FallbackLevel,
    qp::Status,
    robot::{RobotError, RobotModel},
};
use wbqp_robots::{BaseKind, Options, from_files};
use wbqp_tasks as _;
use wbqp_tests::{
    collection::{self, FILES, label},
    files::workspace,
    oracle::{Comparison, Worst, list},
    robots_page::{Table, collection_table},
};

/// Files that do not load, on which base, and why.
const REFUSED: [(&str, BaseKind, &str); 2] = [
    // The remains of a xacro file: a robot without name and links.
    (
        "ur_description/urdf/ur3.urdf",
        BaseKind::Floating,
        "the robot has no links",
    ),
    (
        "ur_description/urdf/ur3.urdf",
        BaseKind::Fixed,
        "the robot has no links",
    ),
];

/// A file of the package on one base.
struct Case {
    /// Relative to the package's folder of robots.
    file: String,
    path: PathBuf,
    base: BaseKind,
    /// What Pinocchio says of it; nothing if it has no link or no degree of freedom.
    oracle: Option<PathBuf>,
}

fn read(path: &Path) -> Value {
    let text = fs::read_to_string(path).expect("the file is there");
    serde_json::from_str(&text).expect("is JSON")
}

/// All files on both bases; nothing if the oracle has not been made.
fn collection() -> Option<Vec<Case>> {
    let cases = collection::collection()?.into_iter().flat_map(|robot| {
        let bases = [BaseKind::Floating, BaseKind::Fixed].into_iter();
        bases.map(move |base| Case {
            file: robot.file.clone(),
            path: robot.path.clone(),
            base,
            oracle: robot.oracle(base).map(Path::to_owned),
        })
    });
    Some(cases.collect())
}

impl Case {
    fn name(&self) -> String {
        format!("{}, {}", self.file, label(self.base))
    }

    fn load(&self) -> Result<RobotModel, RobotError> {
        self.load_as(Options::default())
    }

    fn load_as(&self, mode: Options) -> Result<RobotModel, RobotError> {
        let options = Options {
            base: self.base,
            ..mode
        };
        from_files(&self.path, None, &options)
    }

    /// What is said of it, without where the package is.
    fn said(&self, message: &str) -> String {
        message.replace(&self.path.display().to_string(), &self.file)
    }
}

/// No single failure hides the others.
fn assert_none(failures: &[String]) {
    assert!(
        failures.is_empty(),
        "{} failures:\n{}",
        failures.len(),
        failures.join("\n")
    );
}

#[test]
fn all_load_but_those_that_are_named() {
    let Some(cases) = collection() else { return };
    let mut failures = Vec::new();
    let mut refused = 0;
    for case in &cases {
        let expected = REFUSED
            .iter()
            .find(|(file, base, _)| *file == case.file && *base == case.base);
        match (case.load().err(), expected) {
            (None, None) => {}
            (None, Some(_)) => failures.push(format!("{} loads", case.name())),
            (Some(error), None) => failures.push(case.said(&format!("{}: {error}", case.name()))),
            (Some(error), Some((_, _, reason))) => {
                refused += 1;
                let error = case.said(&error.to_string());
                if !error.contains(reason) {
                    failures.push(format!("{}: refused by {error}", case.name()));
                }
            }
        }
    }
    assert_none(&failures);
    assert_eq!(refused, REFUSED.len());
}

#[test]
fn the_page_says_what_loads() {
    let Some(files) = collection::collection() else {
        return;
    };
    let page = fs::read_to_string(workspace("docs/robots.md")).expect("the page is there");
    let table = Table::Collection.of(&page).expect("the table is there");
    assert!(
        table == collection_table(&files),
        "docs/robots.md is not that of the code; `cargo run --release -p wbqp-tests --bin robots_page` writes it"
    );
}

#[test]
fn dynamics_are_pinocchios() {
    let Some(cases) = collection() else { return };
    let (mut failures, mut worst, mut compared) = (Vec::new(), Worst::default(), 0);
    for case in &cases {
        let (Ok(robot), Some(oracle)) = (case.load(), &case.oracle) else {
            continue;
        };
        let entry = read(oracle);
        let mut comparison =
            match Comparison::new(&case.name(), &robot.model, &entry["joints"], &mut worst) {
                Ok(comparison) => comparison,
                Err(error) => {
                    failures.push(error);
                    continue;
                }
            };
        let followers = robot.model.mimics().iter().map(|m| m.joint.name.as_str());
        let expected = list(&entry["mimics"]).iter().filter_map(Value::as_str);
        if followers.collect::<BTreeSet<_>>() != expected.collect() {
            failures.push(format!("{}: other mimic joints", case.name()));
        }
        failures.extend(comparison.mass(&entry["total_mass"]).err());
        for state in list(&entry["states"]) {
            failures.extend(comparison.state(state).err());
            compared += 1;
        }
    }
    println!("{compared} states\n{}", worst.lines());
    assert_none(&failures);
    // All but the two multirotors of a single body on a fixed base, where there is nothing to compare.
    assert_eq!(compared, 3 * (cases.len() - REFUSED.len() - 2));
}

/// A posture is kept while the measured joints sway about it, within the actuators' limits.
fn posture(case: &Case) -> Result<Controller, String> {
    let text = format!(
        r#"
[controller]
rate = 500.0
hover = "unchecked"

[robot]
type = "urdf"
file = "{}"
options = {{ base = "{}" }}

[[task]]
name = "posture"
type = "posture"
weight = 1.0
kp = 100.0
kd = 20.0

[[constraint]]
name = "limits"
type = "actuator_limits"
"#,
        case.path.display(),
        label(case.base)
    );
    let config =
        ControllerConfig::from_str(&text, "posture.toml", "").map_err(|e| e.to_string())?;
    config.build().map_err(|e| e.to_string())
}

/// Why not all ticks were optimal.
fn run(controller: &mut Controller) -> Result<(), String> {
    let mut measurement = Measurement::home(controller.robot(), 0);
    let home = measurement.state.clone();
    let limits: Vec<_> = controller
        .robot()
        .model
        .joints()
        .iter()
        .map(|j| j.limits)
        .collect();
    let offset = controller.robot().model.joint_offset();
    for tick in 1..=100 {
        measurement.time = 0.002 * f64::from(tick);
        for (i, limits) in limits.iter().enumerate() {
            let phase = 5.0 * measurement.time + i as f64;
            let q = home.q[i] + 0.05 * (phase.sin() - (i as f64).sin());
            measurement.state.q[i] = q.clamp(limits.lower, limits.upper);
            measurement.state.v[offset + i] = if q == measurement.state.q[i] {
                0.25 * phase.cos()
            } else {
                0.0
            };
        }
        let (command, report) = controller.tick(&measurement);
        let finite = command
            .effort
            .iter()
            .chain(&report.vdot)
            .all(|x| x.is_finite());
        if report.level != FallbackLevel::Optimal || report.status != Status::Optimal || !finite {
            let status = report.status;
            let why = controller.explain();
            return Err(format!(
                "tick {tick}: {status:?}: {}",
                why.unwrap_or_default()
            ));
        }
    }
    Ok(())
}

#[test]
fn a_posture_is_kept_optimally() {
    let Some(cases) = collection() else { return };
    let (mut failures, mut kept, mut without_joints) = (Vec::new(), 0, 0);
    for case in &cases {
        let Ok(robot) = case.load() else { continue };
        if robot.model.joints().is_empty() {
            without_joints += 1;
            continue;
        }
        match posture(case).and_then(|mut controller| run(&mut controller)) {
            Ok(()) => kept += 1,
            Err(error) => failures.push(case.said(&format!("{}: {error}", case.name()))),
        }
    }
    println!("{kept} robots");
    assert_none(&failures);
    // Two multirotors are a single body.
    assert_eq!(without_joints, 4);
    assert_eq!(kept + without_joints + REFUSED.len(), cases.len());
}

/// What was said of every file when there was no other mode: a line per file, or per file and base where these differ.
/// Since then the message about the triangle inequality says by how much it is broken.
const STRICT: &str = include_str!("../../fixtures/strict.txt");

#[test]
fn strict_mode_refuses_what_it_always_refused() {
    let Some(cases) = collection() else { return };
    let mut failures = Vec::new();
    for base in [BaseKind::Floating, BaseKind::Fixed] {
        let expected = |line: &'static str| match line.split_once(": ") {
            Some(("floating", line)) => (base == BaseKind::Floating).then_some(line),
            Some(("fixed", line)) => (base == BaseKind::Fixed).then_some(line),
            _ => Some(line),
        };
        let expected: BTreeSet<&str> = STRICT.lines().filter_map(expected).collect();
        assert_eq!(expected.len(), FILES);
        for case in cases.iter().filter(|case| case.base == base) {
            let said = match case.load_as(Options {
                strict: true,
                ..Options::default()
            }) {
                Ok(_) => format!("{}: loads", case.file),
                Err(error) => case.said(&error.to_string()),
            };
            // Other errors of the file may stand beside it.
            if !said.lines().any(|line| expected.contains(line)) {
                failures.push(format!("{}: {said}", case.name()));
            }
        }
    }
    assert_none(&failures);
}
