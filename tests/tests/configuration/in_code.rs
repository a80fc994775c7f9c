//! A controller put together in code is the one that a file describes, is checked in the same way, and its tasks can
//! be changed while it runs.

use wbqp::{
    Controller, ControllerConfig, Measurement,
    contact::{ContactKind, ContactSpec, Surface},
    controller::RequestError,
    plugin::{Entry, Hardness, PerRow, Sample},
};
use wbqp_robots::Othex;
use wbqp_tasks::{
    ActuatorLimits, BaseOrientation, BasePosition, ContactForce, ContactMotion, FrictionPyramid,
    Hold, MinJerk, Posture, PropellerRegularisation,
};

fn wall() -> ContactSpec {
    let surface = Surface {
        normal: [-1.0, 0.0, 0.0],
        x_axis: [0.0, 0.0, 1.0],
        origin: [0.8, 0.0, 0.0],
    };
    ContactSpec {
        active: true,
        ..ContactSpec::new("tip", "tool", ContactKind::Point, surface)
    }
}

fn config() -> ControllerConfig {
    ControllerConfig::at_rate(250.0, Othex::default())
        .with_contact(wall())
        .with_task(Entry::task("arm", 0.1, Posture::new(25.0, 10.0)))
        .with_task(Entry::task("base", 1.0, BasePosition::new(9.0, 6.0)))
        .with_task(Entry::task(
            "attitude",
            vec![1.0, 2.0, 3.0],
            BaseOrientation::new(40.0, 12.0),
        ))
        .with_task(Entry::task("push", 1.0, ContactForce::new("tip", 2.0)).with_transition(0.5))
        .with_task(Entry::task("thrusts", 1e-5, PropellerRegularisation::new()))
        .with_task(Entry::task("spare", 1.0, Posture::new(1.0, 1.0)).inactive())
        .with_constraint(Entry::constraint("limits", ActuatorLimits::new()))
        .with_constraint(
            Entry::soft_constraint("cone", 10.0, FrictionPyramid::new("tip"))
                .with_hardness(Hardness::Exact(100.0)),
        )
        .with_constraint(Entry::soft_constraint(
            "touch",
            50.0,
            ContactMotion::new("tip"),
        ))
}

const FILE: &str = r#"
[controller]
rate = 250.0

[robot]
type = "othex"

[[contact]]
name = "tip"
frame = "tool"
kind = "point"
surface = { normal = [-1.0, 0.0, 0.0], x_axis = [0.0, 0.0, 1.0], origin = [0.8, 0.0, 0.0] }
active = true

[[task]]
name = "arm"
type = "posture"
weight = 0.1
kp = 25.0
kd = 10.0

[[task]]
name = "base"
type = "base_position"
weight = 1.0
kp = 9.0
kd = 6.0

[[task]]
name = "attitude"
type = "base_orientation"
weight = [1.0, 2.0, 3.0]
kp = 40.0
kd = 12.0

[[task]]
name = "push"
type = "contact_force"
weight = 1.0
transition = 0.5
contact = "tip"
reference = { type = "hold", value = [2.0] }

[[task]]
name = "thrusts"
type = "propeller_regularisation"
weight = 1e-5

[[task]]
name = "spare"
type = "posture"
weight = 1.0
active = false
kp = 1.0
kd = 1.0

[[constraint]]
name = "limits"
type = "actuator_limits"

[[constraint]]
name = "cone"
type = "friction_pyramid"
weight = 10.0
hardness = { exact = 100.0 }
contact = "tip"

[[constraint]]
name = "touch"
type = "contact_motion"
weight = 50.0
hardness = "soft"
contact = "tip"
"#;

/// Ticks with a base and a joint that drift away from home, and returns the bits of all commands.
fn run(controller: &mut Controller, ticks: usize) -> Vec<u64> {
    let mut measurement = Measurement::home(controller.robot(), 1);
    let start = controller.report().time;
    let mut bits = Vec::new();
    for k in 1..=ticks {
        measurement.time = start + 0.004 * k as f64;
        measurement.state.p_WR.x += 1e-3;
        measurement.state.q[0] += 1e-3;
        let (command, report) = controller.tick(&measurement);
        assert_eq!(report.fault, None);
        bits.extend(command.effort.iter().map(|u| u.to_bits()));
    }
    bits
}

#[test]
fn code_and_file_are_the_same_controller() {
    let mut in_code = config().build().expect("fits the robot");
    let from_file = ControllerConfig::from_str(FILE, "same.toml", "").expect("a good file");
    let mut from_file = from_file.build().expect("fits the robot");
    assert_eq!(run(&mut in_code, 50), run(&mut from_file, 50));

    let saved = config().to_toml().expect("everything can be saved");
    let loaded = ControllerConfig::from_str(&saved, "saved.toml", "").expect("what was saved");
    let mut loaded = loaded.build().expect("fits the robot");
    assert_eq!(
        run(&mut config().build().unwrap(), 50),
        run(&mut loaded, 50)
    );
}

