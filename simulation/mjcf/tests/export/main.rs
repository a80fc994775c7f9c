//! What an exported model says, element by element. Whether MuJoCo makes the same mechanics of it is tested from Python
//! (`python/tests/test_mujoco.py`), where there is a MuJoCo.

use roxmltree::{Document, Node};
use wbqp::robot::RobotModel;
use wbqp_mjcf::{MjcfError, Scene, servo::Gains};
use wbqp_sim::{
    plant::{ContactPointConfig, WallConfig},
    sensors::ForceTorqueConfig,
};

fn named<'a>(document: &'a Document<'_>, element: &str, name: &str) -> Node<'a, 'a> {
    let found = document
        .descendants()
        .find(|node| node.has_tag_name(element) && node.attribute("name") == Some(name));
    found.unwrap_or_else(|| panic!("there is no <{element} name=\"{name}\">"))
}

fn numbers(node: Node<'_, '_>, attribute: &str) -> Vec<f64> {
    let text = node.attribute(attribute).unwrap_or_default();
    let numbers = text.split(' ').map(|x| x.parse().expect("a number"));
    numbers.collect()
}

fn shipped() -> Vec<RobotModel> {
    let robots = [
        wbqp_robots::othex(),
        wbqp_robots::othex_vertical(),
        wbqp_robots::quadruped(),
        wbqp_robots::humanoid(),
    ];
    robots
        .into_iter()
        .map(|robot| robot.expect("ships"))
        .collect()
}

#[test]
fn every_robot_that_ships_is_written_without_a_note_and_with_all_its_names() {
    for robot in shipped() {
        let exported = Scene::of_robot(&robot).export().expect("exports");
        assert_eq!(exported.notes, Vec::<String>::new());
        let document = Document::parse(&exported.text).expect("is XML");
        for joint in robot.model.joints() {
            named(&document, "joint", &joint.name);
        }
        for frame in robot.model.frames() {
            named(&document, "site", &frame.name);
        }
        let actuators = document.descendants().filter(|n| {
            n.parent()
                .is_some_and(|parent| parent.has_tag_name("actuator"))
                && n.is_element()
        });
        let names: Vec<_> = actuators.filter_map(|n| n.attribute("name")).collect();
        for actuator in &robot.actuators {
            assert!(names.contains(&actuator.name.as_str()), "{}", actuator.name);
        }
    }
}

#[test]
fn a_rotor_has_the_mismatch_of_the_plant_and_both_lags() {
    let robot = wbqp_robots::othex().expect("ships");
    let mut scene = Scene::of_robot(&robot);
    scene.plant.mismatch.thrust_scale = 0.9;
    scene.plant.mismatch.rotor_scales = vec![1.0, 1.1];
    scene.plant.mismatch.thrust_max = 5.0;
    let text = scene.export().expect("exports").text;
    let document = Document::parse(&text).expect("is XML");
    let second = named(&document, "general", "rotor_2");
    // At most 5 N are produced, so at most 5 / (0.9 × 1.1) N can be asked for.
    assert_eq!(numbers(second, "gainprm"), [0.9 * 1.1]);
    assert_eq!(numbers(second, "ctrlrange"), [0.25, 5.0 / (0.9 * 1.1)]);
    assert_eq!(numbers(second, "gear"), [0.0, 0.0, 1.0, 0.0, 0.0, 0.0192]);
    assert_eq!(numbers(second, "user"), [0.0125, 0.025]);
    let first = named(&document, "general", "rotor_1");
    assert_eq!(numbers(first, "gainprm"), [0.9]);
    assert_eq!(numbers(first, "gear")[5], -0.0192);
}

