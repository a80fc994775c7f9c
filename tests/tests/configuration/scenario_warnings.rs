//! What of a scenario is taken and can hardly be meant.

use wbqp_robots as _;
use wbqp_sim::Scenario;
use wbqp_tasks as _;
use wbqp_tests::files::scenarios;

const WALL: &str = r#"
[[plant.wall]]
name = "wall"
point = [0.0, 0.0, 0.0]
normal = [-1.0, 0.0, 0.0]
"#;
const POINT: &str = "[[plant.contact_point]]\nframe = \"tool\"\n";

/// The warnings of a scenario with this world, whose tip comes to push in `case`.
fn warnings(world: &str) -> Vec<String> {
    let text = format!(
        r#"name = "push"
controller = "push_with_disturbance.controller.toml"
duration = 2.0
[initial]
position = [-0.5, 0.0, 1.258]
{world}
[[event]]
at = 1.0
cases = ["push"]
activate_contact = ["tip"]
[[case]]
name = "push"
[[case]]
name = "fly"
"#
    );
    let scenario = Scenario::from_text(&text, "push.toml", &scenarios()).expect("is sound");
    let of = |name: &str| {
        let case = scenario.case(name).expect("is there");
        let config = case.controller_config().expect("is sound");
        case.warnings(&case.make_controller(config).expect("fits"))
    };
    let (pushing, flying) = (of("push"), of("fly"));
    // What is wrong with a contact matters to those who use it.
    assert!(
        flying
            .iter()
            .all(|warning| !warning.contains("contact `tip`"))
    );
    pushing
}

#[test]
fn a_contact_needs_a_wall_a_point_and_a_surface_like_it() {
    assert_eq!(warnings(&format!("{WALL}{POINT}")), Vec::<String>::new());
    assert_eq!(
        warnings(""),
        ["contact `tip` has nothing to touch: the plant has no wall; add a [[plant.wall]]"]
    );
    assert_eq!(
        warnings(WALL),
        [
            "contact `tip` touches nothing: no contact point is on its body; add a [[plant.contact_point]] with \
          frame = \"tool\""
        ]
    );
    let floor = WALL.replace("[-1.0, 0.0, 0.0]", "[0.0, 0.0, 3.0]");
    assert_eq!(
        warnings(&format!("{floor}{POINT}")),
        [
            "contact `tip`: its surface has the normal [-1.0, 0.0, 0.0], and no wall of the plant has one within 45° \
          of it (`wall` is the nearest, 90° away)"
        ]
    );
}

/// What a file may say, and hardly anybody means: numbers that no robot and no world has.
#[test]
fn numbers_that_no_world_has_are_told() {
    let wall = format!("{WALL}friction = 50.0\n");
    let world = format!(
        "{wall}{POINT}[sensors.base]\nposition_sd = 2e4\n[[plant.disturbance]]\nframe = \"tool\"\nforce = [0.0, 3e9, \
         0.0]\n[[event]]\nat = 0.5\nfollow.base_position = {{ type = \"hold\", value = [0.0, 5e4, 1.0] }}\n\
         weight.base_position = 1e30\n"
    );
    assert_eq!(
        warnings(&world),
        [
            "plant.wall[0] `wall`: friction: is 50: no two materials have a Coulomb coefficient of more than 5; it is \
             a ratio of forces, not in per cent",
            "plant.disturbance[0].force[1]: is 3e9 N: no robot has more than 1e8; it counts in N",
            "sensors.base.position_sd: is 2e4 m: no robot has more than 1e4; it counts in m",
            "event at 0.5 s: follow.base_position.value[1] is 5e4 m: no robot has more than 1e4; it counts in m",
            "event at 0.5 s: weight.base_position: is 1e30, and that of `propeller_regularisation` is 1e-5: where \
             both are about the same motion, nothing of the smaller one is left in 64 bits; keep weights within 1e12 \
             of one another",
        ]
    );
}

