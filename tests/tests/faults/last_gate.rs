//! Whatever is measured, asked or weighted, by any power of ten: every command is finite, within every limit and within
//! the slew of the one before, compared exactly; and where the solution is not, the tick does not call itself optimal.
//!
//! `WBQP_LIVES` says how many random scenes are run, 400 if it is not set, with [`LIFE`] ticks each.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use wbqp::{
    controller::{Command, Controller, FallbackLevel, Measurement},
    fault::Fault,
    nalgebra::Vector6,
    plugin::{AnyConstraint, Entry, Hardness},
    robot::RobotModel,
    settings::{Formulation, MeasurementLimits},
};
use wbqp_tasks::{BaseOrientation, BasePosition, ContactForce, FreeMotion, Hold, Posture};
use wbqp_tests::{
    adversary::is_within_bounds,
    scenes::{KINDS, Kind, Scene},
};

/// Ticks of one controller.
const LIFE: usize = 12;
const PERIOD: f64 = 0.004;

fn lives() -> usize {
    let given = std::env::var("WBQP_LIVES").ok();
    given.map_or(400, |n| n.parse().expect("a number of scenes"))
}

/// What is multiplied by a power of ten.
#[derive(Clone, Copy, Debug)]
enum Scaled {
    BasePosition,
    BaseVelocity,
    JointPositions,
    JointVelocities,
    Wrenches,
    References,
    Gains,
    Weights,
}

const ALL: [Scaled; 8] = [
    Scaled::BasePosition,
    Scaled::BaseVelocity,
    Scaled::JointPositions,
    Scaled::JointVelocities,
    Scaled::Wrenches,
    Scaled::References,
    Scaled::Gains,
    Scaled::Weights,
];

/// What is scaled, and by which power.
type Change = (Scaled, i32);

fn factor(changes: &[Change], is_it: impl Fn(Scaled) -> bool) -> f64 {
    let powers = changes.iter().filter(|(what, _)| is_it(*what));
    powers.map(|(_, power)| 10_f64.powi(*power)).product()
}

fn scale(measurement: &mut Measurement, changes: &[Change]) {
    let by = |is_it: fn(Scaled) -> bool| factor(changes, is_it);
    let state = &mut measurement.state;
    let base = state.v.len() - state.q.len();
    state.p_WR *= by(|s| matches!(s, Scaled::BasePosition));
    state.q *= by(|s| matches!(s, Scaled::JointPositions));
    let speed = by(|s| matches!(s, Scaled::BaseVelocity));
    state.v.rows_mut(0, base).scale_mut(speed);
    let speed = by(|s| matches!(s, Scaled::JointVelocities));
    let joints = state.q.len();
    state.v.rows_mut(base, joints).scale_mut(speed);
    let force = by(|s| matches!(s, Scaled::Wrenches));
    measurement
        .wrenches
        .iter_mut()
        .for_each(|wrench: &mut Vector6<f64>| *wrench *= force);
}

/// Scales what is asked, without the checks of a file.
fn ask(controller: &mut Controller, changes: &[Change]) {
    let gain = factor(changes, |s| matches!(s, Scaled::Gains));
    let weight = factor(changes, |s| matches!(s, Scaled::Weights));
    let target = 0.3 * factor(changes, |s| matches!(s, Scaled::References));
    let names: Vec<String> = controller.task_names().map(str::to_owned).collect();
    for (i, name) in names.iter().enumerate() {
        // Refused where it is not finite, or of another size.
        if i % 2 == 0 {
            let _ = controller.reweight(name, weight);
        }
        let _ = controller.follow(name, Hold::at([target, -target, 0.5 * target]));
        let _ = controller.follow(name, Hold::at([target, -target]));
        let _ = controller.follow(name, Hold::at([target]));
        let kp = 20.0 * gain;
        if let Ok(task) = controller.parameters_mut::<Posture>(name) {
            (task.kp, task.kd) = (kp.into(), kp.into());
        }
        if let Ok(task) = controller.parameters_mut::<BasePosition>(name) {
            (task.kp, task.kd) = (kp.into(), kp.into());
        }
        if let Ok(task) = controller.parameters_mut::<BaseOrientation>(name) {
            (task.kp, task.kd) = (kp.into(), kp.into());
        }
        if let Ok(task) = controller.parameters_mut::<FreeMotion>(name) {
            (task.kp, task.kd) = (kp.into(), kp.into());
        }
        if let Ok(task) = controller.parameters_mut::<ContactForce>(name) {
            (task.kp, task.ki) = (0.1 * gain, gain);
        }
    }
}

