//! The largest normal force in static equilibrium: known figures, laws, and scenarios that ask for more.
#![allow(non_snake_case)]

use std::sync::Arc;

use wbqp::{
    contact::ContactSpec,
    dynamics::{Data, FrameKinematics},
    model::Inertia,
    nalgebra::{DVector, UnitQuaternion, Vector3, Vector6},
    robot::RobotModel,
    state::State,
    toml,
};
use wbqp_robots::{othex, othex_vertical};
use wbqp_sim::statics::{Load, Push, largest_push};
use wbqp_sim::{Scenario, Variation};
use wbqp_tasks as _;
use wbqp_tests::files::scenarios;

/// A vertical wall in front of the robot.
fn tip() -> ContactSpec {
    let text = r#"
        name = "tip"
        frame = "tool"
        kind = "point"
        surface = { normal = [-1.0, 0.0, 0.0], x_axis = [0.0, 0.0, 1.0] }
        friction = 0.5
    "#;
    toml::from_str(text).expect("is a contact")
}

/// Home, turned about y; nose-up is negative.
fn pitched(robot: &RobotModel, degrees: f64) -> State {
    let mut state = robot.home.clone();
    state.R_WR = UnitQuaternion::from_euler_angles(0.0, degrees.to_radians(), 0.0);
    state
}

/// The disturbance of experiment B.
fn disturbance(robot: &RobotModel) -> Load {
    Load {
        frame: robot.model.frame("base_link").expect("exists"),
        wrench: Vector6::new(-3.5, 0.0, 0.0, 0.0, 0.0, 0.0),
    }
}

fn push(robot: &RobotModel, state: &State, loads: &[Load]) -> Push {
    let found = largest_push(robot, state, &tip(), &[], loads).expect("is a problem");
    found.expect("has an equilibrium")
}

/// The same robot with other masses and motors.
fn mismatched(robot: &RobotModel, mass: f64, thrust: f64) -> RobotModel {
    let heavier = |body: &wbqp::model::Body| {
        let own = &body.inertia;
        Inertia::from_com(own.mass * mass, own.com(), own.I_BBcm() * mass)
    };
    let mut other = robot.clone();
    other.model = Arc::new(robot.model.with_inertias(heavier).expect("can be"));
    for actuator in other.actuators.iter_mut().take(6) {
        actuator.lower *= thrust;
        actuator.upper *= thrust;
    }
    other
}

#[test]
fn figures_of_experiment_b() {
    let robot = othex().expect("ships");
    let load = disturbance(&robot);
    for (pitch, expected, half_digit) in [(0.0, 6.5, 0.05), (-4.0, 5.05, 0.005), (-7.0, 3.8, 0.05)]
    {
        let found = push(&robot, &pitched(&robot, pitch), &[load]).normal;
        println!("{pitch}°: {found:.3} N, expected {expected}");
        assert!((found - expected).abs() <= half_digit, "{pitch}: {found}");
    }
    let weak = mismatched(&robot, 1.05, 0.85);
    let found = push(&weak, &weak.home, &[]).normal;
    println!("motors −15 %, mass +5 %: {found:.3} N, expected 4.5");
    assert!((found - 4.5).abs() <= 0.05, "{found}");
    println!("nominal: {:.3} N", push(&robot, &robot.home, &[]).normal);
}

#[test]
fn it_is_an_equilibrium_within_the_limits() {
    let robot = othex().expect("ships");
    let load = disturbance(&robot);
    let state = pitched(&robot, -3.0);
    let found = push(&robot, &state, &[load]);
    let model = &robot.model;
    let mut data = Data::new(model);
    data.update(model, &state);
    let mut balance = -data.gravity();
    let mut frame = FrameKinematics::new(model);
    let mut add = |balance: &mut DVector<f64>, name: &str, wrench: &Vector6<f64>| {
        frame.update(model, &data, model.frame(name).expect("exists"));
        *balance += frame.J.transpose() * wrench;
        frame.R_WF
    };
    add(&mut balance, "base_link", &load.wrench);
    let f_W = tip().surface.rotation().expect("is one") * found.force;
    add(
        &mut balance,
        "tool",
        &Vector6::new(f_W.x, f_W.y, f_W.z, 0.0, 0.0, 0.0),
    );
    for (i, actuator, rotor) in robot.rotors() {
        let z = add(&mut balance, &actuator.name, &Vector6::zeros()) * Vector3::z();
        let (force, moment) = (
            z * found.effort[i],
            z * (rotor.reaction.sign() * rotor.moment_coefficient * found.effort[i]),
        );
        let wrench = Vector6::new(force.x, force.y, force.z, moment.x, moment.y, moment.z);
        add(&mut balance, &actuator.name, &wrench);
    }
    for j in 0..3 {
        balance[6 + j] += found.effort[6 + j];
    }
    assert!(balance.amax() < 1e-6, "{balance}");
    for (u, actuator) in found.effort.iter().zip(&robot.actuators) {
        assert!(*u >= actuator.lower - 1e-6 && *u <= actuator.upper + 1e-6);
    }
    let bound = 0.5 / 2.0_f64.sqrt() * found.normal + 1e-6;
    assert!(found.force.xy().amax() <= bound && found.force.z == found.normal);
}

