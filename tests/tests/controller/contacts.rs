//! What is known of a contact in a tick: its sensor's zero, the surface's motion, and its force before there is one.
#![allow(non_snake_case)]

use std::fs;

use wbqp::{
    Controller,
    contact::SurfaceMotion,
    controller::FallbackLevel,
    nalgebra::{Rotation3, Vector3, Vector6},
};
use wbqp_robots as _;
use wbqp_tests::{
    files::{scenarios, workspace},
    small::controller_of,
};

/// The aerial manipulator at its wall, which may begin anywhere.
fn pushing() -> Controller {
    let file = scenarios().join("push_with_disturbance.controller.toml");
    let text = fs::read_to_string(file).expect("ships");
    let anywhere = "rate = 250.0\nmax_first_error = { position = inf, rotation = inf }";
    controller_of(&text.replace("rate = 250.0", anywhere))
}

#[test]
fn a_constant_reading_is_the_zero_from_the_first_tick_on() {
    for ticks in [1, 25, 125] {
        let mut controller = pushing();
        let mut measurement = controller.measurement();
        measurement.wrenches[0] = Vector6::new(0.1, -0.2, 1.0, 0.01, 0.0, 0.02);
        for k in 0..ticks {
            measurement.time = 0.004 * f64::from(k);
            controller.tick(&measurement);
        }
        assert!(controller.report().contacts[0].measured.norm() > 1.0);
        controller.tare("tip").expect("is there");
        measurement.time += 0.004;
        controller.tick(&measurement);
        let left = controller.report().contacts[0].measured.norm();
        assert!(left < 1e-12, "{left} N after {ticks} ticks");
    }
}

/// A tool that slides on a door that turns, by differences of where it is.
#[test]
fn a_point_that_slides_on_a_turning_surface_is_accelerated_by_coriolis_too() {
    let mut controller = pushing();
    let tip = controller.contact("tip").expect("is there");
    let R_WC = controller.contact_state(tip).R_WC;
    let mut measurement = controller.measurement();
    controller.tick(&measurement);
    let state = controller.contact_state(tip);
    let p_WE = state.p_WS + state.R_WC * state.p_SC;
    let (speed, slide) = (1.3, Vector3::new(-0.1, 0.2, 0.0));
    let turned = |t: f64| Rotation3::from_axis_angle(&Vector3::z_axis(), speed * t) * R_WC;
    let at = |t: f64| turned(t) * (R_WC.inverse() * p_WE + slide * t);
    let h = 1e-3;
    let (before, now, after) = (at(-h), at(0.0), at(h));
    let velocity = (after - before) / (2.0 * h);
    let acceleration = R_WC.inverse() * ((after - now) - (now - before)) / (h * h);
    measurement.time = 0.004;
    measurement
        .state
        .v
        .fixed_rows_mut::<3>(0)
        .copy_from(&velocity);
    let door = SurfaceMotion {
        w_WC: Vector3::z() * speed,
        ..SurfaceMotion::fixed(R_WC, Vector3::zeros())
    };
    controller.move_surface("tip", &door).expect("is there");
    controller.tick(&measurement);
    let state = controller.contact_state(tip);
    let V = state.V.fixed_rows::<3>(0);
    assert!((V - slide).norm() < 1e-6, "{V}");
    let given = state.surface_acceleration.fixed_rows::<3>(0);
    assert!(
        (given - acceleration).norm() < 1e-6,
        "{given} {acceleration}"
    );
}

