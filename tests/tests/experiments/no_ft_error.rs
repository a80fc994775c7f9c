//! Without force feedback a disturbance stays in the contact force. How much of it, against a closed formula.
//!
//! # Mathematics
//! Joints are servoed: only the six equations of the base count. b marks the base's part of the mass matrix, of
//! the contact point's Jacobian `J_c` (C axes) and of the disturbed point's `J_d` (world axes). The controller's
//! problem and the plant at rest agree on `h` and on `u`:
//! ```text
//! M_bb v̇_b + M_bA v̇_A + h_b = S_b u + J_cbᵀ f_QP
//!                        h_b = S_b u + J_cbᵀ f_m + J_dbᵀ f_d
//! ```
//! so that, with `Λ = (J_cb M_bb⁻¹ J_cbᵀ)⁻¹` and the acceleration that the problem predicts in vain,
//! ```text
//! f_QP − f_m = Λ [J_cb M_bb⁻¹ J_dbᵀ f_d + ρ],   ρ = J_cb (v̇_b + M_bb⁻¹ M_bA v̇_A)
//! ```
#![allow(non_snake_case)]

use std::fs;

use wbqp::{
    config::{ControllerConfig, Overrides},
    contact::Detector,
    controller::Controller,
    dynamics::{Data, FrameKinematics},
    nalgebra::{DVector, Vector3},
    toml,
};
use wbqp_robots as _;
use wbqp_sim::{PlantConfig, SensorsConfig, sensors::ForceTorqueConfig};
use wbqp_tasks::MinJerk;
use wbqp_tests::{closed_loop::ClosedLoop, files::scenarios};

/// Disturbance at the base's origin, N, world.
const DISTURBANCE: [f64; 3] = [-3.5, 0.0, 0.0];
/// When it begins, s.
const START: f64 = 12.0;
/// Time to settle, then time to average over, s.
const SETTLE: f64 = 20.0;
const AVERAGE: f64 = 2.0;

fn closed_loop() -> ClosedLoop {
    let directory = scenarios();
    let file = directory.join("push_with_disturbance");
    let text = fs::read_to_string(file.with_extension("toml")).expect("ships");
    let scenario: toml::Table = toml::from_str(&text).expect("is TOML");
    let mut plant: PlantConfig = scenario["plant"].clone().try_into().expect("is a plant");
    let overrides = Overrides::new().with("task.contact_force.feedback", "off");
    let config =
        ControllerConfig::from_file_with(file.with_extension("controller.toml"), &overrides)
            .expect("ships");
    let controller = Controller::new(config).expect("fits the robot");
    let mut initial = controller.robot().home.clone();
    initial.p_WR = Vector3::new(-0.5, 0.0, 1.258);
    assert_eq!(plant.disturbances[0].force, DISTURBANCE);
    assert_eq!(plant.disturbances[0].frame, "base_link");
    plant.disturbances[0].from = START;
    plant.disturbances[0].until = f64::INFINITY;
    let sensors = SensorsConfig {
        force_torque: vec![ForceTorqueConfig::new("tool")],
        ..SensorsConfig::default()
    };
    let mut running =
        ClosedLoop::new(controller, &plant, &sensors, initial).expect("can be simulated");
    running.detector = Some(Detector::new("tip"));
    running
}

/// Runs until a time, s.
fn run_until(running: &mut ClosedLoop, time: f64) {
    while running.time() < time - 1e-9 {
        running.step().expect("the plant moves on");
    }
}

#[test]
fn the_error_is_the_formulas() {
    let mut running = closed_loop();
    run_until(&mut running, 1.0);
    let approach = MinJerk::new([-0.0688, 0.0, 1.258], 6.0);
    running
        .controller
        .follow("base_position", approach)
        .expect("follows");
    run_until(&mut running, START);
    let before = running.controller.report().contacts[0];
    assert!(before.on && before.alpha == 1.0);

    run_until(&mut running, START + SETTLE);
    let (mut solution, mut measured) = (Vector3::zeros(), Vector3::zeros());
    let mut vdot = DVector::zeros(running.plant.model().nv());
    let (mut speed, mut acceleration, mut ticks): (f64, f64, f64) = (0.0, 0.0, 0.0);
    while running.time() < START + SETTLE + AVERAGE {
        running.step().expect("the plant moves on");
        let report = running.controller.report();
        solution += report.contacts[0].solution.fixed_rows::<3>(0);
        measured += report.contacts[0].measured.fixed_rows::<3>(0);
        vdot += &report.vdot;
        speed = speed.max(running.plant.state().v.amax());
        acceleration = acceleration.max(running.plant.acceleration().amax());
        ticks += 1.0;
    }
    let (solution, measured, vdot) = (solution / ticks, measured / ticks, vdot / ticks);
    println!("fastest {speed:.1e}, largest acceleration {acceleration:.1e}");
    assert!(speed < 1e-6 && acceleration < 1e-6, "has settled");

    let controller = &running.controller;
    let model = &controller.robot().model;
    let mut data = Data::new(model);
    data.update(model, running.plant.state());
    let mut base = FrameKinematics::new(model);
    base.update(model, &data, model.frame("base_link").expect("exists"));
    let tip = controller.contact_state(controller.contact("tip").expect("exists"));
    let M = data.mass_matrix();
    let M_bb = M.view((0, 0), (6, 6)).into_owned();
    let M_bA = M.view((0, 6), (6, M.ncols() - 6));
    let J_cb = tip.J.view((0, 0), (3, 6));
    let J_db = base.J.view((0, 0), (3, 6));
    let inverse = M_bb.try_inverse().expect("regular");
    let lambda = (J_cb * &inverse * J_cb.transpose())
        .try_inverse()
        .expect("regular");
    let rho = J_cb * (vdot.rows(0, 6) + &inverse * M_bA * vdot.rows(6, M.ncols() - 6));
    let pushed = J_cb * &inverse * J_db.transpose() * Vector3::from(DISTURBANCE);
    let predicted = &lambda * (&pushed + &rho);
    let error = solution - measured;
    println!(
        "f_QP {:?}\nf_m  {:?}",
        solution.as_slice(),
        measured.as_slice()
    );
    println!(
        "f_QP − f_m {:?}\nformula    {:?}\n(of which ρ {:?})",
        error.as_slice(),
        predicted.as_slice(),
        (&lambda * &rho).as_slice(),
    );
    println!("off by {:.1e} N", (&predicted - error).amax());
    // Settled, without noise and mismatch, the formula is exact: only rounding and the solver's tolerance are left.
    assert!((&predicted - error).amax() < 1e-6);
    assert!((0.6..=1.4).contains(&(5.0 - measured.z).abs()));
}