#[test]
fn laws() {
    let robot = othex().expect("ships");
    let level = push(&robot, &robot.home, &[]).normal;
    // Weaker, or heavier at the same thrust, is less; a load towards the wall is as much more.
    let weaker = mismatched(&robot, 1.0, 0.9);
    assert!(push(&weaker, &weaker.home, &[]).normal < level);
    let away = push(&robot, &robot.home, &[disturbance(&robot)]).normal;
    assert!(away < level);
    // Where the robot is does not matter.
    let mut elsewhere = robot.home.clone();
    elsewhere.p_WR = Vector3::new(3.0, -2.0, 5.0);
    elsewhere.v.fill(0.3);
    assert!((push(&robot, &elsewhere, &[]).normal - level).abs() < 1e-6);
    // The contact's own limit counts.
    let soft = ContactSpec {
        force_max: 2.0,
        ..tip()
    };
    let found = largest_push(&robot, &robot.home, &soft, &[], &[]).expect("is a problem");
    assert!((found.expect("exists").normal - 2.0).abs() < 1e-6);
    // Too heavy to hover: it could stand on the ground.
    let heavy = mismatched(&robot, 3.0, 1.0);
    let alone = largest_push(&heavy, &heavy.home, &tip(), &[], &[]).expect("is a problem");
    assert_eq!(alone, None);
    let mut feet = Vec::new();
    for rotor in ["rotor_1", "rotor_3", "rotor_4", "rotor_6"] {
        let mut foot = tip();
        rotor.clone_into(&mut foot.name);
        rotor.clone_into(&mut foot.frame);
        foot.surface.normal = [0.0, 0.0, 1.0];
        foot.surface.x_axis = [1.0, 0.0, 0.0];
        feet.push(foot);
    }
    let standing = largest_push(&heavy, &heavy.home, &tip(), &feet, &[]).expect("is a problem");
    assert!(standing.expect("can stand").normal > 10.0);
    let unknown = ContactSpec {
        frame: "toll".into(),
        ..tip()
    };
    assert!(largest_push(&robot, &robot.home, &unknown, &[], &[]).is_err());
}

#[test]
fn a_robot_without_lateral_thrust_leans() {
    let robot = othex_vertical().expect("ships");
    let found = push(&robot, &robot.home, &[]);
    let (normal, degrees) = (found.normal, found.tilt.to_degrees());
    println!("twin: {normal:.2} N, leaning {degrees:.2}°");
    assert!(normal > 5.0 && degrees > 5.0 && degrees <= 20.0 + 1e-9);
    // Along the wall there is no thrust: F = f_n of the whole thrust, m g tan θ without friction.
    let mut sliding = tip();
    sliding.kind = wbqp::contact::ContactKind::Normal;
    let slid = largest_push(&robot, &robot.home, &sliding, &[], &[]).expect("is a problem");
    let slid = slid.expect("has an equilibrium");
    let weight = robot.model.mass() * 9.81;
    assert!(
        (slid.normal - weight * slid.tilt.tan()).abs() < 1e-3,
        "{slid:?}"
    );
    // The tilted rotors' robot need not.
    let othex = othex().expect("ships");
    assert_eq!(push(&othex, &othex.home, &[]).tilt, 0.0);
}

fn scenario(variation: &str) -> Result<Scenario, String> {
    let file = scenarios().join("push_with_disturbance.toml");
    let variation = Variation::from_toml(variation).expect("is TOML");
    let scenario = Scenario::from_file(&file).expect("ships");
    let controller = scenarios().join("push_with_disturbance.controller.toml");
    let named = |error: String| {
        let error = error.replace(&file.display().to_string(), "s.toml");
        error.replace(&controller.display().to_string(), "c.toml")
    };
    scenario
        .varied(&variation)
        .map_err(|e| named(e.to_string()))
}

const WEAK: &str = "change.plant.mismatch = { mass_scale = 1.05, thrust_scale = 0.85 }\n";

