//! Robots as plain data: what of the data has an effect, and what is refused.

use std::path::Path;

use wbqp::robot::{Robot, RobotError, RobotModel};
use wbqp_robots::Tree;

const PENDULUM: &str = r#"
name = "pendulum"
base = "fixed"
[[body]]
name = "stand"
[[body]]
name = "rod"
parent = "stand"
mass = 1.0
moments = [0.1, 0.1, 0.1]
joint = { name = "swing", axis = [0.0, 1.0, 0.0], effort = 3.0 }
[[motor]]
name = "swing"
joint = "swing"
"#;

fn load(text: &str) -> Result<RobotModel, RobotError> {
    let tree: Tree = toml::from_str(text).expect("a tree");
    tree.load(Path::new(""))
}

#[track_caller]
fn refused(text: &str, what: &str) {
    let error = load(text).expect_err("it has no meaning").to_string();
    assert!(error.contains(what), "`{what}` is not in: {error}");
}

#[test]
fn a_motor_gives_no_more_than_its_joint_bears() {
    let limits = |text: &str| {
        let motor = load(text).expect("a robot").actuators.remove(0);
        (motor.lower, motor.upper)
    };
    assert_eq!(limits(PENDULUM), (-3.0, 3.0));
    assert_eq!(
        limits(&format!("{PENDULUM}limits = [-2.0, 9.0]")),
        (-2.0, 3.0)
    );
    refused(
        &format!("{PENDULUM}limits = [4.0, 9.0]"),
        "motor `swing``: `limits` are 4 to 9, and joint `swing` bears 3 either way",
    );
}

#[test]
fn a_base_that_is_placed_like_a_body_is_refused() {
    for key in [
        "position = [0.0, 0.0, 5.0]",
        "quaternion = [0.0, 1.0, 0.0, 0.0]",
    ] {
        refused(
            &PENDULUM.replacen("name = \"stand\"", &format!("name = \"stand\"\n{key}"), 1),
            "body `stand``: is the base, which hangs on nothing",
        );
    }
}

#[test]
fn a_frame_without_a_place_is_refused() {
    let frame = "[[frame]]\nname = \"tool\"\nbody = \"rod\"\nposition = [nan, 0.0, 0.0]";
    refused(
        &format!("{PENDULUM}{frame}"),
        "frame `tool`: its position or orientation has a number",
    );
}

#[test]
fn an_axis_has_any_length() {
    let short = PENDULUM.replacen("[0.0, 1.0, 0.0]", "[0.0, 1e-12, 0.0]", 1);
    assert_eq!(load(&short).expect("a robot").model.joints()[0].axis.y, 1.0);
}

#[test]
fn numbers_that_no_robot_has_are_refused_by_name() {
    for (from, to, what) in [
        (
            "moments = [0.1",
            "moments = [1e308",
            "body `rod`: moments`: has 1e308",
        ),
        (
            "effort = 3.0",
            "effort = -1e12",
            "body `rod`: joint `swing`: effort`: has -1e12",
        ),
        (
            "[[body]]\nname = \"stand\"",
            "gravity = [0.0, 0.0, -1e308]\n[[body]]\nname = \"stand\"",
            "gravity`: has",
        ),
    ] {
        refused(&PENDULUM.replacen(from, to, 1), what);
    }
    assert!(load(&PENDULUM.replace("effort = 3.0", "effort = inf")).is_ok());
}
