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