#[test]
fn mistakes_in_code_come_at_once_and_by_name() {
    let twice = config()
        .with_task(Entry::task("arm", 0.1, Posture::new(25.0, 10.0)))
        .with_task(Entry::task("grip", 0.1, Posture::new([1.0, 2.0], -1.0)))
        .with_constraint(Entry::constraint("cone2", FrictionPyramid::new("tap")));
    let message = twice.build().expect_err("three mistakes").to_string();
    let lines: Vec<&str> = message.lines().collect();
    assert_eq!(
        lines,
        [
            "task[6] `arm` (posture): name: is taken by task[0]",
            "task[7] `grip` (posture): kp: has 2 entries, expected 3, one per row, or one number for all",
            "constraint[3] `cone2` (friction_pyramid): contact `tap` does not exist; did you mean `tip`? (known: tip)",
        ]
    );
}

#[test]
fn names_made_in_code_are_one_line() {
    let config = config().with_task(Entry::task("a\u{1b}[2J\n", 0.1, Posture::new(25.0, 10.0)));
    let message = config.build().expect_err("a mistake").to_string();
    assert_eq!(
        message,
        "task[6] `a\\u{1b}[2J\\n` (posture): name: has control characters, such as line breaks: leave them out"
    );
}

#[test]
fn names_made_in_code_are_not_empty() {
    let nameless = ContactSpec {
        name: String::new(),
        ..wall()
    };
    let config = config()
        .with_contact(nameless)
        .with_task(Entry::task("", 0.1, Posture::new(25.0, 10.0)))
        .with_constraint(Entry::constraint("", ActuatorLimits::new()));
    let message = config.build().expect_err("three mistakes").to_string();
    let lines: Vec<&str> = message.lines().collect();
    assert_eq!(
        lines,
        [
            "contact[1] ``: name: must not be empty",
            "task[6] `` (posture): name: must not be empty",
            "constraint[3] `` (actuator_limits): name: must not be empty",
        ]
    );
}

#[test]
fn a_task_is_changed_while_running() {
    let mut controller = config().build().expect("fits the robot");
    run(&mut controller, 5);
    let asked = |c: &Controller| c.report().tasks[0].residual[0];

    let before = controller.report().tasks[0].error[0];
    assert!(before > 0.0, "the joint was moved away: {before}");

    // A reference where the joints will be: the error is gone in the next tick.
    let q = [0.001, 0.0, 0.0];
    let home = controller.robot().home.q.clone();
    let here: Vec<f64> = home.iter().zip(q).map(|(home, q)| home + q).collect();
    let followed = |c: &Controller| c.followed("arm").expect("it is there").clone();
    assert_ne!(followed(&controller), Sample::at_rest(here.iter().copied()));
    let hold = Hold::at(here.clone());
    controller.follow("arm", hold).expect("three joints");
    run(&mut controller, 1);
    let report = controller.report();
    let error = report.task("arm").expect("it is there").error[0];
    assert!(error.abs() < 1e-12, "{error}");
    let arm = controller.entry("arm").expect("it is there");
    assert_eq!(report.task("arm"), Some(&report.tasks[arm.index()]));
    assert_eq!(report.task("amr"), None);
    assert_eq!(followed(&controller), Sample::at_rest(here));

    // Gains and weights: what the solution leaves of the task changes.
    run(&mut controller, 1);
    let soft = asked(&controller);
    let task = controller.parameters_mut::<Posture>("arm");
    task.expect("it is there").kp = 250.0.into();
    controller.reweight("arm", 10.0).expect("one number");
    run(&mut controller, 1);
    assert_ne!(asked(&controller), soft);

    controller.deactivate("arm").expect("it is there");
    run(&mut controller, 1);
    assert_eq!(controller.report().tasks[0].alpha, 0.0);
    controller.activate("arm").expect("it is there");
    run(&mut controller, 1);
    assert_eq!(controller.report().tasks[0].alpha, 1.0);
}

#[test]
fn what_does_not_fit_is_refused_by_name() {
    let mut controller = config().build().expect("fits the robot");
    let error = controller.parameters_mut::<Posture>("amr");
    assert_eq!(
        error.expect_err("no entry").to_string(),
        "there is no entry `amr`; did you mean `arm`? (known: arm, base, attitude, push, thrusts, spare, limits, \
         cone, touch)"
    );
    let error = controller.parameters_mut::<Posture>("base");
    let error = error.expect_err("another type");
    assert!(
        matches!(&error, RequestError::OtherType { name, is: "base_position", .. } if name == "base"),
        "{error}"
    );
    assert_eq!(
        error.to_string(),
        "`base` is of type `base_position`, not a `Posture`"
    );

    let error = controller.reweight("arm", vec![1.0, 2.0]);
    assert_eq!(
        error.expect_err("three rows").to_string(),
        "`arm`: `weight` is [1.0, 2.0], must be one number, or 3, finite and not negative"
    );
    let error = controller.follow("arm", MinJerk::new([1.0], 1.0));
    let error = error.expect_err("three joints");
    assert!(matches!(error, RequestError::Value { .. }), "{error}");
    let error = controller.follow("thrusts", Hold::at([1.0]));
    assert_eq!(
        error.expect_err("no trajectory").to_string(),
        "task `thrusts` follows no reference"
    );

    let contact = controller.deactivate("tip");
    assert_eq!(
        contact.expect_err("no entry").to_string(),
        "`tip` is a contact, no task or constraint: `activate_contact` and the like are for it"
    );

    // As in a file.
    let pulls = controller.follow("push", MinJerk::new([-5.0], 1.0));
    assert_eq!(
        pulls.expect_err("no surface pulls").to_string(),
        "`push`: `to` is -5 N: a surface pushes and never pulls, a normal force is 0 or more"
    );
    assert_eq!(controller.followed("push"), Ok(&Sample::at_rest([0.0])));
}

