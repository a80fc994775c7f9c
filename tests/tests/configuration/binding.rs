//! What only the robot shows to be wrong, reported where the file says it: all of it, like a mistake of the text.

use wbqp::{
    ControllerConfig,
    config::{ConfigErrorKind, ConfigErrors, Overrides},
    controller::Controller,
    plugin::{Entry, Hardness},
    robot::Robot as _,
    settings::Settings,
};
use wbqp_robots::Othex;
use wbqp_tasks::{BasePosition, Posture};

const HEAD: &str = "[controller]\nrate = 250\n\n[robot]\ntype = \"othex\"\n\n";

fn bind(body: &str, overrides: &Overrides) -> Result<Controller, ConfigErrors> {
    let text = format!("{HEAD}{body}");
    let config = ControllerConfig::from_str_with(&text, "x.toml", "", overrides);
    Controller::new(config.unwrap_or_else(|errors| panic!("{errors}")))
}

fn refusal(body: &str, overrides: &Overrides) -> String {
    bind(body, overrides).expect_err("is refused").to_string()
}

#[track_caller]
fn check(body: &str, expected: &[&str]) {
    assert_eq!(refusal(body, &Overrides::new()), expected.join("\n"));
}

#[test]
fn all_of_them_with_their_places() {
    check(
        r#"[solver]
type = "clarabel"
tolerance = 2.0

[[contact]]
name = "tip"
frame = "toll"
kind = "point"
surface = { normal = [-1, 0, 0], x_axis = [0, 0, 1] }

[[task]]
name = "arm"
type = "posture"
weight = [1, 2]
kp = 1
kd = 1

[[task]]
name = "wrist"
type = "posture"
weight = 1
kp = 1
kd = [1, 2]
joints = ["arm_roll", "arm_pitch1", "arm_pitch4"]

[[task]]
name = "base"
type = "base_position"
weight = 1
kp = 1
kd = 1
reference = { type = "waypoints", points = [{ at = 1, value = [0, 0, 1] }, { at = 2, value = [0, 0] }] }

[[constraint]]
name = "cone"
type = "friction_pyramid"
contact = "tap"

[[constraint]]
name = "limits"
type = "actuator_limits"
hardness = "soft"
weight = 1
"#,
        &[
            "x.toml:9:13: solver (clarabel): tolerance: is 2, must be between 0 and 1",
            "x.toml:13:9: contact[0] `tip`: frame: frame `toll` does not exist; did you mean `tool`? (known: \
             base_link, arm_base, arm_link1, arm_link2, arm_link3, tool, rotor_1, rotor_2, rotor_3, rotor_4, \
             rotor_5, rotor_6)",
            "x.toml:20:10: task[0] `arm` (posture): weight: has 2 entries, expected one number, or 3: one per row",
            "x.toml:30:37: task[1] `wrist` (posture): joints[2]: joint `arm_pitch4` does not exist; did you mean \
             `arm_pitch1`? (known: arm_roll, arm_pitch1, arm_pitch2)",
            "x.toml:38:94: task[2] `base` (base_position): reference.points[1].value: has 2 entries, expected 3",
            "x.toml:43:11: constraint[0] `cone` (friction_pyramid): contact: contact `tap` does not exist; did you \
             mean `tip`? (known: tip)",
            "x.toml:48:12: constraint[1] `limits` (actuator_limits): hardness: bounds are always hard, and the entry \
             has nothing else; leave `hardness` out",
        ],
    );
}

#[test]
fn a_value_that_was_overridden_is_called_by_the_override() {
    let task = "[[task]]\nname = \"arm\"\ntype = \"posture\"\nweight = 1\nkp = 1\nkd = 1\n";
    let overrides = Overrides::new()
        .with("task.arm.kp", -1)
        .with("robot.thrust_max", 9.0);
    assert_eq!(
        refusal(task, &overrides),
        "x.toml: override task `arm`.`kp`: is -1, must be finite and not negative"
    );
    let overrides = Overrides::new().with("robot.thrust_max", 0.0);
    assert_eq!(
        refusal(task, &overrides),
        "x.toml: robot (othex): option `thrust_max`: is 0 N, must be finite and not below the least thrust of rotor \
         `rotor_1`, 0.25 N"
    );
}

#[test]
fn a_robot_that_cannot_hover_is_refused_unless_told_otherwise() {
    let weak = |hover: &str| {
        let text = format!(
            "[controller]\nrate = 250\n{hover}\n[robot]\ntype = \"othex\"\nthrust_max = 4.0\n"
        );
        Controller::new(ControllerConfig::from_str(&text, "x.toml", "").expect("loads"))
    };
    let error = weak("").expect_err("is too weak").to_string();
    let start = "x.toml:4:1: robot (othex): cannot hover in its home posture: ";
    assert!(error.starts_with(start), "{error}");
    for part in [
        "N short along +z_W",
        "(weight 28.6 N; 6 of 6 rotors at their largest thrust)",
    ] {
        assert!(error.contains(part), "{error}");
    }
    let errors = weak("").expect_err("is too weak");
    assert!(
        errors
            .iter()
            .all(|error| error.kind == ConfigErrorKind::Hover)
    );
    assert!(weak("hover = \"unchecked\"").is_ok());
}

#[test]
fn a_configuration_made_in_code_has_no_places() {
    let mut config = ControllerConfig::new(Settings::at_rate(250.0), Box::new(Othex::default()));
    let soft = Hardness::Soft;
    let posture = || Box::new(Posture::new([1.0, 2.0], 1.0));
    config.tasks.push(Entry::new("arm", 1.0, soft, posture()));
    let position = Box::new(BasePosition::new(1.0, 1.0));
    config.tasks.push(Entry::new("arm", 1.0, soft, position));
    let error = Controller::new(config).expect_err("is refused").to_string();
    assert_eq!(
        error,
        "task[0] `arm` (posture): kp: has 2 entries, expected 3, one per row, or one number for all\n\
         task[1] `arm` (base_position): name: is taken by task[0]"
    );
}

#[test]
fn a_robot_that_contradicts_itself_is_refused() {
    let config = || ControllerConfig::new(Settings::at_rate(250.0), Box::new(Othex::default()));
    let robot = || Othex::default().load("".as_ref()).expect("loads");
    let refused = |spoil: &dyn Fn(&mut wbqp::robot::RobotModel)| {
        let mut robot = robot();
        spoil(&mut robot);
        Controller::with_robot(config(), robot)
            .expect_err("is refused")
            .to_string()
    };
    assert_eq!(
        refused(&|robot| robot.home.q[1] = 9.0),
        "robot (othex): joint `arm_pitch1` is at 9 in the home posture, outside its range -1.570796 to 1.570796"
    );
    assert_eq!(
        refused(&|robot| {
            robot.actuators[0].lower = 20.0;
            robot.actuators[2].name = "rotor_2".to_owned();
        }),
        "robot (othex): actuator `rotor_1`: lower limit 20 is above upper limit 10\n\
         robot (othex): actuator `rotor_2` is there twice; give each a name of its own"
    );
    assert_eq!(
        refused(&|robot| robot.home.q = wbqp::nalgebra::DVector::zeros(2)),
        "robot (othex): its home posture has 2 joint positions and 9 velocities, its model 3 and 9"
    );
}
