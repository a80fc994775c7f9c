//! Robots of one body: problems without variables, and what the law of last resort holds.

use wbqp::{
    Controller, actuator::ActuatorKind, controller::FallbackLevel, dynamics::Data, fault::Fault,
    nalgebra::DVector, robot::RobotModel, state::State,
};
use wbqp_robots as _;
use wbqp_tests::{
    files::workspace,
    small::{BODY, PENDULUM, controller, controller_of},
};

/// A hinge without a motor falls faster than it may: nothing can be done about it, and there is nothing to choose.
#[test]
fn a_contradiction_without_variables_ends_on_a_level() {
    let limits = "[[constraint]]\ntype = \"joint_limits\"\nacceleration = 10.0";
    for formulation in ["auto", "condensed", "torque_eliminated", "explicit"] {
        let settings = format!("formulation = {formulation:?}");
        let robot = "base = \"fixed\"\noptions.passive = [\"hinge\"]";
        let mut controller = controller(PENDULUM, &settings, robot, limits);
        let mut measurement = controller.measurement();
        for _ in 0..3 {
            let (_, report) = controller.tick(&measurement);
            assert_ne!(report.level, FallbackLevel::Optimal, "{formulation}");
            assert_eq!(report.fault, Some(Fault::Infeasible), "{formulation}");
            measurement.time += 0.004;
        }
    }
    let limit = "[[constraint]]\ntype = \"tilt_limit\"\nmax_tilt = 0.3";
    let mut controller = controller(BODY, "hover = \"unchecked\"", "", limit);
    let mut measurement = controller.measurement();
    controller.tick(&measurement);
    measurement.state.v[3] = 2.9;
    measurement.time = 0.004;
    let (_, report) = controller.tick(&measurement);
    assert_eq!(report.fault, Some(Fault::Infeasible));
}

/// `g` at the joint, N·m: what holds it.
fn weight_at(controller: &Controller, angle: f64) -> f64 {
    let model = &controller.robot().model;
    let mut state = controller.robot().home.clone();
    state.q[0] = angle;
    let mut data = Data::new(model);
    data.update(model, &state);
    data.gravity()[0]
}

fn refused_pendulum() -> Controller {
    // At 1.2 rad nothing is to move: the first error is too large.
    let task =
        "[[task]]\ntype = \"posture\"\nkp = 25.0\nreference = { type = \"hold\", value = [0.0] }";
    controller(PENDULUM, "", "base = \"fixed\"", task)
}

#[test]
fn the_law_holds_where_the_robot_is_once_that_is_known() {
    let mut controller = refused_pendulum();
    let mut measurement = controller.measurement();
    measurement.state.q[0] = f64::NAN;
    controller.tick(&measurement);
    measurement.state.q[0] = 1.2;
    for _ in 0..3 {
        measurement.time += 0.004;
        let (command, report) = controller.tick(&measurement);
        assert_eq!(report.level, FallbackLevel::Safe);
        assert!(matches!(report.fault, Some(Fault::FirstError(_))));
        let effort = command.effort[0];
        let weight = weight_at(&controller, 1.2);
        assert!((effort - weight).abs() < 1e-9, "{effort} {weight}");
    }
}

#[test]
fn after_a_reset_the_law_holds_where_the_robot_is_then() {
    let mut controller = refused_pendulum();
    let mut measurement = controller.measurement();
    measurement.state.q[0] = 1.2;
    controller.tick(&measurement);
    measurement.state.q[0] = -1.4;
    measurement.time = 0.004;
    controller.reset(&measurement).expect("is plausible");
    let (command, report) = controller.tick(&measurement);
    assert_eq!(report.level, FallbackLevel::Safe);
    let effort = command.effort[0];
    let weight = weight_at(&controller, -1.4);
    assert!((effort - weight).abs() < 1e-9, "{effort} {weight}");
}