/// A robot whose actuators have a slew, some of them no limit.
fn with_slew(scene: &Scene, rng: &mut ChaCha8Rng) -> RobotModel {
    let mut robot = scene.robot();
    let is_free = rng.random_bool(0.2);
    for actuator in &mut robot.actuators {
        actuator.slew = 10_f64.powf(rng.random_range(0.0..4.0));
        if is_free && rng.random_bool(0.5) {
            (actuator.lower, actuator.upper) = (f64::NEG_INFINITY, f64::INFINITY);
        }
    }
    robot
}

/// Whether the solver's own effort variables are what was sent, but for rounding.
fn is_honest(controller: &Controller) -> bool {
    let (qp, solution) = (controller.problem(), controller.solution());
    let robot = controller.robot();
    qp.vars().iter().zip(&solution.x).all(|(id, x)| {
        let info = controller.variable(*id).expect("has a name");
        let found = robot.actuators.iter().position(|a| a.name == info.owner);
        let Some(index) = found.filter(|_| info.label == "effort") else {
            return true;
        };
        let actuator = &robot.actuators[index];
        let range = actuator.upper - actuator.lower;
        let size = if range.is_finite() { range } else { x.abs() };
        (x - controller.command().effort[index]).abs() <= 2e-9 * size
    })
}

fn check(controller: &Controller, before: &Command, context: &dyn Fn() -> String) {
    let (robot, command, report) = (
        controller.robot(),
        controller.command(),
        controller.report(),
    );
    assert!(
        is_within_bounds(robot, command),
        "{}\n{command:?}",
        context()
    );
    let efforts = command.effort.iter().zip(&before.effort);
    for ((now, last), actuator) in efforts.zip(&robot.actuators) {
        assert!(
            (now - last).abs() <= actuator.slew * PERIOD,
            "{}: {last} to {now}, slew {}",
            context(),
            actuator.slew
        );
    }
    let is_optimal = report.level == FallbackLevel::Optimal;
    assert_eq!(is_optimal, report.fault.is_none(), "{}", context());
    if let Some(cut) = report.cut {
        let Fault::CutEffort { actuator, sent, .. } = cut else {
            panic!("{cut:?} is no cut: {}", context());
        };
        assert!(!is_optimal, "{}", context());
        assert_eq!(sent, command.effort[actuator.index()]);
        let actuator = &robot.actuators[actuator.index()];
        if let Some(Fault::CutEffort { .. }) = report.fault {
            assert_eq!(report.fault, report.cut);
            let text = controller.explain().expect("a fault");
            assert!(text.contains(&format!("`{}`", actuator.name)), "{text}");
        }
    }
    assert!(!is_optimal || is_honest(controller), "{}", context());
}

fn live(scene: &Scene, rng: &mut ChaCha8Rng, changes: &[Change], from: usize) -> [usize; 4] {
    let mut config = scene.config();
    if rng.random_bool(0.3) {
        // Nothing but the gate keeps the actuators' limits.
        let is_other = |entry: &Entry<dyn AnyConstraint>| entry.name != "limits";
        config.constraints.retain(is_other);
    }
    if rng.random() {
        // Everything goes on into the problem.
        config.measurement = MeasurementLimits::ANY;
    }
    let robot = with_slew(scene, rng);
    let mut controller = Controller::with_robot(config, robot).expect("the scene is valid");
    let start = scene.measurement();
    let mut levels = [0; 4];
    for tick in 0..LIFE {
        let mut measurement = start.clone();
        measurement.time = tick as f64 * PERIOD;
        if tick == from {
            ask(&mut controller, changes);
        }
        if tick >= from {
            scale(&mut measurement, changes);
        }
        let before = controller.command().clone();
        controller.tick(&measurement);
        check(&controller, &before, &|| {
            format!(
                "{scene:?}, tick {tick}, {changes:?}: {:?}",
                controller.report()
            )
        });
        levels[controller.report().level as usize] += 1;
    }
    levels
}

