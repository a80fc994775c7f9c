//! Contacts that must not move determine accelerations: fewer variables, also where a leg is stretched, and a
//! contradiction names their rows like all others. That the optimum is the same everywhere is tested in
//! `properties`.

use wbqp::{
    controller::{Controller, FallbackLevel, Measurement},
    nalgebra::Vector6,
    plugin::{Entry, Hardness},
    settings::Formulation,
};
use wbqp_tasks::{BasePosition, Hold, Posture};
use wbqp_tests::scenes::{Kind, Scene};

fn hard(kind: Kind, seed: u64, tasks: u32, contacts: u32) -> Scene {
    let mut scene = Scene::new(kind, seed, tasks, contacts);
    scene.hard_contacts = true;
    scene
}

fn ticked(scene: &Scene, formulation: Formulation, measurement: &Measurement) -> Controller {
    let scene = Scene {
        formulation,
        ..scene.clone()
    };
    let mut controller = scene.controller();
    controller.tick(measurement);
    controller
}

/// Variables and rows.
fn size(controller: &Controller) -> [usize; 2] {
    [controller.problem().n(), controller.problem().m()]
}

/// Largest difference of two commands and accelerations, relative.
fn difference(a: &Controller, b: &Controller) -> f64 {
    let vdot = (&a.report().vdot - &b.report().vdot).amax() / (1.0 + a.report().vdot.amax());
    let efforts = a.command().effort.iter().zip(&b.command().effort);
    let efforts = efforts.map(|(a, b)| (a - b).abs() / (1.0 + a.abs()));
    efforts.fold(vdot, f64::max)
}

/// A quadruped on all fours and on three legs: what is left are the forces, and a leg in the air.
#[test]
fn the_contacts_rows_are_not_in_the_problem() {
    for (contacts, accelerations, feet) in [(0b1111, 0, 4), (0b1011, 3, 3), (0, 12, 0)] {
        let scene = hard(Kind::Quadruped, 3, u32::MAX, contacts);
        let auto = ticked(&scene, Formulation::Auto, &scene.measurement());
        assert_eq!(auto.report().level, FallbackLevel::Optimal);
        let cones_and_torques = 4 * feet + 12;
        assert_eq!(
            size(&auto),
            [accelerations + 3 * feet, cones_and_torques],
            "{contacts:b}"
        );
    }
}

/// Through a stretched leg: next to it the contact keeps its rows, and the optimum is the explicit one everywhere.
#[test]
fn a_stretched_leg_keeps_its_contacts_rows() {
    let scene = hard(Kind::Quadruped, 5, u32::MAX, 0b1111);
    let robot = scene.robot();
    let knee = robot
        .model
        .joints()
        .iter()
        .position(|joint| joint.name == "fl_knee")
        .expect("the leg has a knee");
    let mut sizes = Vec::new();
    for step in -120..=120 {
        let bend = 0.0025 * f64::from(step);
        let mut measurement = scene.measurement();
        measurement.state.q[knee] = bend;
        measurement.state.v.fill(0.0);
        measurement.wrenches.fill(Vector6::zeros());
        let explicit = ticked(&scene, Formulation::Explicit, &measurement);
        let auto = ticked(&scene, Formulation::Auto, &measurement);
        assert_eq!(explicit.report().level, auto.report().level, "{bend}");
        if auto.report().level == FallbackLevel::Optimal {
            let difference = difference(&explicit, &auto);
            assert!(difference < 1e-5, "{bend}: {difference:e}");
        }
        sizes.push(size(&auto)[0]);
    }
    sizes.dedup();
    assert_eq!(sizes, [12, 15, 12]);
}

/// Ticks on both sides of a switch, warm started from one another.
#[test]
fn feet_that_lift_and_land_change_nothing_else() {
    let scene = hard(Kind::Quadruped, 9, u32::MAX, 0b1111);
    let run = |formulation| {
        let scene = Scene {
            formulation,
            ..scene.clone()
        };
        scene.controller()
    };
    let (mut auto, mut explicit) = (run(Formulation::Auto), run(Formulation::Explicit));
    let mut measurement = scene.measurement();
    let mut sizes = std::collections::BTreeSet::new();
    for tick in 0..200_u32 {
        measurement.time = f64::from(tick) * 0.004;
        measurement.state.v[0] = 0.1 * (f64::from(tick) * 0.1).sin();
        let foot = format!("contact_{}", tick / 10 % 4);
        for controller in [&mut auto, &mut explicit] {
            match tick % 10 {
                2 => controller.deactivate_contact(&foot),
                7 => controller.activate_contact(&foot),
                _ => Ok(()),
            }
            .expect("the contact exists");
            controller.tick(&measurement);
            assert_eq!(
                controller.report().level,
                FallbackLevel::Optimal,
                "tick {tick}"
            );
        }
        let difference = difference(&explicit, &auto);
        assert!(difference < 1e-5, "tick {tick}: {difference:e}");
        sizes.insert(size(&auto)[0]);
    }
    // A foot in the air has three accelerations instead of three forces.
    assert_eq!(Vec::from_iter(sizes), [12]);
}

/// A base that must accelerate one way while its feet must stand, and its legs must not bend.
#[test]
fn a_contradiction_names_the_contacts_rows() {
    let scene = hard(Kind::Quadruped, 3, 0, 0b1111);
    let explain = |formulation| {
        let mut config = Scene {
            formulation,
            ..scene.clone()
        }
        .config();
        let away = Hold::at([1.0, 0.0, 0.0]);
        let base = Box::new(BasePosition::new(10.0, 1.0).following(away));
        let stiff = Box::new(Posture::new(0.0, 0.0));
        config
            .tasks
            .push(Entry::new("push", 1.0, Hardness::Hard, base));
        config
            .tasks
            .push(Entry::new("stiff", 1.0, Hardness::Hard, stiff));
        let mut controller = Controller::new(config).expect("the scene is valid");
        controller.tick(&scene.measurement());
        controller
    };
    for formulation in [Formulation::Auto, Formulation::Explicit] {
        let controller = explain(formulation);
        let report = controller.report();
        assert_eq!(report.level, FallbackLevel::Relaxed, "{formulation:?}");
        let why = controller.explain().expect("not optimal");
        let (conflict, _) = why.split_once("given up:").expect("something was");
        for name in ["motion_", "push", "stiff"] {
            assert!(
                conflict.contains(name),
                "{formulation:?}: no {name} in {why}"
            );
        }
    }
}