#[test]
fn the_halves_of_a_servo_add_up_to_a_pi_controller_of_velocity() {
    let robot = wbqp_robots::othex().expect("ships");
    let scene = Scene::of_robot(&robot);
    let lag = scene.plant.servo.time_constant;
    let text = scene.export().expect("exports").text;
    let document = Document::parse(&text).expect("is XML");
    let first = named(&document, "general", "arm_roll");
    let second = named(&document, "general", "arm_roll_integral");
    let (kv, ki) = (-numbers(first, "biasprm")[2], numbers(second, "gainprm")[0]);
    assert!((numbers(first, "gainprm")[0] - (kv - ki * lag)).abs() < 1e-12 * kv);
    assert_eq!(numbers(second, "biasprm"), [0.0, -ki, 0.0]);
    // Critically damped: kv² = 4 Λ ki with the inertia that the gains are made for.
    let gains = Gains::new(1.0, lag);
    assert!((kv * kv / ki - gains.kv * gains.kv / gains.ki * (kv / gains.kv)).abs() < 1e-9 * kv);
}

#[test]
fn points_touch_walls_and_nothing_else_touches_anything() {
    let robot = wbqp_robots::othex().expect("ships");
    let mut scene = Scene::of_robot(&robot);
    let wall = |name, stiffness| WallConfig {
        stiffness,
        ..WallConfig::new(name, [1.0, 0.0, 0.0].into(), [-2.0, 0.0, 0.0].into())
    };
    // The second has the name of the tool's sphere.
    scene.plant.walls = vec![wall("wall", 2e4), wall("tool", 1e5)];
    scene.plant.contact_points = vec![ContactPointConfig {
        frame: "tool".into(),
        offset: [0.0; 3],
    }];
    scene.sensors.force_torque = vec![ForceTorqueConfig::new("tool")];
    let exported = scene.export().expect("exports");
    assert_eq!(exported.walls, ["wall", "tool"]);
    assert_eq!(exported.points, ["tool_2"]);
    let document = Document::parse(&exported.text).expect("is XML");
    let geoms = document.descendants().filter(|n| n.has_tag_name("geom"));
    for geom in geoms {
        assert_eq!(geom.attribute("contype"), Some("0"));
        assert_eq!(geom.attribute("conaffinity"), Some("0"));
    }
    let pairs: Vec<_> = document
        .descendants()
        .filter(|n| n.has_tag_name("pair"))
        .collect();
    let solref: Vec<_> = pairs.iter().map(|pair| numbers(*pair, "solref")).collect();
    assert_eq!(pairs.len(), 2);
    assert!((solref[1][0] / solref[0][0] - 5.0).abs() < 1e-12);
    assert!(solref.concat().iter().all(|x| *x < 0.0));
    // The sphere, 1 mm, touches when its middle is at the wall.
    assert_eq!(
        numbers(named(&document, "geom", "wall"), "pos"),
        [1.001, 0.0, 0.0]
    );
    named(&document, "force", "tool_force");
    named(&document, "torque", "tool_torque");
}

#[test]
fn what_cannot_be_written_is_refused_by_name() {
    let robot = wbqp_robots::othex().expect("ships");
    let said = |change: &dyn Fn(&mut Scene)| {
        let mut scene = Scene::of_robot(&robot);
        change(&mut scene);
        scene.export().map_err(|error: MjcfError| error.to_string())
    };
    let point = |scene: &mut Scene| {
        scene.plant.contact_points = vec![ContactPointConfig {
            frame: "tip".into(),
            offset: [0.0; 3],
        }];
    };
    let sensor = |scene: &mut Scene| {
        scene.sensors.force_torque = vec![ForceTorqueConfig::new("hand")];
    };
    assert_eq!(
        said(&point).unwrap_err(),
        "contact_point `tip`: the robot has no such frame"
    );
    assert_eq!(
        said(&sensor).unwrap_err(),
        "force_torque `hand`: the robot has no such frame"
    );
    assert_eq!(
        said(&|scene| scene.step = f64::NAN).unwrap_err(),
        "step: is NaN, must be positive and finite"
    );
    assert_eq!(
        said(&|scene| scene.initial.q = wbqp::nalgebra::DVector::zeros(1)).unwrap_err(),
        "initial state: is not one of this robot"
    );
}