/// Accelerations under these efforts, without contacts.
fn accelerations(robot: &RobotModel, state: &State, effort: &[f64]) -> DVector<f64> {
    let model = &robot.model;
    let mut data = Data::new(model);
    data.update(model, state);
    let mut force = -data.bias().clone();
    for (actuator, effort) in robot.actuators.iter().zip(effort) {
        if let ActuatorKind::Joint(motor) = &actuator.kind {
            force[model.velocity_index(motor.joint).index()] += effort;
        }
    }
    let mass = data.mass_matrix().clone();
    mass.cholesky().expect("is definite").solve(&force)
}

/// In the air the joints of a legged robot have nothing to carry.
#[test]
fn the_law_does_not_throw_the_legs_of_a_robot_that_falls() {
    let file = workspace("examples/tutorials/quadruped.controller.toml");
    let mut controller = Controller::from_file(file).expect("ships");
    let mut measurement = controller.measurement();
    controller.tick(&measurement);
    let feet: Vec<String> = controller.contact_names().map(str::to_owned).collect();
    for foot in &feet {
        controller.deactivate_contact(foot).expect("is there");
    }
    for _ in 0..100 {
        measurement.time += 0.004;
        controller.tick(&measurement);
    }
    measurement.wrenches[0][0] = f64::NAN;
    for _ in 0..10 {
        measurement.time += 0.004;
        controller.tick(&measurement);
    }
    assert_eq!(controller.report().level, FallbackLevel::Safe);
    let efforts = &controller.command().effort;
    let vdot = accelerations(controller.robot(), &measurement.state, efforts);
    assert!((vdot[2] + 9.81).abs() < 1e-6, "{}", vdot[2]);
    let fastest = vdot.rows(6, 12).amax();
    assert!(fastest < 1e-6, "{fastest} rad/s²");
}

/// The floor asks for more than the rotors can give, and the ceiling for less than the floor: what is declared first
/// is kept.
#[test]
fn limits_go_in_the_order_that_is_declared() {
    let plane = |name: &str, z: f64, up: f64, margin: f64| {
        format!(
            "[[constraint]]\ntype = \"plane_distance\"\nname = {name:?}\nframe = \"base_link\"\n\
             point = [0.0, 0.0, {z:?}]\nnormal = [0.0, 0.0, {up:?}]\nmargin = {margin:?}\n"
        )
    };
    let (floor, ceiling) = (
        plane("floor", 0.0, 1.0, 2.0),
        plane("ceiling", 1.7, -1.0, 0.1),
    );
    for planes in [format!("{floor}{ceiling}"), format!("{ceiling}{floor}")] {
        for formulation in ["condensed", "torque_eliminated", "explicit"] {
            let mut controller = controller_of(&format!(
                "[controller]\nrate = 500.0\nformulation = {formulation:?}\n[robot]\ntype = \"othex\"\n[[task]]\n\
                 type = \"base_position\"\nkp = 6.0\n[[task]]\ntype = \"base_orientation\"\nkp = 60.0\n[[task]]\n\
                 type = \"posture\"\nkp = 20.0\n[[constraint]]\ntype = \"joint_limits\"\n{planes}"
            ));
            let measurement = controller.measurement();
            let (_, report) = controller.tick(&measurement);
            assert_eq!(report.level, FallbackLevel::Relaxed);
            let owner = |row| report.row(row).map(|row| row.owner.as_str());
            let relaxed: Vec<_> = report.relaxed.iter().map(|r| owner(r.row)).collect();
            let expected = [Some("floor")];
            assert_eq!(relaxed, expected, "{formulation}, {planes}");
        }
    }
}

/// A reference for the attitude of a base that flies, where there is none: level, and no base to look at.
#[test]
fn a_thrust_attitude_without_a_base_that_moves_is_level() {
    let task = "[[task]]\ntype = \"frame_orientation\"\nframe = \"arm\"\nkp = 9.0\n\
                reference = { type = \"thrust_attitude\" }";
    let mut controller = controller(PENDULUM, "", "base = \"fixed\"", task);
    let mut measurement = controller.measurement();
    for _ in 0..50 {
        let (_, report) = controller.tick(&measurement);
        assert_eq!(report.level, FallbackLevel::Optimal);
        measurement.time += 0.004;
    }
}