#[test]
fn a_scenario_that_asks_for_too_much() {
    assert_eq!(
        scenario(WEAK).expect_err("is too weak"),
        "c.toml:56:1: task `contact_force` pushes on contact `tip`: 5.0 N asked, 4.5 N possible: `rotor_1`, `rotor_6` \
         are at their largest effort, friction of 0.5 is used up"
    );
    let asked = |force: &str| {
        format!("{WEAK}set.task.contact_force.reference = {{ type = \"hold\", value = [{force}] }}")
    };
    let scenario_4 = scenario(&asked("4.4")).expect("is possible");
    scenario(&asked("4.6")).expect_err("is not");
    let case = scenario_4.case("with_ft").expect("exists");
    let found = case.push_limit("tip", &[]).expect("exists");
    let found = found.expect("has an equilibrium").normal;
    assert!((found - 4.5).abs() <= 0.05, "{found}");
    let disturbed = case
        .push_limit("tip", &case.plant().disturbances)
        .expect("exists");
    assert!(disturbed.is_none_or(|d| d.normal < found));
    let message = case.push_limit("top", &[]).expect_err("does not exist");
    assert!(message.to_string().contains("no contact `top`"));

    // Nobody asks if the task is off or has no weight.
    scenario(&format!(
        "{WEAK}set.task.contact_force.weight = [1e-3, 1e-3, 0.0]"
    ))
    .expect_err("has weights on the tangential force");
    scenario(&format!("{WEAK}set.task.contact_force.weight = 0.0")).expect("asks for nothing");
    scenario(&format!("{WEAK}set.task.contact_force.active = false")).expect("is off");
    // A surface that no wall is like is the reason then, whatever else is at its limit.
    let turned =
        "set.contact.tip.surface = { normal = [0.0, 0.0, -1.0], x_axis = [1.0, 0.0, 0.0] }";
    let refused = scenario(&format!("{}\n{turned}", asked("19.9"))).expect_err("is too weak");
    assert!(refused.contains(" N asked, "), "{refused}");
    assert!(
        refused.contains(
            " possible: contact `tip`: its surface has the normal [0.0, 0.0, -1.0], and no wall"
        ),
        "{refused}"
    );
    // A force that the contact cannot have while it is on.
    let refused = scenario("set.contact.tip.force_min = 6.0").expect_err("is below");
    assert!(
        refused.contains("asks for 5.0 N at contact `tip`, which pushes with 6.0 N at the least"),
        "{refused}"
    );
    scenario("set.contact.tip.force_min = 5.0").expect("is just possible");
    // A robot whose rotors have other limits, in controller and plant alike.
    let strong = scenario("set.robot.thrust_max = 12.0").expect("is possible");
    let case = strong.case("with_ft").expect("exists");
    let found = case.push_limit("tip", &[]).expect("exists");
    println!("f_max 12 N: {:.2} N", found.expect("has one").normal);
    assert!(scenario("set.robot.thrust_max = 7.0").is_err());
}

#[test]
fn an_event_that_asks_for_too_much() {
    let follow = |to: f64| {
        let reference = format!("{{ type = \"min_jerk\", to = [{to}], duration = 1.0 }}");
        format!("change.event.approach.follow.contact_force = {reference}")
    };
    scenario(&follow(7.5)).expect("is possible");
    assert_eq!(
        scenario(&follow(9.0)).expect_err("is too much"),
        "s.toml:51:1: task `contact_force` pushes on contact `tip`: 9.0 N asked, 7.9 N possible: `rotor_1`, `rotor_6` \
         are at their largest effort, friction of 0.5 is used up"
    );
}

#[test]
fn an_under_actuated_scenario_loads() {
    let twin = |force: f64| {
        let hold = toml::Table::from_iter([
            ("type".to_owned(), toml::Value::from("hold")),
            ("value".to_owned(), toml::Value::from(vec![force])),
        ]);
        let variation = Variation::new()
            .set("robot.type", "othex_vertical")
            .set("task.contact_force.reference", hold);
        let file = scenarios().join("push_with_disturbance.toml");
        Scenario::from_file(&file)
            .expect("ships")
            .varied(&variation)
    };
    twin(5.0).expect("5 N is possible");
    assert!(twin(30.0).is_err());
}

#[test]
fn a_share_of_the_limit_can_be_asked_of_any_plant() {
    let plant = "change.plant.mismatch = { mass_scale = 1.05, thrust_scale = 0.9 }\n";
    let with = |force: f64| {
        scenario(&format!(
            "{plant}set.task.contact_force.reference = {{ type = \"hold\", value = [{force}] }}"
        ))
    };
    // A small set point is accepted whatever the plant, and the limit does not depend on it.
    let small = with(0.1).expect("is possible");
    let case = small.case("with_ft").expect("exists");
    let limit = case.push_limit("tip", &[]).expect("exists");
    let limit = limit.expect("has an equilibrium").normal;
    println!("motors −10 %, mass +5 %: {limit:.2} N");
    with(0.8 * limit).expect("is possible");
    with(limit + 0.1).expect_err("is not");
}