#[test]
fn changed_parameters_are_checked_like_those_of_a_file() {
    let mut controller = config().build().expect("fits the robot");
    run(&mut controller, 5);
    let kp = |c: &mut Controller| {
        let arm = c.parameters_mut::<Posture>("arm").expect("it is there");
        (arm.kp.clone(), arm.kd.clone())
    };
    let before = kp(&mut controller);
    controller
        .change("arm", |arm: &mut Posture| arm.kp = 40.0.into())
        .expect("is a stiffness");
    assert_eq!(kp(&mut controller), (40.0.into(), before.1.clone()));
    for (change, problem) in [
        (
            (|arm| arm.kp = (-40.0).into()) as fn(&mut Posture),
            "`arm`: `kp` is -40, must be finite and not negative",
        ),
        (
            |arm| arm.kd = vec![1.0, 2.0].into(),
            "`arm`: `kd` has 2 entries, expected 3, one per row, or one number for all",
        ),
        (
            |arm| arm.joints = Some(vec!["arm_rol".to_owned()]),
            "`arm`: joint `arm_rol` does not exist; did you mean `arm_roll`? (known: arm_roll, arm_pitch1, arm_pitch2)",
        ),
        (
            |arm| arm.joints = Some(vec!["arm_roll".to_owned()]),
            "`arm`: has other rows with these parameters: a new controller is needed",
        ),
    ] {
        let error = controller.change("arm", change).expect_err(problem);
        assert_eq!(error.to_string(), problem);
        assert_eq!(kp(&mut controller), (40.0.into(), before.1.clone()));
    }
    let error = controller.change("base", |arm: &mut Posture| arm.kp = 1.0.into());
    assert_eq!(
        error.expect_err("another type").to_string(),
        "`base` is of type `base_position`, not a `Posture`"
    );
    run(&mut controller, 1);
    assert_eq!(controller.report().fault, None);
}

#[test]
fn a_constraint_is_changed_while_running() {
    // The tip moves along the wall: what is asked of it depends on the damping.
    let mut controller = config().build().expect("fits the robot");
    let mut measurement = Measurement::home(controller.robot(), 1);
    measurement.state.v[2] = 0.1;
    let mut efforts = |controller: &mut Controller| {
        measurement.time += 0.004;
        controller.tick(&measurement).0.effort.clone()
    };
    let before = efforts(&mut controller);

    let touch = controller.parameters_mut::<ContactMotion>("touch");
    touch.expect("it is there").damping = 40.0;
    let damped = efforts(&mut controller);
    assert_ne!(damped, before);

    controller.reweight("touch", 5.0).expect("a number");
    let light = efforts(&mut controller);
    assert_ne!(light, damped);

    controller.deactivate("touch").expect("it is there");
    assert_ne!(efforts(&mut controller), light);
    assert_eq!(controller.report().task("touch"), None);

    let error = controller.parameters_mut::<FrictionPyramid>("touch");
    assert_eq!(
        error.expect_err("another type").to_string(),
        "`touch` is of type `contact_motion`, not a `FrictionPyramid`"
    );
}

#[test]
fn nonsense_written_into_a_task_is_survived() {
    let mut controller = config().build().expect("fits the robot");
    run(&mut controller, 2);
    let before = controller.command().effort.clone();
    let arm = controller.parameters_mut::<Posture>("arm");
    arm.expect("it is there").kp = f64::NAN.into();
    let mut measurement = Measurement::home(controller.robot(), 1);
    measurement.time = 1.0;
    let (command, report) = controller.tick(&measurement);
    assert!(report.fault.is_some());
    assert!(command.effort.iter().all(|u| u.is_finite()), "{before:?}");

    let arm = controller.parameters_mut::<Posture>("arm");
    arm.expect("it is there").kp = vec![25.0].into(); // too short: the other joints have no stiffness
    controller
        .reweight("arm", PerRow::Uniform(1.0))
        .expect("one number");
    measurement.time = 1.004;
    let (_, report) = controller.tick(&measurement);
    assert_eq!(report.fault, None);
}