#[test]
fn a_wall_in_other_units_is_far_away() {
    let millimetres = WALL.replace("point = [0.0", "point = [500.0");
    let told = warnings(&format!("{millimetres}{POINT}"));
    assert_eq!(told.len(), 1, "{told:?}");
    assert!(
        told[0].starts_with("wall `wall` is 500 m from the nearest contact point at the start"),
        "{told:?}"
    );
}

#[test]
fn a_contact_elsewhere_on_its_body_is_told() {
    let shifted = POINT.to_owned() + "offset = [0.0, 0.03, 0.0]\n";
    let told = warnings(&format!("{WALL}{shifted}"));
    assert_eq!(told.len(), 1, "{told:?}");
    assert!(
        told[0].starts_with("contact `tip`: its point is 30 mm from the plant's contact points"),
        "{told:?}"
    );
    // Between two of the plant's, as a sole's.
    let other = POINT.to_owned() + "offset = [0.0, -0.03, 0.0]\n";
    assert_eq!(
        warnings(&format!("{WALL}{shifted}{other}")),
        Vec::<String>::new()
    );
}

/// What a quadruped's scenario of 2 s with these lines says.
fn of_quadruped(lines: &str) -> Vec<String> {
    of_quadruped_case(lines, "")
}

/// With further lines in its case.
fn of_quadruped_case(lines: &str, of_case: &str) -> Vec<String> {
    let text = format!(
        r#"name = "stand"
controller = "quadruped_short.controller.toml"
duration = 2.0
[plant]
contact_point = [
    {{ frame = "fl_foot" }}, {{ frame = "fr_foot" }}, {{ frame = "hl_foot" }}, {{ frame = "hr_foot" }},
]
[[plant.wall]]
name = "ground"
point = [0.0, 0.0, 0.0]
normal = [0.0, 0.0, 1.0]
{lines}
[[case]]
name = "stand"
{of_case}
"#
    );
    let scenario = Scenario::from_text(&text, "stand.toml", &scenarios()).expect("is sound");
    let case = scenario.case("stand").expect("is there");
    let config = case.controller_config().expect("is sound");
    case.warnings(&case.make_controller(config).expect("fits"))
}

#[test]
fn a_robot_that_stands_in_the_air_or_for_too_short_is_told() {
    assert_eq!(of_quadruped(""), Vec::<String>::new());
    let told = of_quadruped("[initial]\nposition = [0.0, 0.0, 0.8]");
    assert_eq!(told.len(), 4, "{told:?}");
    let slow = "set.contact.fl_foot.transition = 100.0";
    assert_eq!(
        of_quadruped_case("", slow),
        ["contact `fl_foot`: its `transition` takes 100 s, and the run ends at 2 s"]
    );
    let is_above = |words: &String| words.contains("m from wall `ground` then");
    assert!(told.iter().all(is_above), "{told:?}");
}

#[test]
fn references_that_come_to_nothing_are_told() {
    let event = |lines: &str| format!("[[event]]\nat = 0.5\n{lines}");
    let follow = |duration: f64| {
        event(&format!(
            "follow.com = {{ type = \"min_jerk\", to = [0.0, 0.0, 0.2], duration = {duration:?} }}"
        ))
    };
    assert_eq!(of_quadruped(&follow(1.5)), Vec::<String>::new());
    assert_eq!(
        of_quadruped(&follow(20.0)),
        ["task `com`: its reference from 0.5 s on takes 20 s, and the run ends at 2 s"]
    );
    let off = "set.task.com.active = false";
    assert_eq!(
        of_quadruped_case(&follow(1.5), off),
        [
            "task `com` gets a reference (`follow`) and is never on: add `activate = [\"com\"]` to an event"
        ]
    );
    let on = follow(1.0) + "\nactivate = [\"com\"]";
    assert_eq!(of_quadruped_case(&on, off), Vec::<String>::new());
}