fn random_scene(kind: Kind, seed: u64, rng: &mut ChaCha8Rng) -> Scene {
    let mut scene = Scene::new(kind, seed, rng.random(), rng.random());
    scene.hard_contacts = rng.random();
    scene.soft_cones = rng.random();
    scene.formulation = [
        Formulation::TorqueEliminated,
        Formulation::Condensed,
        Formulation::Explicit,
    ][rng.random_range(0..3)];
    scene
}

#[test]
fn every_power_of_ten_leaves_commands_within_limits_and_slew() {
    let mut levels = [0_usize; 4];
    for life in 0..lives() {
        let mut rng = ChaCha8Rng::seed_from_u64(life as u64);
        let scene = random_scene(KINDS[life % KINDS.len()], life as u64, &mut rng);
        let changes: Vec<Change> = (0..rng.random_range(1..4))
            .map(|_| {
                let most = [10, 40, 300][rng.random_range(0..3)];
                (ALL[rng.random_range(0..8)], rng.random_range(-most..=most))
            })
            .collect();
        let from = rng.random_range(0..LIFE / 2);
        let lived = live(&scene, &mut rng, &changes, from);
        for (sum, ticks) in levels.iter_mut().zip(lived) {
            *sum += ticks;
        }
    }
    println!("ticks by level: {levels:?}");
    assert!(levels.iter().all(|ticks| *ticks > 0), "{levels:?}");
}

/// Joint velocities of 1e8, tool forces of 1e20, positions of 1e28: where ticks called themselves optimal that were
/// not.
#[test]
fn sizes_at_which_solutions_stop_being_right() {
    for (what, power) in [
        (Scaled::JointVelocities, 8),
        (Scaled::Wrenches, 20),
        (Scaled::BasePosition, 28),
        (Scaled::Gains, 12),
    ] {
        for kind in KINDS {
            for seed in 0..10 {
                let mut rng = ChaCha8Rng::seed_from_u64(seed);
                let mut scene = Scene::new(kind, seed, u32::MAX, u32::MAX);
                scene.formulation = Formulation::Auto;
                // Another half of the seeds takes anything that is measured.
                live(&scene, &mut rng, &[(what, power)], 3);
            }
        }
    }
}

/// Without a constraint that keeps them, limits are kept by the gate, and the tick says whose.
#[test]
fn an_effort_that_is_cut_is_a_fault_with_its_actuators_name() {
    let scene = Scene::new(Kind::FixedArm, 3, u32::MAX, 0);
    let mut config = scene.config();
    config.constraints.clear();
    let mut robot = scene.robot();
    for actuator in &mut robot.actuators {
        (actuator.lower, actuator.upper) = (-1e-3, 1e-3);
    }
    config.constraints.push(Entry::new(
        "motion",
        1.0,
        Hardness::Soft,
        Box::new(wbqp_tasks::ContactMotion::new("contact_0".to_owned())),
    ));
    let mut controller = Controller::with_robot(config, robot).expect("valid");
    controller.tick(&scene.measurement());
    let report = controller.report();
    assert_eq!(report.level, FallbackLevel::Relaxed);
    assert_eq!(report.fault, report.cut);
    let Some(Fault::CutEffort {
        actuator,
        asked,
        sent,
    }) = report.cut
    else {
        panic!("{:?}: nothing was cut", report.fault);
    };
    assert!(asked.abs() > 1e-3 && sent.abs() == 1e-3);
    let name = &controller.robot().actuators[actuator.index()].name;
    let text = controller.explain().expect("a fault");
    let said = format!("relaxed: the effort of actuator `{name}` had to be cut to its limits");
    assert!(text.starts_with(&said), "{text}");
}