/// The relative angular velocity stays in C axes what it is if the tool is turned by `w_WC × w_WE` besides.
#[test]
fn a_tool_that_turns_on_a_turning_surface_has_a_gyroscopic_acceleration() {
    let mut controller = pushing();
    let tip = controller.contact("tip").expect("is there");
    let R_WC = controller.contact_state(tip).R_WC;
    let mut measurement = controller.measurement();
    let (w_WC, w_WE) = (Vector3::new(0.3, -0.2, 0.5), Vector3::new(-0.4, 0.1, 0.2));
    measurement.state.v.fixed_rows_mut::<3>(3).copy_from(&w_WE);
    let surface = SurfaceMotion {
        w_WC,
        ..SurfaceMotion::fixed(R_WC, Vector3::zeros())
    };
    controller.move_surface("tip", &surface).expect("is there");
    controller.tick(&measurement);
    let given = controller.contact_state(tip).surface_acceleration;
    // d/dt of R_CW (w_WE − w_WC) with both constant in the world, less the change of w_WE that keeps it.
    let h = 1e-4;
    let axes = |t: f64| Rotation3::new(w_WC * t) * R_WC;
    let relative = |t: f64| axes(t).inverse() * (w_WE - w_WC);
    let drift = (relative(h) - relative(-h)) / (2.0 * h);
    let sum = drift + given.fixed_rows::<3>(3);
    assert!(sum.norm() < 1e-6, "{sum}");
}

/// Without a solution so far, a foot that is switched off is unloaded along its ramp all the same.
#[test]
fn a_contact_that_is_switched_off_before_the_first_tick_unloads_along_its_ramp() {
    let file = workspace("examples/tutorials/quadruped.controller.toml");
    let mut controller = Controller::from_file(file).expect("ships");
    let mut measurement = controller.measurement();
    let foot = controller.contact_names().next().map(str::to_owned);
    let foot = foot.expect("has feet");
    controller.deactivate_contact(&foot).expect("is there");
    let mut forces = Vec::new();
    for _ in 0..100 {
        measurement.time += 0.004;
        let (_, report) = controller.tick(&measurement);
        assert_eq!(report.level, FallbackLevel::Optimal);
        forces.push(report.contacts[0].solution[2]);
    }
    assert!(forces[0] > 2.0 && forces[99] == 0.0, "{forces:?}");
    let jumps = forces.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    assert!(jumps.fold(0.0, f64::max) < 1.0, "{forces:?}");
}

/// While its sensor says nothing usable, a contact is let go all the same, and what was planned for it with it.
#[test]
fn a_contact_that_is_let_go_without_its_wrench_pushes_no_more() {
    let mut controller = pushing();
    let tip = controller.contact("tip").expect("is there");
    controller.activate_contact("tip").expect("is there");
    let mut measurement = controller.measurement();
    for k in 0..500 {
        measurement.time = 0.004 * f64::from(k);
        controller.tick(&measurement);
    }
    assert!(controller.contact_state(tip).solution.norm() > 0.1);
    controller.deactivate_contact("tip").expect("is there");
    measurement.wrenches[0][0] = f64::NAN;
    for _ in 0..500 {
        measurement.time += 0.004;
        controller.tick(&measurement);
    }
    let state = controller.contact_state(tip);
    assert_eq!((state.alpha, state.live), (0.0, false));
    assert_eq!(state.solution, Vector6::zeros());
    assert_eq!(state.set_point, Vector3::zeros());
}

/// A soft inequality on one side has a row for the other, too, which limits nothing: no solution is at its limit.
#[test]
fn a_limit_that_is_none_is_not_active() {
    let feet = fs::read_to_string(workspace("examples/tutorials/quadruped.controller.toml"));
    let text = feet.expect("ships").replace(
        "[controller]",
        "[[constraint]]\ntype = \"tilt_limit\"\nmax_tilt = 0.3\nhardness = \"soft\"\nweight = 10.0\n[controller]",
    );
    let mut controller = controller_of(&text);
    let measurement = controller.measurement();
    let (_, report) = controller.tick(&measurement);
    assert_eq!(report.level, FallbackLevel::Optimal);
    for row in &report.active {
        assert!(
            row.limit.is_finite(),
            "{:?} {row:?}",
            report.row(row.row).map(|row| &row.label)
        );
    }
}
